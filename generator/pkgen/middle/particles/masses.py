"""Finds masses m for given positions r, such that M = sum of m J^T J with J = dr/dq. This is the
mass matrix of T = sum of m/2 |r'|^2.

First, the equation is solved numerically, at some states near the start with parameters near their
defaults. This shows which positions have a mass. Then each mass is solved for as an expression in
the parameters. Since masses do not depend on coordinates, coordinates are set to numbers for this:
angles to 0, others to 0, 1 or 2.
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

# The nonzero entries i <= j of a symmetric matrix.
Entries = dict[tuple[int, int], Node]
# A list with an element for each mass. The element has the indices of positions, and the mass. The
# positions have equal J^T J, so that the mass may be at any of them.
Masses = list[tuple[list[int], Node]]
STATES = 5
# The relative tolerance within which two numbers count as equal.
SAME = 1e-8
ANGLES = ("sin", "cos", "tan")


@record
class Given:
    """The parameters, and the initial values near which expressions are evaluated."""

    parameters: tuple[ParameterSlot, ...]
    start_q: Row
    start_states: Row


def masses_of(g: Graph, mass: Entries, squares: list[Entries], given: Given) -> Masses | None:
    """Returns the masses; None if the equation has no solution, or a mass would be negative.
    `squares` has J^T J for each position."""
    draw = random.Random(2385)
    fixed = {s: _about(draw, value, 4) for s, value in defaults(g, given.parameters).items()}
    chosen = _in_numbers(g, mass, squares, _states(g, draw, [mass, *squares], fixed, given))
    if chosen is None:
        return None
    one_of_each = [squares[alike[0]] for alike in chosen]
    rows = [row for others in (0, 1, 2) for row in _at_numbers(g, mass, one_of_each, others)]
    rows = _independent(g, rows, fixed)
    return list(zip(chosen, _eliminated(g, rows, fixed), strict=True)) if rows else None


# -- numerical solution --------------------------------------------------------------------------


def _states(
    g: Graph,
    draw: random.Random,
    matrices: list[Entries],
    fixed: dict[Symbol, float],
    given: Given,
) -> list[dict[Symbol, float]]:
    """Returns a list of STATES states, as maps from all symbols to values. Each state is nearer to
    the initial state than the state before."""
    start = {
        Symbol(kind, i): x if math.isfinite(x) else 0.0
        for kind, row in ((Kind.COORDINATE, given.start_q), (Kind.STATE, given.start_states))
        for i, x in enumerate(evaluate(g, row, fixed))
    }
    symbols = symbols_in(g, [node for matrix in matrices for node in matrix.values()], VARIABLE)
    return [
        fixed | {symbol: _about(draw, start.get(symbol, 0.0), 4**k) for symbol in symbols}
        for k in range(STATES)
    ]


def _about(draw: random.Random, at: float, part: int) -> float:
    """Returns a random number near `at`: the difference is at most |at|/part. If `at` is 0, the
    number is between 0.1/part and 1/part."""
    return at * (1 + draw.uniform(-1, 1) / part) or draw.uniform(0.1, 1) / part


def _in_numbers(
    g: Graph, mass: Entries, squares: list[Entries], states: list[dict[Symbol, float]]
) -> list[list[int]] | None:
    """Returns the indices of the positions with masses, in groups with equal J^T J."""
    import numpy as np

    a, b = _rows(g, mass, squares, states)
    norm = np.linalg.norm
    size = norm(b)
    if not size > 0:
        return None
    groups: list[list[int]] = []
    basis: list[np.ndarray] = []
    for k, column in enumerate(a.T):
        firsts = ((group, a[:, group[0]]) for group in groups)
        near = (g for g, x in firsts if norm(x - column) <= SAME * norm(x))
        if same := next(near, None):
            same.append(k)
        elif _adds(basis, column / (norm(column) or 1.0)):
            groups.append([k])
    if not groups:
        return None
    first = a[:, [group[0] for group in groups]]
    scale = norm(first, axis=0)
    found = np.linalg.lstsq(first / scale, b, rcond=None)[0]
    if not norm(first @ (found / scale) - b) <= SAME * size:
        return None
    kept = [k for k in range(len(groups)) if abs(found[k]) > SAME * size]
    if any(found[k] < 0 for k in kept):
        return None
    return [groups[k] for k in kept]


def _adds(basis: list, vector) -> bool:
    """Returns whether a unit vector is linearly independent of the vectors of an orthonormal basis.
    If it is, its orthogonal component is normalized and appended to the basis."""
    import numpy as np

    for _ in range(2):  # reorthogonalizes once
        for unit in basis:
            vector = vector - (unit @ vector) * unit
    size = np.linalg.norm(vector)
    if size > SAME:
        basis.append(vector / size)
    return bool(size > SAME)


def _rows(g: Graph, mass: Entries, squares: list[Entries], states: list[dict[Symbol, float]]):
    """Returns a and b of the linear equations a m = b: one equation for each state and entry of M,
    scaled to size 1. Equations with values that are not finite are left out."""
    import numpy as np

    matrices = [*squares, mass]
    at = sorted({place for matrix in matrices for place in matrix})
    nodes = [matrix.get(place, ZERO) for place in at for matrix in matrices]
    rows = [np.reshape(evaluate(g, nodes, values), (len(at), len(matrices))) for values in states]
    every = np.concatenate(rows)
    largest = np.abs(every).max(axis=1)
    # rows with NaN are left out too, since comparisons with NaN are false
    good = (largest > 0) & (largest < np.inf)
    every = every[good] / largest[good, None]
    return every[:, :-1], every[:, -1]


# -- symbolic solution ---------------------------------------------------------------------------


def _at_numbers(g: Graph, mass: Entries, squares: list[Entries], others: int) -> list[Row]:
    """Returns the equations for the masses, with all angles set to 0 and all other coordinates to
    `others`. Each equation has the coefficients of the masses, followed by the right-hand side."""
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
        except ArithmeticError:  # for these values of the coordinates, an entry divides by zero
            continue
        if any(node != ZERO for node in row[:-1]):
            rows.append(tuple(row))
    return rows


def _independent(g: Graph, rows: list[Row], fixed: dict[Symbol, float]) -> list[Row]:
    """Returns as many linearly independent equations as there are masses; [] if there are not
    enough. Equations with few masses and few nodes are preferred."""
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
    """Returns the solution of independent linear equations, by elimination in the given order."""
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
