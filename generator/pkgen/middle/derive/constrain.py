"""Solves for the accelerations and the constraint forces of a system with constraints.

The constraint rows are J v + j0 = 0; a row of a holonomic constraint phi(t, q) = 0 is its time
derivative. By d'Alembert's principle the constraint force is J^T lambda. Index reduction to index 1
gives J a + gamma = 0 with gamma = (J v + j0)' at a = 0. With M a = f + J^T lambda,

    S lambda = -(J M^-1 f + gamma),   S = J M^-1 J^T,   a = M^-1 (f + J^T lambda).

With M = L D L^T and Z = L^-1 J^T, S = Z^T D^-1 Z. In each step, positions and rates drift off the
constraints by the error of the step; the runtime then projects them back
(src/constraints/project.c).
Reference: E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, section VII.1."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, replace

from ...equations import Constraints, Matrix, Row, Rows
from ...graph.differentiate import Forward, gradient
from ...graph.graph import BIT, VARIABLE, ZERO, Graph, Kind, Node
from ...graph.normal import Normal
from ...graph.solve import (
    Factors,
    Pivots,
    SingularMass,
    Solution,
    elimination_order,
    factors,
    solve,
)
from ..motion import RATES, Motion
from ..quantities import symbols
from .meet import met


class CannotConstrain(Exception):
    """The constraint equations cannot be solved. `row` is the number of the row at fault; the
    message then continues the text "the constraint 'NAME'". If `row` is None, the message is
    complete."""

    def __init__(self, message: str, row: int | None = None, help: str = ""):
        super().__init__(message)
        self.message, self.row, self.help = message, row, help


def constrain(
    g: Graph, motion: Motion, rows: Rows, rate_of: Callable[[Node], Node]
) -> tuple[Motion, Solution, Constraints]:
    """Returns three results. The first is the motion, where the constraint force J^T lambda is
    added to the fields `applied`, `pdot` and `force`. The second has the accelerations and the
    pivots of M. The third has the constraints, their multipliers, and these fields of the motion
    without J^T lambda.

    `rate_of` gives the time derivative of a coordinate, a state, t or an input. Raises
    CannotConstrain if a row is not affine in the rates or contains none, if rows are linearly
    dependent at all states, or if M or S is too large for straight-line code."""
    n = len(motion.force)
    v = symbols(g, Kind.RATE, n)
    J = tuple(_row(g, rows, k, v) for k in range(len(rows.residual)))
    coasting = Forward(
        g, VARIABLE, lambda node: ZERO if g.data[node].kind is Kind.RATE else rate_of(node)
    )
    gamma = [coasting(node) for node in rows.residual]
    order, _ = elimination_order(g, motion.mass)
    factored = factors(g, motion.mass, order)
    if factored is None:
        raise CannotConstrain("M is not positive definite: constraints cannot be solved for")
    more = rows.redundant
    beside = tuple(_row(g, more, k, v) for k in range(len(more.residual))) if more else ()
    values: Row = ()
    if rows.meetings:
        multipliers, solution, pivots, binding, values = met(g, motion, factored, rows, J, gamma)
        shares: Matrix = ()
    else:
        multipliers, solution, pivots, shares = _solved(g, motion, factored, J, gamma, beside)
        binding = [g.dot(column, multipliers) for column in zip(*J, strict=True)]
    applied, pdot, force = (
        tuple(map(g.add, row, binding)) for row in (motion.applied, motion.pdot, motion.force)
    )
    found = Constraints(
        **{field.name: getattr(rows, field.name) for field in fields(Rows)},
        rows=J,
        multipliers=multipliers,
        pivots=pivots,
        free_applied=motion.applied,
        free_pdot=motion.pdot,
        free_force=motion.force,
        workless=not rows.meetings and _workless(g, rows, J, v),
        values=values,
        redundant_rows=beside,
        least=_least(g, multipliers, shares),
        shared=_shared(shares, len(J)),
    )
    return replace(motion, applied=applied, pdot=pdot, force=force), solution, found


def _least(g: Graph, multipliers: Row, shares: Matrix) -> Row:
    """Returns for all rows, also redundant ones, the multipliers of least norm that give the same
    constraint force as `multipliers`, in which redundant rows have none.

    Let lambda be `multipliers`, C be `shares`, and the redundant rows be C times the other rows. In
    the result, the other rows have the multipliers lambda - C^T x, and the redundant rows have the
    multipliers x, where (1 + C C^T) x = C lambda.
    """
    if not shares:
        return multipliers

    rows = tuple(
        tuple(g.add(g.number(int(i == j)), g.dot(a, b)) for j, b in enumerate(shares))
        for i, a in enumerate(shares)
    )
    more = solve(g, rows, tuple(g.dot(a, multipliers) for a in shares))
    if more is None:
        return ()
    x = more.accelerations
    taken = (g.dot(column, x) for column in zip(*shares, strict=True))
    return (*map(g.subtract, multipliers, taken), *x)


def _shared(shares: Matrix, count: int) -> frozenset[int]:
    own = {k for row in shares for k, x in enumerate(row) if x != ZERO}
    return frozenset({*own, *range(count, count + len(shares))})


def _row(g: Graph, rows: Rows, k: int, v: Row) -> Row:
    """Returns the derivatives of row k by the rates. Raises CannotConstrain if they contain rates,
    or if all are zero."""
    by = gradient(g, rows.residual[k], RATES)
    found = tuple(by.get(rate, ZERO) for rate in v)
    if any(g.depends[node] & RATES for node in found):
        normal = Normal(g)
        forms = (normal(node) for node in found)
        found = tuple(
            node if form is None else normal.plain(form)
            for node, form in zip(found, forms, strict=True)
        )
        if any(g.depends[node] & RATES for node in found):
            raise CannotConstrain(
                "is not affine in the rates", k, "d'Alembert's principle has rows J q' + j0 = 0"
            )
    if all(node == ZERO for node in found):
        raise CannotConstrain("holds or fails whatever the motion: no rate is left in it", k)
    return found


def _solved(
    g: Graph, motion: Motion, factored: Factors, J: Matrix, gamma: list[Node], more: Matrix
) -> tuple[Row, Solution, Pivots, Matrix]:
    """Returns four results: the multipliers; the accelerations with the pivots of M; the pivots of
    S; and for each redundant row (in `more`) the coefficients by which it is a linear combination
    of the rows of J."""
    columns = [factored.forward(g, row) for row in J]
    force = factored.forward(g, motion.force)

    def product(a: list[Node], b: list[Node]) -> Node:
        return g.sum(
            g.multiply(inverse, g.multiply(x, y))
            for x, y, inverse in zip(a, b, factored.inverses, strict=True)
            if x != ZERO and y != ZERO
        )

    count = len(J)
    S = [[ZERO] * count for _ in range(count)]
    for i, column in enumerate(columns):
        for j in range(i + 1):
            S[i][j] = S[j][i] = product(column, columns[j])
    wanted = tuple(
        g.negate(g.add(product(column, force), own))
        for column, own in zip(columns, gamma, strict=True)
    )
    try:
        found = solve(g, tuple(map(tuple, S)), wanted)
    except SingularMass as singular:
        raise CannotConstrain(
            "depends on the others wherever they hold: it is redundant, or contradicts them",
            singular.coordinate,
            "leave it out",
        ) from None
    if found is None:
        raise CannotConstrain(
            "too many constraints hang together to be solved for in straight-line code",
            None,
            "use coordinates that fulfil some of them by themselves",
        )
    multipliers = found.accelerations
    shares = []
    for row in more:
        along = factored.forward(g, row)
        share = solve(g, tuple(map(tuple, S)), tuple(product(along, x) for x in columns))
        shares.append(share.accelerations if share else ())
    z = [
        g.add(f, g.dot((column[i] for column in columns), multipliers)) for i, f in enumerate(force)
    ]
    solution = Solution(factored.backward(g, z), factored.beside(motion.mass))
    return multipliers, solution, found.pivots, tuple(shares)


def _workless(g: Graph, rows: Rows, J: Matrix, v: Row) -> bool:
    """Whether the constraint forces do no work. This is so if j0 = 0 in the rows J v + j0 = 0, and
    neither these rows nor the functions phi of holonomic constraints depend on t or inputs."""
    normal = Normal(g)
    timeless = BIT[Kind.TIME] | BIT[Kind.INPUT]
    if any(g.depends[node] & timeless for node in (*rows.residual, *rows.positions)):
        return False
    for row, residual in zip(J, rows.residual, strict=True):
        rest = g.subtract(residual, g.dot(row, v))
        if rest != ZERO and normal(rest) != {}:
            return False
    return True
