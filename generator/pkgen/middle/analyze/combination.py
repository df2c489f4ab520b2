"""Writes a row as a linear combination of the rows of M with numbers, found modulo a prime.

If w = M x with numbers x, then M a = f gives w.a = x.f without the accelerations. An example is the
momentum of a body that is rotated or translated as a whole.
"""

from __future__ import annotations

from fractions import Fraction

from ...graph.graph import Graph, Node
from ...graph.normal import Normal
from ...graph.nullspace import Eliminated
from ...graph.residues import PRIME, Residues

DENOMINATORS = range(1, 13)
LARGEST = 1_000  # largest numerator tried


def combination(g: Graph, rows: list[list[Node]], wanted: list[Node]) -> list[Fraction] | None:
    """Returns the numbers x with M x = w, proved by normal forms; None if none are found or the
    proof fails."""
    found = _solved(Residues(g), rows, wanted)
    numbers = [_number(x) for x in found or ()]
    if found is None or None in numbers:
        return None
    normal = Normal(g)
    for row, entry in zip(rows, wanted, strict=True):
        made = g.sum(g.multiply(g.number(x), m) for x, m in zip(numbers, row, strict=True))
        if normal(g.subtract(entry, made)) != {}:
            return None
    return numbers


def _solved(residue: Residues, rows: list[list[Node]], wanted: list[Node]) -> list[int] | None:
    n, done = len(rows), Eliminated({}, [])
    for k, (row, right) in enumerate(zip(rows, wanted, strict=True)):
        values = [residue(entry) for entry in (*row, right)]
        if None in values:
            return None
        done.add({column: x for column, x in enumerate(values) if x}, k)
    if done.rows.keys() != set(range(n)):
        return None
    return [done.rows[k].get(n, 0) for k in range(n)]


def _number(residue: int) -> Fraction | None:
    for denominator in DENOMINATORS:
        top = residue * denominator % PRIME
        top = top - PRIME if top > PRIME // 2 else top
        if abs(top) <= LARGEST:
            return Fraction(top, denominator)
    return None
