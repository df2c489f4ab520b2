"""Derives the equations of motion from the Lagrangian L, the dissipation D and the forces Q. The
expressions of each kernel are rewritten with few operations.

`equations.py` defines the symbols; `collect.py` rewrites expressions.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from ..equations import Attitude, Equations, Linear, Matrix, Row
from ..graph.collect import THOROUGH, fewest, forms, settled, shortened
from ..graph.count import operations
from ..graph.differentiate import Columns, Forward, gradient, reachable
from ..graph.graph import BIT, ONE, VARIABLE, ZERO, Graph, Kind, Node, Op, Symbol
from ..graph.pushed import pushed
from ..graph.residues import Residues
from ..graph.solve import Solution, looped, solve
from ..record import record
from .attitudes import gyroscopic, slopes
from .quantities import symbols

COORDINATES = BIT[Kind.COORDINATE]
RATES = BIT[Kind.RATE]
STATE = COORDINATES | RATES
TIME = BIT[Kind.TIME]


# Models with more coordinates get the kernel "linear" only if it is requested by name. For a
# pendulum of 20 links, this kernel has most of the operations and takes a fifth of the compile
# time.
LINEARISED = 16
# Requested in place of the kernel "linear" if this is wanted up to LINEARISED coordinates only.
LINEAR_OF_FEW = "linear of few"
PARTICLES = "particles"  # A kernel that only diagnostics request.


# The fields of Equations that have Jacobians, with their values if no Jacobians are requested.
NO_JACOBIANS: dict[str, None] = dict.fromkeys(("p_q", "pdot_q", "pdot_v"))


class Wanted:
    """The requested kernels (None: all). Called with names of kernels, returns whether at least one
    of them is requested."""

    def __init__(self, kernels: frozenset[str] | None):
        self.kernels = kernels

    def __call__(self, *names: str) -> bool:
        return self.kernels is None or not self.kernels.isdisjoint(names)

    def named(self, name: str) -> bool:
        """Whether a kernel is requested by name: a request of all kernels does not count."""
        return self.kernels is not None and name in self.kernels

    def linear(self, count: int) -> bool:
        return "linear" in (self.kernels or ()) or (self(LINEAR_OF_FEW) and count <= LINEARISED)


@record
class Energies:
    lagrangian: Node
    kinetic: Node | None
    potential: Node | None
    dissipation: Node
    fast: Node = ZERO
    whole: Node | None = None  # L, if it is of first degree in the rates: `lagrangian` is then -H


@record
class Motion:
    momenta: Row
    gradient: Row
    applied: Row
    pdot: Row
    mass: Matrix
    force: Row


def motion_of(
    g: Graph,
    energies: Energies,
    forces: Row,
    rate_of: Callable[[Node], Node],
    attitudes: tuple[Attitude, ...] = (),
) -> Motion:
    """Returns the equations of motion. `rate_of` gives the time derivative of a coordinate, t or an
    input. The field `gradient` of the result is dL/dq. For the coordinates of a rotation, it is X L
    + p x w instead (see attitudes.py)."""
    count = len(forces)
    q, v = symbols(g, Kind.COORDINATE, count), symbols(g, Kind.RATE, count)
    by = gradient(g, energies.lagrangian, STATE | (BIT[Kind.STATE] if attitudes else 0))
    momenta = tuple(by.get(rate, ZERO) for rate in v)
    along, turning = slopes(g, attitudes, by), gyroscopic(g, attitudes, momenta)
    slope = tuple(
        g.add(along[i], turning[i]) if i in along else by.get(coordinate, ZERO)
        for i, coordinate in enumerate(q)
    )
    drag = gradient(g, energies.dissipation, RATES)
    applied = tuple(g.subtract(f, drag.get(rate, ZERO)) for f, rate in zip(forces, v, strict=True))
    pdot = tuple(map(g.add, slope, applied))
    mass = _symmetric_matrix(g, momenta, v, RATES)
    # The time derivative of a node if all accelerations are zero.
    coasting = Forward(
        g, VARIABLE, lambda node: ZERO if g.data[node].kind is Kind.RATE else rate_of(node)
    )
    force = tuple(g.subtract(there, coasting(p)) for there, p in zip(pdot, momenta, strict=True))
    return Motion(momenta, slope, applied, pdot, mass, force)


def _symmetric_matrix(g: Graph, rows: Row, by: Row, mask: int) -> Matrix:
    """Returns the derivatives of `rows` by the symbols `by`, a symmetric matrix. Computes only the
    triangle i >= j."""
    columns = Columns(g, rows, mask)
    found = (columns.column(symbol, from_output=j) for j, symbol in enumerate(by))
    triangle = [column.get(row, ZERO) for j, column in enumerate(found) for row in rows[j:]]
    return _symmetric(triangle, len(by))


def shortest(
    g: Graph, lagrangian: Node, motion: Motion, wanted: Wanted, mass_read: bool = False
) -> tuple[Motion, Solution | None]:
    """Returns the motion in the form of fewest operations, and the solution a of M a = f. The
    solution is None if it is too large or not needed. It is needed if it is requested, or if a
    momentum depends on a state (see states.py). It is computed with M, or directly from L without M
    (pushed.py) if that takes fewer operations. `mass_read` says whether M is needed in any case."""
    n = len(motion.force)
    triangle = [motion.mass[i][j] for i in range(n) for j in range(i, n)]
    outputs = [*triangle, *motion.force]
    canonical = [*motion.momenta, *motion.pdot]
    thorough = len(reachable(g, outputs + canonical)) <= THOROUGH
    slope = list(motion.gradient)
    outputs = settled(g, outputs[:-n]) + (settled(g, outputs[-n:]) if thorough else outputs[-n:])
    if thorough:
        if wanted("canonical", "momenta", "jacobian"):
            canonical = fewest(g, settled(g, canonical))
        if wanted("gradient"):
            slope = fewest(g, settled(g, slope))
    mass, force = _symmetric(outputs, n), tuple(outputs[-n:])
    stated = with_states(g, motion.momenta)
    solved = stated or wanted("acceleration", "singularity")
    solution = None
    if solved and not mass_read and not wanted("mass") and not wanted.linear(n):
        solution, force = _without_mass(g, lagrangian, mass, force)
    if solution is None:
        found = []
        for form in forms(g, outputs, thorough, short_kept=not thorough):
            mass, force = _symmetric(form, n), tuple(form[-n:])
            solution = solve(g, mass, force) if solved else None
            cost = operations(g, [*form, *(solution.accelerations if solution else ())])
            found.append((cost, len(found), mass, force, solution))
        _, _, mass, force, solution = min(found)
        if solved:
            along = pushed(g, lagrangian, symbols(g, Kind.RATE, n), force)
            # if a momentum depends on a state, no loop in C can solve M a = f
            alone = solution is None and stated
            if along is not None and (
                alone or _operations(g, along, mass) < _operations(g, solution, mass)
            ):
                solution = along
    if solution is not None and thorough:
        of = solution.pivots
        outputs = [*solution.accelerations, *(pivot for pivot, _ in of)]
        shorter = fewest(g, outputs, thorough=False)
        pivots = zip(shorter[n:], (size for _, size in of), strict=True)
        solution = Solution(tuple(shorter[:n]), tuple(pivots))
    return Motion(
        momenta=tuple(canonical[:n]),
        gradient=tuple(slope),
        applied=motion.applied,
        pdot=tuple(canonical[n:]),
        mass=mass,
        force=force,
    ), solution


def rate_of(g: Graph, e: Equations, symbol: Symbol) -> Node | None:
    """Returns the time derivative of t, a coordinate, a state or an input. Returns None for an
    input if the equations do not contain its derivative."""
    if symbol.kind is Kind.TIME:
        return ONE
    if symbol.kind is Kind.COORDINATE:
        return g.symbol(Symbol(Kind.RATE, symbol.index))
    if symbol.kind is Kind.STATE:
        return e.state_rates[symbol.index]
    names = [q.name for q in e.inputs[symbol.index : symbol.index + 2]]
    known = len(names) == 2 and names[1] == f"{names[0]}'"
    return g.symbol(Symbol(Kind.INPUT, symbol.index + 1)) if known else None


def with_states(g: Graph, momenta: Row) -> bool:
    """Whether a momentum depends on a state. Then dp/dv has entries for states; see states.py."""
    return any(g.depends[p] & BIT[Kind.STATE] for p in momenta)


def _without_mass(
    g: Graph, lagrangian: Node, mass: Matrix, force: Row
) -> tuple[Solution | None, Row]:
    """Returns two results: the solution a of M a = f, computed from L without M, and f in few
    operations. The solution is None if a pivot vanishes, or if solving M a = f by a loop in C takes
    fewer operations, even when the operations of computing M are not counted."""
    n = len(force)
    if not looped(g, mass):
        return None, force
    short = tuple(min(forms(g, list(force), False, True), key=lambda form: operations(g, form)))
    found = pushed(g, lagrangian, symbols(g, Kind.RATE, n), short)
    if found is None or _operations(g, found, mass) >= _looped(n) // 2:
        return None, force
    residues = Residues(g)
    pivots = [pivot for pivot, _ in found.pivots]
    residues.learn(pivots)
    return (None, force) if 0 in map(residues, pivots) else (found, short)


def _operations(g: Graph, solution: Solution | None, mass: Matrix) -> int:
    """Returns the number of operations of a solution of M a = f, including its pivots. If
    `solution` is None, a loop in C solves M a = f. Its operations take half the time of others, and
    count half."""
    if solution is None:
        return (operations(g, [x for row in mass for x in row]) + _looped(len(mass))) // 2
    return operations(g, [*solution.accelerations, *sum(solution.pivots, ())])


def _looped(n: int) -> int:
    """Returns the number of operations of a loop that solves M a = f for n coordinates."""
    return n**3 // 3


def _symmetric(triangle: list[Node], n: int) -> Matrix:
    rows = [[ZERO] * n for _ in range(n)]
    entries = iter(triangle)
    for i in range(n):
        for j in range(i, n):
            rows[i][j] = rows[j][i] = next(entries)
    return tuple(map(tuple, rows))


def jacobians_of(g: Graph, motion: Motion, lagrangian: bool = True) -> dict[str, Matrix]:
    """Returns the derivatives dp/dq, dp'/dq and dp'/dv of the momenta p and of p'. `lagrangian`
    says whether p = dL/dv and gradient = dL/dq for some L. In this case d(dL/dq_i)/dq_j is
    symmetric, and d(dL/dq_i)/dv_j = dp_j/dq_i, which saves work."""
    n = len(motion.momenta)
    q, v = symbols(g, Kind.COORDINATE, n), symbols(g, Kind.RATE, n)
    p_q = matrix(g, motion.momenta, q, COORDINATES)
    p_q_transposed = tuple(zip(*p_q, strict=True))
    if not lagrangian:
        ways = [(matrix(g, motion.pdot, q, COORDINATES), matrix(g, motion.pdot, v, RATES))]
    elif all(node == ZERO for node in motion.applied):
        ways = [(_symmetric_matrix(g, motion.pdot, q, COORDINATES), p_q_transposed)]
    else:
        second = _symmetric_matrix(g, motion.gradient, q, COORDINATES)
        applied_q = matrix(g, motion.applied, q, COORDINATES)
        applied_v = matrix(g, motion.applied, v, RATES)
        ways = [(_sum(g, second, applied_q), _sum(g, p_q_transposed, applied_v))]
        # Applied forces may cancel a part of the gradient. The derivatives of the sum pdot of both
        # are then shorter than the derivatives of the gradient and of the forces.
        if len(reachable(g, motion.pdot)) <= THOROUGH:
            direct = matrix(g, motion.pdot, q, COORDINATES), matrix(g, motion.pdot, v, RATES)
            ways.append(direct)
    found = [shortened(g, (x for matrix in (p_q, *way) for x in sum(matrix, ()))) for way in ways]
    best = found[0] if len(found) == 1 else min(found, key=lambda x: operations(g, x))
    rows = [tuple(best[i : i + n]) for i in range(0, len(best), n)]
    return {field: tuple(rows[k * n : (k + 1) * n]) for k, field in enumerate(NO_JACOBIANS)}


def residual(g: Graph, force: Row, mass: Matrix) -> Row:
    """Returns r = f - M a, in which a are symbols."""
    a = symbols(g, Kind.ACCELERATION, len(force))
    return tuple(g.subtract(f, g.dot(row, a)) for f, row in zip(force, mass, strict=True))


def linear_of(g: Graph, motion: Motion) -> Linear:
    """Returns the derivatives of r = f - M a by q, v and t at constant a and inputs."""
    n = len(motion.force)
    q, v = symbols(g, Kind.COORDINATE, n), symbols(g, Kind.RATE, n)
    r = residual(g, motion.force, motion.mass)
    r_q, r_v = matrix(g, r, q, COORDINATES), matrix(g, r, v, RATES)
    r_t = matrix(g, r, symbols(g, Kind.TIME, 1), TIME)
    entries = shortened(g, (entry for row in (*r_q, *r_v, *r_t) for entry in row))
    rows = [tuple(entries[i : i + n]) for i in range(0, len(entries), n)]
    return Linear(tuple(rows[:n]), tuple(rows[n : 2 * n]), rows[2 * n])


def _sum(g: Graph, a: Matrix, b: Matrix) -> Matrix:
    return tuple(tuple(map(g.add, x, y)) for x, y in zip(a, b, strict=True))


def matrix(g: Graph, rows: Row, by: Row, mask: int) -> Matrix:
    """Returns the derivatives of `rows` by the symbols `by`, whose kinds are in `mask`."""
    columns = Columns(g, rows, mask)
    found = [columns.column(symbol) for symbol in by]
    return tuple(tuple(column.get(row, ZERO) for column in found) for row in rows)


def energy_of(g: Graph, energies: Energies, motion: Motion, wanted: Wanted) -> Node:
    """Returns the energy v.p - L in the form of fewest operations. If T is homogeneous of degree 2
    in the rates, one candidate is T + V."""
    kinetic, potential = energies.kinetic, energies.potential
    candidates = []
    if kinetic is not None and degree(g, kinetic) == 2 and not g.depends[potential] & RATES:
        candidates.append(g.add(kinetic, potential))
        if not wanted("energy", "observe", "conserve"):
            return candidates[0]
    v = symbols(g, Kind.RATE, len(motion.momenta))
    work = g.dot(v, motion.momenta)
    candidates.append(g.subtract(work, energies.lagrangian))
    if wanted("energy") and len(reachable(g, candidates)) <= THOROUGH:
        candidates += [form for node in candidates for (form,) in forms(g, [node])]
    return min(candidates, key=lambda node: operations(g, [node]))


def shorter(g: Graph, energies: Energies, wanted: Wanted) -> Energies:
    """Returns the energies. The energies whose kernels are requested are rewritten in few
    operations."""
    found: dict[str, Node | None] = {}
    for name in ("lagrangian", "kinetic", "potential"):
        node = found[name] = getattr(energies, name)
        if node is not None and wanted(name) and len(reachable(g, [node])) <= THOROUGH:
            (found[name],) = fewest(g, [node])
    return replace(energies, **found)


def degree(g: Graph, output: Node) -> int | None:
    """Returns the degree of an expression that is homogeneous in the rates; None if it is not
    recognized as homogeneous."""
    found: dict[Node, int | None] = {}
    for node in reachable(g, [output], RATES):
        op, below = g.op[node], [found.get(a, 0) for a in g.args[node]]
        value: int | None = None
        if op is Op.SYMBOL:
            value = 1
        elif None not in below and op is Op.ADD and below[0] == below[1]:
            value = below[0]
        elif None not in below and op is Op.MULTIPLY:
            value = sum(below)
        elif None not in below and op is Op.POWER:
            power = g.data[node] * below[0]
            value = int(power) if power.denominator == 1 and power >= 0 else None
        found[node] = value
    return found.get(output, 0)
