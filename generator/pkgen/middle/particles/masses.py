"""Finds masses m of given places with M = sum of m J^T J, the mass matrix of T = sum of m/2 |r'|^2.

First, numbers at some states near the start, with parameters near their defaults, show which places
have a mass: the first independent places that give M. Then each mass is solved for as an expression
in parameters. It does not depend on coordinates, which are set to numbers (angles to 0, others to
0, 1 or 2).
"""

from __future__ import annotations

import math
import random

from ...equations import ParameterSlot, Row
from ...graph.differentiate import reachable, symbols_in
from ...graph.evaluate import evaluate
from ...graph.graph import VARIABLE, ZERO, Graph, Kind, Node, Op, Symbol
from ...graph.substitute import substituted
from ...record import record
from ..points.singularities import defaults

Entries = dict[tuple[int, int], Node]  # nonzero entries i <= j of a symmetric matrix
Masses = list[tuple[list[int], Node]]  # indices of equivalent places, and the mass at one of them
STATES = 5
SAME = 1e-8  # relative tolerance for numbers equal up to rounding
ANGLES = ("sin", "cos", "tan")


@record
class Given:
    """The parameters and starts about which numbers are evaluated."""

    parameters: tuple[ParameterSlot, ...]
    start_q: Row
    start_states: Row


def masses_of(g: Graph, mass: Entries, squares: list[Entries], given: Given) -> Masses | None:
    """Returns the masses; None if there are none, or one is negative."""
    draw = random.Random(2385)
    fixed = {s: _about(draw, value, 4) for s, value in defaults(g, given.parameters).items()}
    chosen = _in_numbers(g, mass, squares, _states(g, draw, [mass, *squares], fixed, given))
    if chosen is None:
        return None
    solved = _as_expressions(g, mass, [squares[alike[0]] for alike in chosen], fixed)
    return solved and list(zip(chosen, solved, strict=True))


# -- in numbers ----------------------------------------------------------------------------------


def _states(
    g: Graph,
    draw: random.Random,
    matrices: list[Entries],
    fixed: dict[Symbol, float],
    given: Given,
) -> list[dict[Symbol, float]]:
    """Returns values of all symbols at states near the start, each nearer than the one before."""
    start = {}
    for kind, row in ((Kind.COORDINATE, given.start_q), (Kind.STATE, given.start_states)):
        for i, value in enumerate(evaluate(g, row, fixed)):
            start[Symbol(kind, i)] = value if math.isfinite(value) else 0.0
    nodes = [node for matrix in matrices for node in matrix.values()]
    symbols = symbols_in(g, nodes, VARIABLE)
    found = []
    for k in range(STATES):
        values = dict(fixed)
        for symbol in symbols:
            values[symbol] = _about(draw, start.get(symbol, 0.0), 4**k)
        found.append(values)
    return found


def _about(draw: random.Random, at: float, part: int) -> float:
    """Returns a random number within |at|/part of `at`; within 0.1/part..1/part if `at` is 0."""
    return at * (1 + draw.uniform(-1, 1) / part) or draw.uniform(0.1, 1) / part


def _in_numbers(
    g: Graph, mass: Entries, squares: list[Entries], states: list[dict[Symbol, float]]
) -> list[list[int]] | None:
    """Returns the places with masses, in groups of places with equal J^T J."""
    import numpy as np

    a, b = _rows(g, mass, squares, states)
    size = np.linalg.norm(b)
    if not size > 0:
        return None
    groups: list[list[int]] = []
    basis: list[np.ndarray] = []
    for k, column in enumerate(a.T):
        length = np.linalg.norm(column)
        same = [group for group in groups if _near(a[:, group[0]], column)]
        if same:
            same[0].append(k)
            continue
        if _adds(basis, column / (length or 1.0)):
            groups.append([k])
    if not groups:
        return None
    first = a[:, [group[0] for group in groups]]
    scale = np.linalg.norm(first, axis=0)
    found = np.linalg.lstsq(first / scale, b, rcond=None)[0]
    if not np.linalg.norm(first @ (found / scale) - b) <= SAME * size:
        return None
    kept = [k for k in range(len(groups)) if abs(found[k]) > SAME * size]
    if any(found[k] < 0 for k in kept):
        return None
    return [groups[k] for k in kept]


def _adds(basis: list, vector) -> bool:
    """Returns whether a unit vector is independent of the basis; if so, extends the basis."""
    import numpy as np

    for _ in range(2):  # reorthogonalizes once
        for unit in basis:
            vector = vector - (unit @ vector) * unit
    size = np.linalg.norm(vector)
    if size > SAME:
        basis.append(vector / size)
    return bool(size > SAME)


def _near(a, b) -> bool:
    import numpy as np

    return bool(np.linalg.norm(a - b) <= SAME * np.linalg.norm(a))


def _rows(g: Graph, mass: Entries, squares: list[Entries], states: list[dict[Symbol, float]]):
    """Returns a, b of the equations a m = b, one for each entry and state, scaled to size 1; drops
    equations with values that are not finite."""
    import numpy as np

    matrices = [*squares, mass]
    at = sorted({place for matrix in matrices for place in matrix})
    nodes = [matrix.get(place, ZERO) for place in at for matrix in matrices]
    rows = [np.reshape(evaluate(g, nodes, values), (len(at), len(matrices))) for values in states]
    every = np.concatenate(rows)
    largest = np.abs(every).max(axis=1)
    good = (largest > 0) & (largest < np.inf)  # also false for NaN
    every = every[good] / largest[good, None]
    return every[:, :-1], every[:, -1]


# -- as expressions ------------------------------------------------------------------------------


def _as_expressions(
    g: Graph, mass: Entries, squares: list[Entries], fixed: dict[Symbol, float]
) -> list[Node] | None:
    """Returns the masses as expressions in parameters."""
    rows = [row for others in (0, 1, 2) for row in _at_numbers(g, mass, squares, others)]
    rows = _independent(g, rows, fixed)
    return _eliminated(g, rows, fixed) if rows else None


def _at_numbers(g: Graph, mass: Entries, squares: list[Entries], others: int) -> list[Row]:
    """Returns the equations with angles 0 and other coordinates equal to `others`: coefficients of
    each mass, and the right-hand side."""
    matrices = [*squares, mass]
    below = reachable(g, [node for matrix in matrices for node in matrix.values()], VARIABLE)
    calls = [node for node in below if g.op[node] is Op.CALL and g.data[node] in ANGLES]
    angles = set(reachable(g, [a for node in calls for a in g.args[node]], VARIABLE))
    swap = {
        node: g.number(0 if node in angles else others) for node in below if g.op[node] is Op.SYMBOL
    }
    rows = []
    for place in sorted({place for matrix in matrices for place in matrix}):
        try:
            row = substituted(g, [matrix.get(place, ZERO) for matrix in matrices], swap)
        except ArithmeticError:  # a division by zero at these numbers
            continue
        if any(node != ZERO for node in row[:-1]):
            rows.append(tuple(row))
    return rows


def _independent(g: Graph, rows: list[Row], fixed: dict[Symbol, float]) -> list[Row]:
    """Returns as many independent equations as masses, the simplest first; [] if that fails."""
    import numpy as np

    count = len(rows[0]) - 1 if rows else 0
    rows = sorted(rows, key=lambda row: (sum(n != ZERO for n in row[:-1]), len(reachable(g, row))))
    basis: list[np.ndarray] = []
    chosen = []
    for row in rows:
        *coefficients, whole = evaluate(g, row, fixed)
        length = np.linalg.norm(coefficients)
        if len(chosen) == count or not (length > 0 and math.isfinite(whole)):
            continue
        if _adds(basis, np.array(coefficients) / length):
            chosen.append(row)
    return chosen if len(chosen) == count else []


def _eliminated(g: Graph, rows: list[Row], fixed: dict[Symbol, float]) -> list[Node]:
    """Solves as many independent equations as unknowns by elimination in the given order."""
    count = len(rows)
    waiting = [list(row) for row in rows]
    order = []
    while waiting:
        row = waiting.pop(0)
        sizes = [abs(value) for value in evaluate(g, row[:-1], fixed)]
        k = sizes.index(max(sizes))
        order.append((k, row))
        for other in waiting:
            if other[k] == ZERO:
                continue
            times = g.divide(other[k], row[k])
            for j in range(count + 1):
                other[j] = g.subtract(other[j], g.multiply(times, row[j]))
            other[k] = ZERO
    found = [ZERO] * count
    for k, row in reversed(order):
        known = g.sum(g.multiply(row[j], found[j]) for j in range(count) if j != k)
        found[k] = g.divide(g.subtract(row[-1], known), row[k])
    return found
