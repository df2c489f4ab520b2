"""Finds constants of the motion by Noether's theorem, from symmetries of the Lagrangian.

The symmetries are point transformations

    t -> t + s tau,  q_i -> q_i + s xi_i,    xi_i = a_i + sum_j B_ij q_j + c_i t,  tau = d0 + d1 t

that change L dt, with the work of applied forces, by a total derivative dG of a polynomial G(q, t).
For each symmetry, I = sum xi_i p_i - tau h - G is constant. Along the equations of motion

    dI/dt = sum xi_i p_i' + sum p_i dxi_i/dt - tau dh/dt - h dtau/dt - dG/dt,
    dh/dt = v.(Q - dD/dv) - dL/dt,

which contains no accelerations. For each monomial in the variables q, v, t, dI/dt = 0 is a linear
equation for a, B, c, d0, d1 and the coefficients of G. The entries of this linear system are
polynomials in the parameters.
Reference: P. J. Olver, Applications of Lie Groups to Differential Equations, 2nd edition, 4.4.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import reduce

from ...equations import Equations, Matrix
from ...graph.collect import parted
from ...graph.exact import Exact
from ...graph.graph import MINUS_ONE, ONE, ZERO, Graph, Kind, Node, Op, Symbol
from ...graph.monomials import merged
from ...graph.normal import Monomial, Normal, Polynomial, TooMuch
from ...graph.nullspace import Row, Vector, null_space
from ...graph.wording import wording
from ...record import record
from ..structure import Indices, Invariant, Symmetries
from .along import Along
from .coupling import blocks_of
from .symmetries_blocks import BLOCK, block_energies

# The largest number of products of two terms that are computed for one normal form.
WORK = 100_000
# The largest number of nonzero entries of the linear system.
ENTRIES = 60_000
# The largest number of coordinates for which all entries of the matrix B are unknowns.
WHOLE = 9
# The unknowns, and the factors by which they are multiplied in I: q_i, Q for q_j, p_i, t and the
# energy h. The term of an unknown has a minus sign unless it has a momentum. A term with p_i
# belongs to xi_i, a term with h to tau, and any other term to G.
TERMS = {
    "tt": "tt",
    "t": "t",
    "qq": "qQ",
    "qt": "tq",
    "q": "q",
    "d1": "te",
    "c": "tp",
    "B": "Qp",
    "a": "p",
    "d0": "e",
}


@record
class Unknown:
    kind: str  # of TERMS
    i: int = 0
    j: int = 0


def symmetries(equations: Equations, coupled: Indices, influences: Indices) -> Symmetries:
    """Returns the constants of the motion. `coupled` are the blocks of M; `influences` is the field
    of Structure."""
    along = Along(equations, coupled)
    g = along.graph
    unknowns, searched = _ansatz(len(equations.coordinates), equations.mass, influences)
    columns = _columns(equations, along, unknowns)
    if columns is None:
        return Symmetries(g, (), "", ())
    alone = [k for k, column in enumerate(columns) if not column]
    others = [k for k, column in enumerate(columns) if column]
    found: list[Vector] = [{k: {(): 1}} for k in alone]
    rows = _rows(g, [columns[k] for k in others])
    why = "the model is large"
    try:
        solved = null_space(rows, len(others)) if sum(map(len, rows)) <= ENTRIES else None
    except ModuleNotFoundError:  # SymPy is optional: constants of the motion are only comments
        solved, why = None, "SymPy, which solves for the others, is not installed"
    if solved is None:
        searched = f"shifts of time and of single coordinates only: {why}"
    for vector in solved or ():
        found.append({others[k]: entry for k, entry in vector.items()})
    said = _Said(equations, g, unknowns)
    invariants = [said.invariant(vector) for vector in found]
    known = {x.name for x in invariants}
    invariants += block_energies(equations, along, blocks_of(influences, coupled), known)
    order = [_TIME, BLOCK, _CYCLIC, _POINT]
    invariants.sort(key=lambda x: (order.index(x.reason), len(x.terms)))
    return Symmetries(g, tuple(said.parameters), searched, tuple(invariants))


def _columns(
    equations: Equations, along: Along, unknowns: list[Unknown]
) -> list[Polynomial] | None:
    """Returns for each unknown its coefficient in dI/dt, as a polynomial. All coefficients may be
    multiplied by the same factor. Returns None if the coefficients are too large."""
    g = along.graph
    n = len(equations.coordinates)
    nodes = [*equations.pdot, *equations.momenta, equations.energy]
    nodes += [along.energy_rate(), ONE]
    # Without a common denominator, fewer terms cancel; it is used unless it takes too much work.
    made = Exact(g, WORK).numerators(nodes) or Exact(g, WORK).all(nodes)
    if made is None:
        return None
    exact = Exact(g, WORK)
    pdot, p, (h, h_rate, one) = made[:n], made[n : 2 * n], made[2 * n :]

    def plain(kind: str, index: int = 0) -> Polynomial:
        return {((g.symbol(Symbol(kind, index)), 1),): 1}

    def factor(letter: str, u: Unknown) -> tuple[Polynomial, Polynomial]:
        """Returns a factor of the invariant and its time derivative."""
        if letter == "t":
            return plain(Kind.TIME), {(): 1}
        if letter in "qQ":
            i = u.i if letter == "q" else u.j
            return plain(Kind.COORDINATE, i), plain(Kind.RATE, i)
        return (p[u.i], pdot[u.i]) if letter == "p" else (h, h_rate)

    def column(u: Unknown) -> Polynomial:
        """Returns the time derivative of the term of the invariant that the unknown u multiplies,
        by the product rule."""
        letters, total = TERMS[u.kind], {}
        for k, letter in enumerate(letters):
            others = (factor(other, u)[0] for other in letters[:k] + letters[k + 1 :])
            parts = [x for x in (factor(letter, u)[1], *others) if x != {(): 1}]
            term = reduce(exact.multiplied, sorted(parts, key=len) or [{(): 1}])
            total = exact.added(total, term)
        total = total if "p" in letters else {m: -c for m, c in total.items()}
        return total if letters[-1] in "pe" else exact.multiplied(total, one)

    try:
        return [column(u) for u in unknowns]
    except TooMuch:
        return None


def _rows(g: Graph, columns: list[Polynomial]) -> list[Row]:
    """Returns the linear equations, one for each monomial in q, v and t."""
    rows: dict[Monomial, Row] = {}
    for k, column in enumerate(columns):
        for monomial, coefficient in column.items():
            fixed, free = parted(g, monomial)
            rows.setdefault(free, {}).setdefault(k, {})[fixed] = coefficient
    return [_whole(rows[monomial]) for monomial in sorted(rows)]


def _whole(row: Row) -> Row:
    """Returns the equation multiplied by a power product of parameters, so that its coefficients
    have no negative exponents."""
    least: dict[Node, int] = {}
    for coefficient in row.values():
        for monomial in coefficient:
            for base, e in monomial:
                least[base] = min(e, least.get(base, 0))
    shift = tuple((base, -e) for base, e in sorted(least.items()) if e < 0)
    if not shift:
        return row
    return {k: {merged(m, shift): c for m, c in x.items()} for k, x in row.items()}


_TIME, _CYCLIC, _POINT = "time shift", "cyclic coordinate", "symmetry"


class _Said:
    """Converts solutions of the linear system to constants of the motion and their texts."""

    def __init__(self, equations: Equations, g: Graph, unknowns: list[Unknown]):
        self.graph, self.unknowns = g, unknowns
        self.normal = Normal(g)
        n = len(equations.coordinates)
        self.q = [quantity.name for quantity in equations.coordinates]
        self.parameters = [slot.quantity.name for slot in equations.parameters]
        self.p = [quantity.name for quantity in equations.momenta_names]
        self.nodes = {"t": g.symbol(Symbol(Kind.TIME)), "energy": equations.energy}
        self.nodes |= {self.q[i]: g.symbol(Symbol(Kind.COORDINATE, i)) for i in range(n)}
        self.nodes |= dict(zip(self.p, equations.momenta, strict=True))

    def invariant(self, vector: Vector) -> Invariant:
        g = self.graph
        entries = [(self.unknowns[k], self.normal.plain(x)) for k, x in sorted(vector.items())]
        kinds = [u.kind for u, _ in entries]
        # changes the sign of the invariant, so that the energy in it has a plus sign
        if "d0" in kinds:
            entries = [(u, g.negate(x)) for u, x in entries]
        terms, shifts = [], []
        order = list(TERMS)
        for u, x in sorted(entries, key=lambda e: (-order.index(e[0].kind), e[0].j, e[0].i)):
            q = {"q": self.q[u.i], "Q": self.q[u.j], "t": "t", "e": "energy", "p": self.p[u.i]}
            letters = TERMS[u.kind]
            factors = tuple(q[letter] for letter in letters)
            terms.append((x if "p" in letters else g.negate(x), factors))
            if letters[-1] in "pe":
                by = q["q" if letters[-1] == "p" else "t"]
                shifts.append((x if "d0" not in kinds else g.negate(x), factors[:-1], by))
        node = g.sum(g.multiply(x, g.product(self.nodes[f] for f in names)) for x, names in terms)
        generator = joined(
            [self._text(x, [*factors, f"d/d{by}"], " ") for x, factors, by in shifts]
        )
        name = joined([self._text(x, list(names), "*") for x, names in terms])
        reason = {("d0",): _TIME, ("a",): _CYCLIC}.get(tuple(kinds), _POINT)
        return Invariant(name, reason, generator, tuple(terms), node)

    def _text(self, coefficient: Node, names: list[str], times: str) -> str:
        counted = {name: names.count(name) for name in names}
        names = [name if k == 1 else f"{name}^{k}" for name, k in counted.items()]
        if coefficient in (ONE, MINUS_ONE):
            return ("-" if coefficient == MINUS_ONE else "") + times.join(names)
        text = wording(self.graph, coefficient, self._symbol)
        if self.graph.op[coefficient] is Op.ADD:
            text = f"({text})"
        return times.join([text, *names])

    def _symbol(self, symbol: Symbol) -> str:
        return self.parameters[symbol.index]


def joined(terms: list[str]) -> str:
    """Returns the text of a sum with the given terms."""
    return " + ".join(terms).replace("+ -", "- ")


def _ansatz(n: int, mass: Matrix, influences: Indices) -> tuple[list[Unknown], str]:
    """Returns the unknowns, and a text that describes the symmetries they include. The order
    matters: elimination expresses unknowns at the beginning of the list by later ones."""
    whole = n <= WHOLE
    pairs = [(i, j) for i in range(n) for j in range(n)]
    if not whole:
        pairs = sorted(_coupled(n, mass, influences))
    unknowns = [Unknown("tt"), Unknown("t")]
    if whole:
        unknowns += [Unknown("qq", i, j) for i in range(n) for j in range(i + 1)]
    unknowns += [Unknown(kind, i) for kind in ("qt", "q") for i in range(n)]
    unknowns += [Unknown("d1"), *(Unknown("c", i) for i in range(n))]
    unknowns += [Unknown("B", i, j) for i, j in pairs]
    unknowns += [*(Unknown("a", i) for i in range(n)), Unknown("d0")]
    if whole:
        return unknowns, "all point symmetries that are affine in coordinates and time"
    return unknowns, (
        f"shifts, boosts and scalings; of {n} coordinates only neighbours turn into each other"
    )


def _coupled(n: int, mass: Matrix, influences: Indices) -> Iterator[tuple[int, int]]:
    """Returns the pairs (i, j) of coordinates that are coupled by M or influence each other, and
    all pairs (i, i). If they are too many, only the pairs (i, i)."""
    found = {(i, i) for i in range(n)}
    found |= {(i, j) for i in range(n) for j in range(n) if mass[i][j] != ZERO}
    # States, which have no symmetries, may have indices from n on.
    near = {(i, j) for i, row in enumerate(influences[:n]) for j in row if j < n}
    found |= near | {(j, i) for i, j in near}
    few = len(found) <= WHOLE * n
    return iter(found if few else {(i, i) for i in range(n)})
