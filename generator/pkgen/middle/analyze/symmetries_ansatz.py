"""The unknown coefficients a, B, c, d0, d1 and G of the point transformations in symmetries.py."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from ...equations import Indices, Matrix
from ...graph.graph import ZERO
from ...record import record

# The largest number of coordinates for which all entries of the matrix B are unknowns.
WHOLE = 9


@record
class Unknown:
    kind: str  # of KINDS
    i: int = 0
    j: int = 0


@record
class Meaning:
    """How an unknown coefficient of one kind appears in the results. `factors` returns the names of
    the quantities by which the coefficient is multiplied in the constant of the motion, and `sign`
    is its sign there. `along` returns the term of the coefficient in the symmetry's generator, as
    the names of its factors and the variable x of d/dx. `along` is None for coefficients of G."""

    factors: Callable[[Unknown, list[str], list[str]], tuple[str, ...]]
    along: Callable[[Unknown, list[str]], tuple[tuple[str, ...], str]] | None
    sign: int = 1


KINDS = {
    "tt": Meaning(lambda u, q, p: ("t", "t"), None, -1),
    "t": Meaning(lambda u, q, p: ("t",), None, -1),
    "qq": Meaning(lambda u, q, p: (q[u.i], q[u.j]), None, -1),
    "qt": Meaning(lambda u, q, p: ("t", q[u.i]), None, -1),
    "q": Meaning(lambda u, q, p: (q[u.i],), None, -1),
    "d1": Meaning(lambda u, q, p: ("t", "energy"), lambda u, q: (("t",), "t"), -1),
    "c": Meaning(lambda u, q, p: ("t", p[u.i]), lambda u, q: (("t",), q[u.i])),
    "B": Meaning(lambda u, q, p: (q[u.j], p[u.i]), lambda u, q: ((q[u.j],), q[u.i])),
    "a": Meaning(lambda u, q, p: (p[u.i],), lambda u, q: ((), q[u.i])),
    "d0": Meaning(lambda u, q, p: ("energy",), lambda u, q: ((), "t"), -1),
}


def ansatz(n: int, mass: Matrix, influences: Indices) -> tuple[list[Unknown], str]:
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
    found |= {pair for i, row in enumerate(influences) for j in row for pair in ((i, j), (j, i))}
    few = len(found) <= WHOLE * n
    return iter(found if few else {(i, i) for i in range(n)})
