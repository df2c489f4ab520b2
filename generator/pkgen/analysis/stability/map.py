"""Makes the stability map of a compiled model, with predictions."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import FIRST_EXCEPTION, Future, ThreadPoolExecutor, wait
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import TypeVar

from ...compiler import Compilation
from ...middle.analyze import affine
from ...middle.quantities import single_rotations
from ...record import record
from ...run.build import build_library
from ...system import children
from ...system.exits import UsageError
from ...system.progress import Show, unseen
from ..linear.rest import Rest
from ..linear.system import TimeUp
from . import budget, cycles, measure, plan
from .ask import Asker, Motion
from .budget import ROWS, SERIAL, Clock, Cut
from .cycles import Cycle
from .ghosts import Ghost, ghosts
from .measure import Growth, Measured, Row
from .method import StepMap
from .predict import PAIRS, RESONANCES, Prediction, predictions
from .steps import MapOptions, refuse_unjudged, steps_over

LEAST_ROWS = 2  # an interrupted map must have at least these rows
REFUSED = "PK_REFUSED"
Made = TypeVar("Made")


@record
class StabilityMap:
    """All results; the picture, the page and the summary are made from them."""

    compilation: Compilation
    asked: MapOptions
    until: float
    motion: Motion  # only the start: the fields of an integrated motion have no values
    rest: Rest  # the equilibria, for the model's own start and parameters
    primary: int | None
    rows: tuple[Row, ...]
    steps: dict[str, tuple[float, ...]]
    predictions: tuple[Prediction, ...]  # for the model's own start and parameters
    measured: tuple[Measured, ...]
    growths: tuple[Growth, ...]
    interrupted: str = ""  # if the map was interrupted: a text that says how much is complete
    cycle: Cycle | None = None  # the limit cycle that the motion approaches
    lost: tuple[cycles.Lost, ...] = ()
    ghosts: tuple[Ghost, ...] = ()
    turned: range = range(0)  # indices of quaternion components among the rates v

    def place(self, state: tuple[float, ...]) -> float:
        """Returns the value of the varied quantity, the vertical axis, for a state (q, v)."""
        at = None if self.primary is None else self.rest.equilibria[self.primary]
        return self.asked.axis.place(state, at, self.motion)


def make(
    compilation: Compilation, asked: MapOptions, on_progress: Show | None = None
) -> StabilityMap:
    """Makes the map. Raises NumericsFailed, BuildError, UsageError."""
    structure = compilation.structure
    if structure.cyclic and all(structure.cyclic) and structure.conservative:
        raise UsageError(
            f"every coordinate of {compilation.model.name} is cyclic: their momenta are constant, "
            "the motion goes on evenly by any method and step, and there is nothing to map"
        )
    show = on_progress or unseen
    show(0.0, "compiling")
    program = build_library(
        compilation.files, compilation.model.name, own=compilation.model.methods
    )
    show(0.0, "equilibria")
    clock = Clock(asked.seconds, os.cpu_count() or 1)
    asker = Asker(program, asked.settings)
    rest, motion = asker.rest(), asker.initial()
    if asked.axis.kind == "parameter":
        for x in (asked.axis.values[0], asked.axis.values[-1]):  # checks the bounds
            asker.with_settings(asked.axis.settings(asked.settings, x, None, motion))
    model = compilation.model
    bound, turned = bool(model.rotations or model.constraints), _quaternions(compilation)
    cyclic = frozenset(i for i, c in enumerate(structure.cyclic) if c)
    primary = plan.nearest(rest, motion.q, cyclic)
    going = any(v for i, v in enumerate(motion.v) if i not in turned)
    if bound and primary is not None and (going or not rest.equilibria[primary].stable):
        primary = None  # no small motion about an equilibrium: a body rotates or rolls
    at = plan.beside(rest, primary, motion.q, cyclic)
    if at is None and asked.axis.kind == "amplitude":
        asked = replace(asked, axis=plan.without_equilibrium(asked.axis, motion, turned))
    if plan.still(asked.axis, at, motion, cyclic, structure.autonomous):
        alike = "the start is 0, and so are its multiples: one row is mapped (--start, --vary)"
        axis = replace(asked.axis, values=(1.0,))
        asked = replace(asked, axis=axis, left=(*asked.left, alike))
    until = plan.duration(at, asked.until)
    asker = asker.with_settings(replace(asked.settings, until=until))

    def started(x: float) -> Asker:
        begun = asked.axis.settings(asker.settings, x, at, motion, turned)
        if bound and asked.axis.kind != "parameter":
            return asker.onto(begun, motion)
        return asker.with_settings(begun)

    show(0.0, "methods")
    asked = _without_refused(asked, asker) if bound else asked
    plain = structure.mass_constant and compilation.equations.dense and not bound
    linear = structure.affine or (plain and affine.linear(compilation.equations))
    of_all = motion.by_norm, bound, bool(turned), linear
    maps = {m.name: StepMap(m, asker, *of_all) for m in asked.methods}
    moves = asked.axis.kind == "parameter" or any(cyclic)
    tries = 40 if moves else 100

    rates = asker.rates()
    cycle = None if bound else _cycle(compilation, asked, asker, rest, motion)
    until = plan.duration(at, asked.until, cycle)
    asker = asker.with_settings(replace(asked.settings, until=until))
    lost: dict[str, cycles.Lost | None] = {}
    for name in maps if cycle else ():
        show(0.0, f"cycle of {name}")
        with suppress(TimeUp):
            lost[name] = cycles.lost(asker.within(partial(clock.left, SERIAL)), name, cycle)
    if cycle and len(lost) < len(maps):
        late = (
            f"time was up before the cycle was followed by {', '.join(maps.keys() - lost.keys())}"
        )
        asked = replace(asked, left=(*asked.left, late))
    predicted = {}
    for name, step in maps.items():
        whole = cycles.predictions(cycle, lost.get(name))
        # If there are predictions from the multipliers of a cycle, the eigenvalues along the cycle
        # are not used.
        predicted[name] = [*predictions(step, rest, primary, () if whole else rates), *whole]
    fastest = max((m.rate for m in (at.modes if at else rates)), default=0.0)
    # The range of step sizes covers all predictions. If the equilibrium is stable, rough ones from
    # the fastest rate along the motion ("local") do not count.
    scales = [] if at and at.stable else ["local"]
    about = {name: [p for p in predicted[name] if at or p.equilibrium is None] for name in maps}
    steps = {name: tuple(steps_over(asked, about[name], scales, fastest, until)) for name in maps}

    refuse_unjudged(started(x).motion() for x in asked.axis.values)

    show(0.0, "what a point takes")
    asked, steps = _reduced(asked, steps, started, clock)
    maps = {name: maps[name] for name in steps}

    def one(x: float, enough: Callable[[], float]) -> Row:
        here = started(x).within(enough)
        found, moved, points = measure.row(here, steps, None if moves else rest, tries, linear)
        # If the amplitude is varied, it is the distance from the same equilibrium in all rows.
        place = at.q if at and asked.axis.kind == "amplitude" else moved.q
        number = plan.nearest(found, place, cyclic) if at or not bound else None
        rates_here = here.rates() if moves else ()
        lines = [
            p
            for name, step in maps.items()
            for p in (predictions(step, found, number, rates_here) if moves else predicted[name])
        ]
        return Row(x, found, number, moved, tuple(lines), points)

    flat = tuple(p for name in maps for p in predicted[name])
    # Resonances are measured last, since time may run out.
    flat = tuple(sorted(flat, key=lambda p: p.kind in (*RESONANCES, *PAIRS)))
    size = plan.apart(at, motion.q, cyclic) if at else 0.0
    amplitude = measure.small(rest, cyclic, size)
    effort = measure.QUICK if asked.quick else measure.FULL
    jobs = len(asked.axis.values) + len(flat) + len(maps) + 1
    ended = 0
    show(0.0, f"0 of {jobs}")

    def counted(make: Callable[[], Made]) -> Made:
        nonlocal ended
        try:
            result = make()
        except TimeUp:
            result = None
        if children.ended():  # interrupted during make()
            raise KeyboardInterrupt
        ended += 1
        show(ended / jobs, f"{ended} of {jobs}")
        return result

    clock.threads()
    timed = asker.within(clock.left)
    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        # Coarse rows are computed before the rows between them.
        xs = asked.axis.values
        rows = [
            # The first two rows get three times the budget, so that they complete.
            pool.submit(counted, partial(one, xs[k], partial(clock.left, ROWS if i > 1 else 3)))
            for i, k in enumerate(_spread(len(xs)))
        ]
        of = size, amplitude, effort, bound
        checks = [
            pool.submit(counted, partial(measure.measured, timed, rest, p, *of)) for p in flat
        ]
        haunted = [
            pool.submit(counted, partial(ghosts, timed, name, steps[name], asked.quick))
            for name in (maps if rest.status != "PK_REFUSED" and not bound else ())
        ]
        leaving = pool.submit(counted, partial(measure.growths, timed, rest, amplitude))
        every = [*rows, *checks, *haunted, leaving]
        with suppress(KeyboardInterrupt):
            wait(every, return_when=FIRST_EXCEPTION)
        pool.shutdown(cancel_futures=True)  # after a failure, queued jobs do not start
    found = tuple(sorted(_kept(rows), key=lambda row: row.x))
    checked, growing = tuple(_kept(checks)), next(iter(_kept([leaving])), [])
    interrupted = ""
    done = (
        f"{len(found)} of {len(rows)} values of {asked.axis.name} are mapped, "
        f"{len(checked)} of {len(checks)} predictions measured"
    )
    if children.ended():
        if len(found) < LEAST_ROWS:
            raise KeyboardInterrupt
        interrupted = f"interrupted: {done}"
    elif len(found) < len(rows) or len(checked) < len(checks):
        late = f"time was up: {done}; --seconds {10 * asked.seconds:.0f} allows for more"
        asked = replace(asked, left=(*asked.left, late))
    asked = replace(asked, axis=replace(asked.axis, values=tuple(row.x for row in found)))
    begun = until, motion, rest, primary
    told = flat, checked, tuple(growing), interrupted
    losses = tuple(one for one in lost.values() if one)
    seen = tuple(ghost for one in _kept(haunted) for ghost in one)
    return StabilityMap(
        compilation, asked, *begun, found, steps, *told, cycle, losses, seen, turned
    )


def _spread(count: int) -> list[int]:
    """Returns 0 .. count - 1 in bit-reversed order, so that an interrupted map is a coarser map."""
    bits = (count - 1).bit_length()
    return sorted(range(count), key=lambda k: int(f"{k:0{bits}b}"[::-1], 2))


def _kept(futures: list[Future[Made]]) -> list[Made]:
    """Returns the results of the completed jobs, except those that are None. Raises the exception
    of a failed job."""
    found = []
    for future in futures:
        if future.done() and not future.cancelled():
            with suppress(KeyboardInterrupt):
                found.append(future.result())
    return [one for one in found if one is not None]


def _cycle(
    compilation: Compilation, asked: MapOptions, asker: Asker, rest: Rest, motion: Motion
) -> Cycle | None:
    """Returns the cycle that the motion approaches, or None; conservative systems have none."""
    if compilation.structure.conservative and not motion.by_norm:
        return None
    period = asked.period or cycles.driven_period(compilation.equations, motion.parameters)
    if period is None and rest.status == "PK_REFUSED":
        return None
    cycle = cycles.find(asker, period)
    return cycle if cycle and cycle.stays else None


def _reduced(
    asked: MapOptions, steps: dict, started: Callable[[float], Asker], clock: Clock
) -> tuple[MapOptions, dict[str, tuple[float, ...]]]:
    """Measures the cost of some points of the map. Returns options, with fewer points or methods if
    necessary, and step sizes such that the map can be computed in the time budget."""
    here = started(asked.axis.values[len(asked.axis.values) // 2]).within(partial(clock.left, 3))
    here.motion()
    whole = Cut(len(asked.axis.values), asked.across, tuple(steps))
    costs = budget.cost(here.point, steps, clock.left(SERIAL) / 2)
    part = budget.cut(costs, whole.up, whole.across, clock.cores * clock.left(ROWS))
    told = budget.told(whole, part, clock.seconds)
    axis = replace(asked.axis, values=budget.fewer(asked.axis.values, part.up))
    taken = tuple(m for m in asked.methods if m.name in part.methods)
    left = (*asked.left, *told)
    asked = replace(asked, axis=axis, across=part.across, methods=taken, left=left)
    return asked, {name: budget.fewer(steps[name], part.across) for name in part.methods}


def _without_refused(asked: MapOptions, asker: Asker) -> MapOptions:
    """Drops methods that refuse the model's rotations or constraints, found by a trial run. Raises
    UsageError if no method remains."""
    said = {m.name: asker.resolved(m.name, asker.settings.until, 0)[0] for m in asked.methods}
    left = [
        f"{name} is refused: not with these constraints" for name, s in said.items() if s == REFUSED
    ]
    taken = tuple(m for m in asked.methods if said[m.name] != REFUSED)
    if not taken:
        raise UsageError(f"--methods: none can be mapped; {'; '.join(left)}")
    return replace(asked, methods=taken, left=(*asked.left, *left))


def _quaternions(compilation: Compilation) -> range:
    """Returns the indices of quaternion components among the rates v."""
    count = len(single_rotations(compilation.model))
    # Body rates come before quaternions in v, and are not counted as first-order variables here.
    first = compilation.equations.own
    return range(first, first + 4 * count)
