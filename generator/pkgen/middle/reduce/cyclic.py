"""Removes cyclic coordinates from the equations, if that is possible and saves operations.
`routh.py` makes the Lagrangian of the remaining coordinates."""

from __future__ import annotations

from ...equations import Equations
from ...graph.differentiate import symbols_in
from ...graph.solve import looped
from ...methods import provides
from ..derive.effective import NotReduced
from ..derive.impulses import NoRate
from ..motion import COORDINATES
from ..report import ReportLine
from .reduction import Needs, State, cost
from .routh import routh

# How many operations an integrator takes for one number of the state, in addition to the evaluation
# of the equations. The number is per evaluation, and is about 7 for rk4 and 16 for gauss.
OF_A_STATE = 10


def cyclic(state: State, needs: Needs) -> State:
    """Replaces cyclic coordinates by their constant momenta (routh.py)."""
    e, lines = state.equations, []
    # Coordinates of rotations are left out. Their rates are body rates, which are not the time
    # derivatives of angles, even if their momenta are constant.
    cyclic = enumerate(state.structure.cyclic)
    found = [i for i, is_cyclic in cyclic if is_cyclic and i not in e.turning]
    if not found:
        return state
    if not state.structure.quadratic:
        return _not(state, e, found, "L is not of second degree in the rates")
    if looped(e.graph, e.mass):
        return _not(state, e, found, "what is left would couple too many coordinates")
    used = _used(e)
    chosen, angles = [], []
    for i in found:
        name = e.coordinates[i].name
        if name in used:
            lines.append(ReportLine(f"{name} kept", f"it is in {used[name]}"))
        elif name in needs.columns and state.structure.affine:
            lines.append(ReportLine(f"{name} kept", "a linear system has an exact flow"))
        else:
            chosen.append(i)
            angles += [i] if name in needs.columns else []
    if len(chosen) == len(e.coordinates) and not e.states:
        lines.append(ReportLine(f"{e.coordinates[chosen[0]].name} kept", "one must move"))
        angles = [i for i in angles if i != chosen[0]]
        chosen = chosen[1:]
    state = state.noting(*lines)
    if not chosen:
        return state
    try:
        after = _recorded(state, needs, chosen, angles)
    except (NotReduced, NoRate) as why:
        return _not(state, e, chosen, str(why))
    lost = [
        fact
        for fact in needs.facts
        if provides(state.structure, fact) and not provides(after.structure, fact)
    ]
    if lost:
        return _not(state, e, chosen, f"the method requires {' and '.join(lost)}")
    before, now = cost(e.graph, e), cost(e.graph, after.equations)
    if now + OF_A_STATE * _states(after.equations) > before + OF_A_STATE * _states(e):
        return _not(state, e, chosen, f"{now} operations instead of {before}")
    return after


def _states(e: Equations) -> int:
    """Returns the number of values that an integrator advances: coordinates, rates and states."""
    return 2 * len(e.coordinates) + len(e.states)


def _not(state: State, e: Equations, which: list[int], why: str) -> State:
    names = ", ".join(e.coordinates[i].name for i in which)
    return state.noting(ReportLine(f"{names} kept", why))


def _recorded(state: State, needs: Needs, chosen: list[int], angles: list[int]) -> State:
    """Returns a State without the coordinates `chosen` (routh.py), and with a report line for each
    of them. Their rates become outputs if they are recorded."""
    e = state.equations
    recorded = [i for i in chosen if e.rates[i].name in needs.columns]
    found, starts = routh(e, chosen, angles, recorded)
    lines = [
        ReportLine(
            e.coordinates[i].name,
            f"{e.momenta_names[i].name} is constant, of the start"
            + ("; the angle is a state" if i in angles else ""),
        )
        for i in chosen
    ]
    unused = {e.coordinates[i].name for i in chosen if i not in angles}
    return state.after(
        found,
        *lines,
        starts={**state.report.starts, **starts},
        unused=state.report.unused | unused,
    )


def _used(e: Equations) -> dict[str, str]:
    """Returns the names of coordinates in forces, outputs, events and time derivatives of states,
    each with a text that says where it occurs."""
    found: dict[str, str] = {}
    for what, nodes in (
        ("a force", e.applied),
        ("an output that is recorded", [*e.observed, *e.conserved]),
        ("an event", e.events),
        ("a sample block", e.sampled),
        ("the rate of a state", e.state_rates),
    ):
        for symbol in symbols_in(e.graph, nodes, COORDINATES):
            found.setdefault(e.coordinates[symbol.index].name, what)
    return found
