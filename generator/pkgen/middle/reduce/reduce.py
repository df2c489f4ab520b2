"""Applies all reductions to the equations, and reports what was removed and why.

The reductions are functions in REDUCTIONS, each under the name by which the user can switch it off.
Other simplifications are made elsewhere: parameters set and coordinates held by a scene are removed
before the equations are derived (specialise.py), and kernels that are never called are left out of
the C code (back/kernels.py).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace

from ...equations import Equations
from ...graph.differentiate import symbols_in
from ...graph.graph import BIT, Kind
from ...indices import parted
from ...model import Model
from ..analyze.analyze import analyze
from ..derive.lagrange import derived_again
from ..drop_coordinates import without
from ..motion import STATE
from ..report import ReportLine
from ..structure import Structure
from .apart import parts_of
from .cyclic import cyclic
from .reduction import Needs, State, cost

# The name of the reduction that splits a system into parts.
APART = "apart"
# The kernels of the whole system that are needed even if its parts are integrated separately.
OF_WHOLE = frozenset({"energy", "canonical", "observe", "conserve", "kinetic", "potential"})


def of_the_whole(kernels: frozenset[str] | None) -> frozenset[str]:
    """The parts of the system are integrated separately. Returns the requested kernels that are
    needed for the system as a whole. `kernels` are all requested kernels (None: all that exist)."""
    return OF_WHOLE if kernels is None else kernels & OF_WHOLE


def of_a_part(kernels: frozenset[str] | None) -> frozenset[str] | None:
    """Returns the requested kernels that are needed for a part that is integrated separately.
    `kernels` are all requested kernels (None: all that exist)."""
    return None if kernels is None else kernels - (OF_WHOLE - {"canonical"})


def reduce(
    equations: Equations, structure: Structure, needs: Needs, kernels: frozenset[str] | None
) -> State:
    """Applies all reductions, and returns the reduced equations with their facts and the report.
    `kernels` are the requested kernels (None: all that exist)."""
    # The field `fast` is used only by the method respa, without reductions.
    equations = replace(equations, fast=None)
    state = State(equations, structure)
    for name, reduction in REDUCTIONS.items():
        # A reset writes all coordinates, also those that influence nothing.
        whole = equations.resets or equations.model.meets or equations.noise
        if name not in needs.off and (name == "outputs" or not whole):
            state = reduction(state, needs)
    g, parts, lines = equations.graph, (), state.report.lines
    # A system with switches is not split, since the runtime locates switches in one system only.
    if APART not in needs.off and needs.apart and state.structure.smooth and not equations.noise:
        parts = parts_of(state.equations, state.structure, of_a_part(kernels))
    if parts:
        names = (", ".join(q.name for q in part.equations.coordinates) for part in parts)
        why = "neither moves the other: integrated apart"
        lines = (*lines, ReportLine(" | ".join(names), why))
        kernels = of_the_whole(kernels)
    lines = (*lines, *_of_itself(state.equations, state.structure))
    reduced = derived_again(state.equations, kernels)
    moved = [part.equations for part in parts] or [reduced]
    report = replace(
        state.report,
        lines=lines,
        coordinates=(_moving(equations), _moving(reduced)),
        operations=(cost(g, equations), sum(cost(g, e) for e in moved)),
    )
    return State(reduced, analyze(reduced), report, parts)


def _of_itself(equations: Equations, structure: Structure) -> tuple[ReportLine, ...]:
    """Returns report lines about properties of the equations that save work at run time."""
    lines = []
    if structure.mass_constant and equations.coordinates:
        lines.append(ReportLine("M is constant", "factored once, when prepared"))
    if structure.affine:
        why = "stepped by its exact exponential, unless another method is asked for"
        lines.append(ReportLine("linear with constant coefficients", why))
    return tuple(lines)


# -- outputs -------------------------------------------------------------------------------------


def outputs(state: State, needs: Needs) -> State:
    """Removes the outputs that are not recorded, and the events that are not requested. A
    `conserve` statement that is not recorded is removed too, since it was proved before."""
    e, lines, left, model = state.equations, [], {}, state.equations.model
    names = {"observed": e.observed_names, "conserved": e.conserved_names, "events": e.event_names}
    for field, wanted, line in _unread(model, needs, needs.columns, names):
        lines.append(line)
        for row in (f"{field.removesuffix('s')}_names", field):
            pairs = zip(names[field], getattr(e, row), strict=True)
            left[row] = tuple(x for q, x in pairs if q.name in wanted)
        if field == "events":
            model = replace(model, events=tuple(x for x in model.events if x.name in wanted))
    return state.after(replace(e, model=model, **left), *lines) if lines else state


def outputs_of_loops(model: Model, needs: Needs) -> tuple[Model, tuple[ReportLine, ...]]:
    """Removes unused outputs and events of a model whose families are loops."""
    if "outputs" in needs.off:
        return model, ()
    # A recorded column NAME[i] is member i of an output NAME, or an output with the name "NAME[i]".
    columns = {parted(name)[0] for name in needs.columns} | needs.columns
    lines, items = [], vars(model)
    for field, wanted, line in _unread(model, needs, columns, items):
        lines.append(line)
        model = replace(model, **{field: tuple(x for x in items[field] if x.name in wanted)})
    return model, tuple(lines)


def _unread(
    model: Model, needs: Needs, columns: frozenset[str], items: Mapping[str, tuple]
) -> Iterator[tuple[str, frozenset[str], ReportLine]]:
    """Yields a tuple for each kind of output, and for events, of which some items are dropped: the
    name of its field, the names of the others, a report line."""
    asked = needs.events | {event.name for event in model.events if event.acts}
    for field, what, wanted, why in (
        ("observed", "observed", columns, "not recorded, so not computed"),
        ("conserved", "conserved", columns, "proved, so not watched"),
        ("events", "event", asked, "nothing is asked of it, and it stops nothing"),
    ):
        gone = [item.name for item in items[field] if item.name not in wanted]
        if gone:
            yield field, wanted, ReportLine(f"{what} {', '.join(gone)}", why)


# -- coordinates without influence ---------------------------------------------------------------


def unconnected(state: State, needs: Needs) -> State:
    """Removes coordinates and states that do not influence recorded quantities: they are fixed at
    their initial values.

    Coordinates in the same block of M as a remaining coordinate are not removed, since their
    inertia affects its acceleration.
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
        if not waiting:
            waiting = list(_bodies(e, kept) - kept)
            kept |= set(waiting)
    gone = [i for i in range(_moving(e)) if i not in kept]
    if not gone or not kept:
        return state
    names = [(*e.moving, *(q.name for q in e.states))[i] for i in gone]
    return state.after(
        without(e, gone),
        ReportLine(", ".join(names), "nothing recorded depends on it"),
        unused=state.report.unused | frozenset(names),
    )


def _wanted(e: Equations, needs: Needs) -> set[int]:
    """Returns the indices of coordinates and states that are recorded themselves, or that occur in
    an output or an event."""
    n, nodes = len(e.coordinates), [*e.observed, *e.conserved, *e.events, *e.sampled]
    names = {q.name: i for row in (e.coordinates, e.rates) for i, q in enumerate(row)}
    names |= {q.name: n + i for i, q in enumerate(e.states)}
    found = {names[column] for column in needs.columns if column in names}
    if "energy" in needs.columns:
        found |= set(range(n))
        nodes.append(e.energy)
    used = symbols_in(e.graph, nodes, STATE | BIT[Kind.STATE])
    return found | {s.index + (n if s.kind is Kind.STATE else 0) for s in used}


def _bodies(e: Equations, kept: set[int]) -> set[int]:
    """Returns body rates and components of quaternions that have to be kept in addition to `kept`,
    by index. If a body rate or a component of a rotation is kept, all its three body rates are. Its
    quaternion is kept too if any component of any quaternion is kept, or if there are
    constraints."""
    n, found = len(e.coordinates), set()
    numbers = [{n + k for k in a.numbers} for a in e.attitudes]
    turned = e.constraints is not None or any(mine & kept for mine in numbers)
    for a, mine in zip(e.attitudes, numbers, strict=True):
        if ({*a.rates} | mine) & kept:
            found |= {*a.rates} | (mine if turned else set())
    return found


def _moving(e: Equations) -> int:
    """Returns the number of coordinates and states together."""
    return len(e.coordinates) + len(e.states)


Reduction = Callable[[State, Needs], State]
REDUCTIONS: dict[str, Reduction] = {
    "outputs": outputs,
    "unconnected": unconnected,
    "cyclic": cyclic,
}
