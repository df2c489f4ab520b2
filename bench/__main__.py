"""`python -m bench [--quick] [--own] [--models NAME,...] [--docs]`; see `make bench`.
`python -m bench accuracy [--quick] [--only TEXT] [--docs]` judges what scenes promise: accuracy.py
`python -m bench kept [--quick] [--docs]` the same of hundreds of scenes, more briefly: kept.py
`python -m bench answers` judges what charts answer: answers.py
`python -m bench reductions [--quick] [--docs]` measures what scenes save: reductions.py
`python -m bench systems [--docs]` runs every scene of every model: systems.py
`python -m bench side_by_side [--docs]` beside physicskit at its published settings: side_by_side.py
`python -m bench rotations [--docs]` what rotations and constraints cost: rotations.py
`python -m bench arms [--quick] [--docs]` arms beside Pinocchio and MuJoCo: arms.py
`python -m bench show [--docs]` opens the live page of every model: show.py
`python -m bench published [--docs]` problems that others publish: published.py
`python -m bench bodies [--docs]` residuals and drifts over a million steps: bodies.py
`python -m bench exports [--docs]` every model to the hosts that run it whole: exports.py
`python -m bench scale [--docs]` what sweeps of 1e6 to 1e12 members cost: scale.py
`python -m bench member_lanes [--docs]` members in lanes, beside one by one: member_lanes.py
`python -m bench members [--docs]` members a second and core beside other packages: members.py
`python -m bench world [--contacts] [--python PY] [--docs]` models beside other packages: world/
`python -m bench derivatives [--docs]` gradients, fits, linear models beside others: derivatives.py
`python -m bench families [--docs]` what loops can do, beside members written out: families.py

What is measured: kernels.py, measure.py, ensembles.py, chains.py, longrun.py, derivation.py
Who takes part: peers/, one adapter each; c/, what is compiled, a folder for each part
How it is timed: contender.py and turns.py take turns; matching.py: time at equal error
Against what: models.py (Lagrangians in SymPy), codegen.py (their C), reference.py (exact finals)
With what: environment.py (the peers' Python), builds.py (compilers, flags), machine.py
What is said: targets.py (figures to reach), tables.py, chart.py, report.py (docs and README)
"""

from __future__ import annotations

import argparse
import importlib
import os
import sys
import time
import traceback
from collections.abc import Callable

from . import (
    chains,
    chart,
    derivation,
    ensembles,
    kernels,
    longrun,
    machine,
    measure,
    models,
    reference,
    tables,
    targets,
)
from .builds import OUTPUT, Broken, Refused
from .peers import cvode, gsl, mechanicsdsl, own, python, taylor
from .report import write_docs

# Each a command of its own; those that import pkgen are not for the peers' Python.
ALONE = (
    "accuracy",
    "answers",
    "kept",
    "reductions",
    "systems",
    "side_by_side",
    "rotations",
    "arms",
    "bodies",
    "show",
    "published",
    "families",
    "member_lanes",
    "exports",
    "scale",
    "members",
    "world",
    "derivatives",
)
PEERS = (own, gsl, cvode, taylor, mechanicsdsl, python)


def main() -> int:
    if sys.argv[1:] and sys.argv[1] in ALONE:
        return importlib.import_module(f".{sys.argv[1]}", __package__).main(sys.argv[2:])
    arguments = _arguments()
    effort = measure.QUICK if arguments.quick else measure.FULL
    effort = measure.ALONE if arguments.own else effort
    names = arguments.models.split(",") if arguments.models else list(models.LAGRANGIANS)
    OUTPUT.mkdir(parents=True, exist_ok=True)
    here = machine.describe()
    _say("\n".join(here.lines()))
    begin = time.monotonic()
    # Titles in the order in which they are shown; each part is text, rows are figures to reach.
    parts: dict[str, str] = {"Figures to reach": ""}
    rows: list[targets.Row] = []
    timings: dict[str, kernels.Timing] = {}
    comparisons: list[measure.Comparison] = []
    steps: dict[str, Callable[[], Refused]] = {
        "Methods": lambda: _methods(arguments.own, names, effort, parts, rows, comparisons)
    }
    if not arguments.own:
        steps = {
            "Kernels": lambda: _kernels(effort, parts, rows, timings),
            **steps,
            "Ensembles": lambda: _ensembles(effort, parts, rows),
            "Chains": lambda: _chains(effort, parts, rows),
            "Long run": lambda: _long_run(effort, parts, rows),
            "Derivation": lambda: _derivation(parts, rows),
        }
    failed = _measured(steps)
    parts["Figures to reach"] = tables.targets(rows, names)
    spent = time.monotonic() - begin
    _say(f"measured in {spent:.0f} s; load average at the end {os.getloadavg()[0]:.2f}")
    for title, text in parts.items():
        print(f"\n## {title}\n\n{text}")
    _save(comparisons, timings, rows, here)
    if arguments.docs and not failed:
        write_docs(parts, here, effort)
    for why in failed:
        _say(f"bench: failed: {why}")
    return 1 if failed else 0


def _measured(steps: dict[str, Callable[[], Refused]]) -> list[str]:
    """Which parts failed, and why; the others are measured all the same."""
    failed = []
    for title, step in steps.items():
        try:
            refused = step()
        except (Exception, SystemExit) as error:
            traceback.print_exc()
            refused = {type(error).__name__: Broken(str(error))}
        broken = [(name, why) for name, why in refused.items() if isinstance(why, Broken)]
        failed += [f"{title}: {name}: {why}" for name, why in broken]
    return failed


def _kernels(effort, parts, rows, timings) -> Refused:
    found, refused = kernels.measure(effort, _say)
    timings.update(found)
    parts["Kernels"] = _with(tables.kernels(timings), refused)
    rows += targets.kernel_rows(timings)
    return refused


def _methods(alone: bool, names, effort, parts, rows, comparisons) -> Refused:
    sources = PEERS[:1] if alone else PEERS
    contenders = [c for source in sources for c in source.contenders()]
    refused = {}
    for name in names:
        model = models.model(name)
        exact = reference.finals(model, model.starts(effort.starts))
        found = measure.compare(model, contenders, exact, effort, _say)
        parts[name.replace("_", " ").capitalize()] = _with(tables.methods(found), found.refused)
        comparisons.append(found)
        refused |= {f"{name}, {who}": why for who, why in found.refused.items()}
    rows += targets.method_rows(comparisons)
    return refused


def _ensembles(effort, parts, rows) -> Refused:
    timings, batch, refused = ensembles.measure(effort, _say)
    text = tables.turns("RK4 step of a double pendulum in an ensemble", timings)
    parts["Ensembles"] = _with(text, refused)
    rows += targets.ensemble_rows(timings, batch)
    return refused


def _chains(effort, parts, rows) -> Refused:
    found, refused = chains.measure(effort, _say)
    parts["Chains"] = _with(tables.chains(found), refused)
    rows += targets.chain_rows(found)
    return refused


def _long_run(effort, parts, rows) -> Refused:
    found = longrun.measure(effort, _say)
    parts["Long run"] = (
        f"gauss8, {longrun.STEPS_A_PERIOD} steps a period, {found.starts} starts of"
        f" {found.periods:,} periods, {found.flags}: rms relative energy error {found.rms:.2g},"
        f" growth exponent {found.exponent:.2f}"
    )
    rows += targets.long_rows(found)
    return {}


def _derivation(parts, rows) -> Refused:
    found = derivation.measure()
    parts["Derivation"] = tables.derivation(found)
    rows += targets.derivation_rows(found)
    return {}


def _with(text: str, refused: Refused) -> str:
    """A table, and below it who could not take part."""
    missing = "\n".join(f"- {name}: {why}" for name, why in refused.items())
    return "\n\n".join(filter(None, (text, missing)))


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m bench")
    parser.add_argument("--quick", action="store_true", help="a few minutes, fewer starts")
    parser.add_argument("--own", action="store_true", help="pkgen's methods alone, for the tests")
    parser.add_argument("--models", help="names, separated by commas; default: all five")
    parser.add_argument("--docs", action="store_true", help="write docs/dev/results/benchmarks.md")
    return parser.parse_args()


def _save(comparisons, timings, rows, here) -> None:
    tables.write_csv(
        OUTPUT / "points.csv",
        ("model", "contender", "setting", "start", "round", "seconds", "error"),
        tables.points(comparisons),
    )
    tables.write_csv(
        OUTPUT / "builds.csv",
        ("model", "contender", "build", "seconds", "taken"),
        tables.builds(comparisons, timings),
    )
    tables.write_csv(
        OUTPUT / "targets.csv",
        ("what", "at least", "model", "measured", "verdict"),
        ((r.what, r.least, m, x, r.verdict) for r in rows for m, x in r.values.items()),
    )
    try:
        chart.draw(comparisons, timings, here, OUTPUT / "chart.png")
        saved = "points.csv, builds.csv, targets.csv, chart.png, chart.svg"
    except ImportError:
        saved = "points.csv, builds.csv, targets.csv (no chart: matplotlib is missing)"
    _say(f"in {OUTPUT}: {saved}")


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
