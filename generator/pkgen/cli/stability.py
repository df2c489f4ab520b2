"""`pkgen stability`: maps the step sizes at which integration methods are stable."""

from __future__ import annotations

import argparse
import time
from dataclasses import asdict
from pathlib import Path

from ..analysis.chart.chart import methods as all_methods
from ..analysis.stability import budget, plan, text
from ..analysis.stability import map as maps
from ..analysis.stability.cycles import Cycle
from ..analysis.stability.map import StabilityMap
from ..analysis.stability.misses import misses, unmeasured, unpredicted
from ..analysis.stability.orbits import Orbit
from ..analysis.stability.predict import Prediction
from ..analysis.stability.steps import MapOptions
from ..compiler import Compilation
from ..indices import multiplied
from ..middle.refused import refuse_statements
from ..own.given import given
from ..plot.style import Look
from ..scenes import run_settings as parsing
from ..scenes.compile_plan import planned, whole
from ..system.exits import DONE, INTERRUPTED, UsageError
from ..system.files import scratch
from ..system.progress import progress, say
from . import arguments as shared
from .compilation import compile_within_limits
from .pictures import look_of, page_of, show_result, with_texts

EXAMPLES = """
pkgen stability models/elastic_pendulum.lag -o maps
pkgen stability models/double_pendulum.lag --methods verlet,rk4 --quick
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    shared.as_of_a_run(parser)
    shared.directory(parser)
    shared.own_methods(parser)
    shared.of_a_motion(parser, f"{plan.PERIODS} periods of the slowest mode or of the cycle")
    full, quick = ("x".join(map(str, size)) for size in (plan.FULL, plan.QUICK))
    usual = f"default {budget.FULL:g}; --quick {budget.QUICK:g}"
    text = f"""
        --vary     NAME=LO..HI  a start or a parameter (default: the amplitude)
        --methods  LIST         only these, e.g. verlet,rk4 (default: one a family)
        --steps    LO..HI       default: to somewhat beyond the predicted limits
        --period   T            of what drives the model, where it is not sines of time
        --points   NxM          steps x values (default {full})
        --quick    -            {quick} points, and resonances measured with less
        --seconds  S            of all but drawing ({usual}): fewer points
    """
    shared.rows(parser, text)
    shared.of_a_look(parser)
    shared.of_implicit_methods(parser)
    parser.set_defaults(method="rk4")  # settings need a method, which maps ignore


def run(options: argparse.Namespace) -> int:
    """Map where each method fails, over the step and a start or parameter, with predictions."""
    began = time.monotonic()
    look, directory = look_of(options), parsing.directory(options.directory)
    compilation = compile_within_limits(options, unroll=None, use=whole(options))
    _refuse_unmapped(compilation)
    asked = _asked(options, compilation)
    with progress(compilation.model.name) as show:
        made = maps.make(compilation, asked, show)
    files = _write(directory, made, look)
    show_result(options, record(made), text.report(made), files, began)
    if made.interrupted:
        say(made.interrupted)
    return INTERRUPTED if made.interrupted else DONE


def _refuse_unmapped(compilation: Compilation) -> None:
    """Raises UsageError for models without a stability map: those with redundant constraints, and
    those whose rates jump, since a step would have to end at each jump."""
    model = compilation.model
    refuse_statements(model, "pkgen stability")
    impulsive = getattr(compilation.equations, "impulsive", ())
    if impulsive:
        raise UsageError(
            f"{model.source.path}: the rates jump where {impulsive[0].quantity.name} vanishes, and"
            " 'pkgen stability' locates no switches: 'pkgen chart' does"
        )
    bound = getattr(compilation.equations, "constraints", None)
    if bound is not None and bound.redundant is not None:
        name = multiplied(bound.redundant.names[0].name)
        raise UsageError(
            f"{model.source.path}: '{name}' follows from other constraints, and 'pkgen stability' "
            "takes none that do: leave it out"
        )


def _asked(options: argparse.Namespace, compilation: Compilation) -> MapOptions:
    across, up = plan.numbers(options.points, options.quick)
    own, wanted = compilation.model.methods, options.methods
    if wanted is not None:
        wanted = ",".join((wanted, *(method.name for method in given(options))))
    known = all_methods(None, own)
    bound = bool(compilation.model.rotations or compilation.model.constraints)
    taken, left = plan.methods(wanted, known, compilation.structure, [m.name for m in own], bound)
    values = parsing.Values(compilation)
    steps = None
    if options.steps is not None:
        if ".." not in options.steps:
            raise UsageError(f"--steps {options.steps}: give a range, e.g. --steps 0.01..0.5")
        steps = plan.span("--steps", options.steps, values, values.time, "steps")
        if not steps[0] > 0:
            raise UsageError(f"--steps {options.steps}: steps must be positive")
    return MapOptions(
        plan.settings(options, compilation),
        plan.axis(options.vary, compilation, up),
        across,
        tuple(taken),
        tuple(left),
        steps,
        planned(options, compilation).numbers.until,
        values.positive("--period", options.period, values.time),
        options.quick,
        values.positive("--seconds", options.seconds, "s")
        or (budget.QUICK if options.quick else budget.FULL),
    )


def _write(directory: Path, made: StabilityMap, look: Look) -> list[Path]:
    from ..analysis.stability import draw

    html = page_of("stability")
    with scratch() as folder:
        stem = folder / f"{made.compilation.model.name}_stability"
        files = draw.pictures(made, stem, look)
        contents = {".csv": text.as_csv(made)} | ({".html": html(made, files[0])} if html else {})
        return with_texts(files, directory, stem, contents)


def orbit(one: Orbit) -> dict[str, object]:
    """Returns a periodic orbit as data: multipliers as [real, imaginary], states as [*q, *v]."""
    multipliers = [[z.real, z.imag] for z in one.multipliers]
    return {"h": one.h, "states": one.states, "multipliers": multipliers}


def prediction(one: Prediction) -> dict[str, object]:
    return {name: x for name, x in asdict(one).items() if name != "known"}


def cycle(one: Cycle | None) -> dict[str, object] | None:
    return one and {"period": one.period, "driven": one.driven, **orbit(one.orbit)}


def record(made: StabilityMap) -> dict[str, object]:
    """Returns the map as data for JSON."""
    return {
        "model": made.compilation.model.name,
        "until": made.until,
        "varied": {"name": made.asked.axis.name, "values": made.asked.axis.values},
        "equilibria": [{**asdict(e), "verdict": e.verdict} for e in made.rest.equilibria],
        "primary": made.primary,
        "predictions": [
            {**prediction(m.prediction), "measured": m.h, "how": m.how, "response": m.response}
            for m in made.measured
        ],
        "rows": [
            {
                "x": row.x,
                "energy": row.motion.energy,
                "motion": row.motion.status,
                "condition": row.motion.condition,
                "horizon": row.motion.horizon,
                "predictions": [prediction(p) for p in row.predictions],
            }
            for row in made.rows
        ],
        "unmeasured": unmeasured(made),
        "growths": [asdict(g) for g in made.growths],
        "cycle": cycle(made.cycle),
        "ghosts": [
            {"method": g.method, "kind": g.kind, "holds": g.holds, "stays": g.stays}
            | {"orbits": list(map(orbit, g.orbits))}
            for g in made.ghosts
        ],
        "misses": [asdict(m) for m in misses(made)],
        "unpredicted": unpredicted(made),
        "interrupted": bool(made.interrupted),
        "remarks": text.remarks(made),
        "points": [{"x": row.x, **asdict(p)} for row in made.rows for p in row.points],
    }
