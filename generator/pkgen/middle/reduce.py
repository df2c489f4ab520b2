"""Equations, Structure, Needs -> the same with less, and a Report of what went and why.

A reduction is a function that finds what can go; it stands in REDUCTIONS under the name by which
it is switched off. What a scene fixes or holds is not there when the equations are derived
(specialise.py); what nobody calls is left out when they are written (back/kernels.py).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

from ..equations import Equations, Structure
from .analyze import analyze
from .apart import Part, parts_of
from .count import operations
from .graph import ZERO, Graph, Kind
from .lagrange import NoRate, derived_again
from .motion import COORDINATES, STATE
from .quantities import symbols
from .report import Line, Report
from .routh import NotReduced, routh
from .smaller import smaller, symbols_in

# What must be known of equations to reduce them.
ENOUGH = frozenset({"acceleration"})
# Operations that a method itself takes for each number of the state at an evaluation: from some 7
# (rk4) to 16 (gauss).
OF_A_STATE = 10


@dataclass(frozen=True)
class Needs:
    """What is wanted of a motion. Columns are names as in the head of a CSV: "theta", "phi'"."""

    columns: frozenset[str]
    events: frozenset[str] = frozenset()
    quadratures: bool = True  # the method makes them
    apart: bool = True  # blocks may be integrated apart
    off: frozenset[str] = frozenset()  # reductions that are not to be made


@dataclass(frozen=True)
class State:
    """What one reduction hands to the next."""

    equations: Equations
    structure: Structure
    report: Report

    def after(self, equations: Equations, *lines: Line, **more: object) -> State:
        """With other equations, derived again if their coordinates are others."""
        if equations.coordinates != self.equations.coordinates:
            equations = derived_again(equations, ENOUGH)
        report = replace(self.report, lines=(*self.report.lines, *lines), **more)
        return State(equations, analyze(equations), report)


APART = "apart"  # the reduction that makes parts
# Of a whole whose parts are integrated apart: what is computed from its state.
OF_WHOLE = frozenset({"energy", "canonical", "observe", "conserve", "kinetic", "potential"})


@dataclass(frozen=True)
class Reduced:
    equations: Equations
    structure: Structure
    report: Report
    parts: tuple[Part, ...]  # none: it is integrated as it is


def of_the_whole(kernels: frozenset[str] | None) -> frozenset[str]:
    """Of the kernels asked for (None: all), those of a whole whose parts are integrated apart."""
    return OF_WHOLE if kernels is None else kernels & OF_WHOLE


def of_a_part(kernels: frozenset[str] | None) -> frozenset[str] | None:
    """And those of its parts."""
    return None if kernels is None else kernels - (OF_WHOLE - {"canonical"})


def reduce(
    equations: Equations, structure: Structure, needs: Needs, kernels: frozenset[str] | None
) -> Reduced:
    """No more equations than are needed, with the kernels asked for (None: all)."""
    state = State(equations, structure, Report())
    for name, reduction in REDUCTIONS.items():
        if name not in needs.off:
            state = reduction(state, needs)
    g, parts, lines = equations.graph, (), state.report.lines
    if APART not in needs.off and needs.apart:
        parts = parts_of(state.equations, state.structure, of_a_part(kernels))
    if parts:
        names = (", ".join(q.name for q in part.equations.coordinates) for part in parts)
        why = "neither moves the other: integrated apart"
        lines = (*lines, Line(APART, " | ".join(names), why))
        kernels = of_the_whole(kernels)
    lines = (*lines, *_of_itself(state.structure))
    reduced = derived_again(state.equations, kernels)
    moved = [part.equations for part in parts] or [reduced]
    report = replace(
        state.report,
        lines=lines,
        coordinates=(len(equations.coordinates), len(reduced.coordinates)),
        operations=(_cost(g, equations), sum(_cost(g, e) for e in moved)),
    )
    return Reduced(reduced, analyze(reduced), report, parts)


def _of_itself(structure: Structure) -> tuple[Line, ...]:
    """What follows from the structure, without anything that is left out."""
    lines = []
    if structure.mass_constant:
        lines.append(Line("constant mass", "M is constant", "factored once, when prepared"))
    if structure.affine:
        why = "stepped by its exact exponential, unless another method is asked for"
        lines.append(Line("exact", "linear with constant coefficients", why))
    return tuple(lines)


def _cost(g: Graph, equations: Equations) -> int:
    motion = equations.acceleration or (*equations.force, *sum(equations.mass, ()))
    return operations(g, [*motion, *equations.quadratures])


# -- outputs -------------------------------------------------------------------------------------


def outputs(state: State, needs: Needs) -> State:
    """Outputs that are not recorded are not computed, events that nobody asks for not looked for.
    A claim has been proved, and need not be watched."""
    e, lines = state.equations, []

    def kept(names: Iterable, what: str, wanted: Callable[[int], bool], why: str) -> list[int]:
        found = [wanted(i) for i, _ in enumerate(names)]
        gone = [q.name for q, keep in zip(names, found, strict=True) if not keep]
        if gone:
            lines.append(Line("outputs", f"{what} {', '.join(gone)}", why))
        return [i for i, keep in enumerate(found) if keep]

    observed = kept(
        e.observed_names,
        "observed",
        lambda i: e.observed_names[i].name in needs.columns,
        "not recorded, so not computed",
    )
    conserved = kept(
        e.conserved_names,
        "conserved",
        lambda i: e.conserved_names[i].name in needs.columns,
        "proved, so not watched",
    )
    events = kept(
        e.event_names,
        "event",
        lambda i: e.model.events[i].stop or e.event_names[i].name in needs.events,
        "nothing is asked of it, and it stops nothing",
    )
    if not lines:
        return state

    def pick(row: tuple, which: list[int]) -> tuple:
        return tuple(row[i] for i in which)

    return state.after(
        replace(
            e,
            model=replace(e.model, events=pick(e.model.events, events)),
            observed_names=pick(e.observed_names, observed),
            observed=pick(e.observed, observed),
            conserved_names=pick(e.conserved_names, conserved),
            conserved=pick(e.conserved, conserved),
            event_names=pick(e.event_names, events),
            events=pick(e.events, events),
        ),
        *lines,
    )


# -- coordinates without influence ---------------------------------------------------------------


def unconnected(state: State, needs: Needs) -> State:
    """A coordinate in whose absence all that is recorded moves the same is left at its start.

    One that shares a block of M with what is kept is not such a one, though no acceleration
    depends on it: its inertia has a part in them.
    """
    e, facts = state.equations, state.structure
    kept = set(_wanted(e, needs))
    waiting = list(kept)
    while waiting:
        i = waiting.pop()
        mates = next(block for block in facts.mass_blocks if i in block)
        new = {*facts.influences[i], *mates} - kept
        kept |= new
        waiting += new
    gone = [i for i in range(len(e.coordinates)) if i not in kept]
    if not gone or not kept:
        return state
    g, n = e.graph, len(e.coordinates)
    q, v = symbols(g, Kind.COORDINATE, n), symbols(g, Kind.RATE, n)
    swap = {q[i]: e.start_q[i] for i in gone} | {v[i]: ZERO for i in gone}
    names = [e.coordinates[i].name for i in gone]
    return state.after(
        smaller(e, sorted(kept), swap, e.lagrangian, (e.kinetic, e.potential)),
        Line("unconnected", ", ".join(names), "nothing recorded depends on it"),
        unused=state.report.unused | frozenset(names),
    )


def _wanted(e: Equations, needs: Needs) -> set[int]:
    """The coordinates of which something is recorded, or which an output or an event contains."""
    if "energy" in needs.columns:
        return set(range(len(e.coordinates)))
    names = {**_named(e.coordinates), **_named(e.rates)}
    nodes = [*e.observed, *e.conserved, *e.events]
    found = {names[column] for column in needs.columns if column in names}
    return found | {s.index for s in symbols_in(e.graph, nodes, STATE)}


def _named(quantities: tuple) -> dict[str, int]:
    return {q.name: i for i, q in enumerate(quantities)}


# -- cyclic coordinates --------------------------------------------------------------------------


def cyclic(state: State, needs: Needs) -> State:
    """Cyclic coordinates replaced by their constant momenta (routh.py)."""
    e, lines = state.equations, []
    found = [i for i, is_cyclic in enumerate(state.structure.cyclic) if is_cyclic]
    if not found:
        return state
    if not state.structure.quadratic:
        return _not(state, e, found, "L is not of second degree in the rates")
    used = _used(e)
    chosen, angles = [], []
    for i in found:
        name = e.coordinates[i].name
        if name in used:
            lines.append(Line("cyclic", f"{name} kept", f"it is in {used[name]}"))
        elif name in needs.columns and not needs.quadratures:
            lines.append(Line("cyclic", f"{name} kept", "the method makes no quadratures"))
        elif name in needs.columns and state.structure.affine:
            lines.append(Line("cyclic", f"{name} kept", "a linear system has an exact flow"))
        else:
            chosen.append(i)
            angles += [i] if name in needs.columns else []
    if len(chosen) == len(e.coordinates):
        lines.append(Line("cyclic", f"{e.coordinates[chosen[0]].name} kept", "one must move"))
        angles = [i for i in angles if i != chosen[0]]
        chosen = chosen[1:]
    state = replace(state, report=replace(state.report, lines=(*state.report.lines, *lines)))
    if not chosen:
        return state
    try:
        reduced = routh(e, chosen, angles)
        after = _recorded(state, needs, reduced, chosen, angles)
    except (NotReduced, NoRate) as why:
        return _not(state, e, chosen, str(why))
    before, now = _cost(e.graph, e), _cost(e.graph, after.equations)
    if now + OF_A_STATE * _states(after.equations) > before + OF_A_STATE * _states(e):
        return _not(state, e, chosen, f"{now} operations instead of {before}")
    return after


def _states(e: Equations) -> int:
    """The numbers that a method carries."""
    return 2 * len(e.coordinates) + len(e.quadratures)


def _not(state: State, e: Equations, which: list[int], why: str) -> State:
    names = ", ".join(e.coordinates[i].name for i in which)
    lines = (*state.report.lines, Line("cyclic", f"{names} kept", why))
    return replace(state, report=replace(state.report, lines=lines))


def _recorded(state: State, needs: Needs, reduced, chosen: list[int], angles: list[int]) -> State:
    """With no more rates of the angles than are recorded, and a line for each."""
    e, found = state.equations, reduced.equations
    extra = len(e.observed)
    keep = [i for i, q in enumerate(found.observed_names) if i < extra or q.name in needs.columns]
    found = replace(
        found,
        observed_names=tuple(found.observed_names[i] for i in keep),
        observed=tuple(found.observed[i] for i in keep),
    )
    lines = [
        Line(
            "cyclic",
            e.coordinates[i].name,
            f"{e.momenta_names[i].name} is constant, of the start"
            + ("; the angle is a quadrature" if i in angles else ""),
        )
        for i in chosen
    ]
    unused = {e.coordinates[i].name for i in chosen if i not in angles}
    return state.after(
        found,
        *lines,
        starts={**state.report.starts, **reduced.starts},
        unused=state.report.unused | unused,
    )


def _used(e: Equations) -> dict[str, str]:
    """Coordinates in what would have to know them: forces of others, outputs, events."""
    found: dict[str, str] = {}
    for what, nodes in (
        ("a force", e.applied),
        ("an output that is recorded", [*e.observed, *e.conserved]),
        ("an event", e.events),
    ):
        for symbol in symbols_in(e.graph, nodes, COORDINATES):
            found.setdefault(e.coordinates[symbol.index].name, what)
    return found


Reduction = Callable[[State, Needs], State]
REDUCTIONS: dict[str, Reduction] = {
    "outputs": outputs,
    "unconnected": unconnected,
    "cyclic": cyclic,
}
