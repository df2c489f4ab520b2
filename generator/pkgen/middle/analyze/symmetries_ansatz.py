"""The unknown coefficients of a point transformation and of its gauge term, and their meaning."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from ...equations import Indices, Matrix
from ...graph.graph import ZERO
from ...record import record

WHOLE = 9  # largest number of coordinates for which every xi_i may contain every q_j


@record
class Unknown:
    kind: str  # of KINDS
    i: int = 0
    j: int = 0


@record
class Meaning:
    """The meaning of a kind of unknown. `factors` makes its factors in the invariant, `along` its
    term of the generator: factors and the variable of d/d. The gauge term G has no `along`."""

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
    """Returns the unknowns, first those to be solved for in terms of others, and a description."""
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
    """Returns the ordered pairs of coordinates coupled by M or by influence; if there are too many,
    the pairs (i, i) only."""
    found = {(i, i) for i in range(n)}
    found |= {(i, j) for i in range(n) for j in range(n) if mass[i][j] != ZERO}
    found |= {pair for i, row in enumerate(influences) for j in row for pair in ((i, j), (j, i))}
    few = len(found) <= WHOLE * n
    return iter(found if few else {(i, i) for i in range(n)})
