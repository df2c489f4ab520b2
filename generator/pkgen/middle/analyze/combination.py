"""Writes a vector w as M x with rational numbers x, found modulo a prime and then proved.

From M a = f follows w.a = x.f, which avoids solving for the accelerations a. For example, the total
linear or angular momentum has a time derivative of the form w.a + ..., with such a w.
"""

from __future__ import annotations

from fractions import Fraction

from ...graph.graph import Graph, Node
from ...graph.normal import Normal
from ...graph.nullspace import Eliminated
from ...graph.residues import PRIME, Residues

DENOMINATORS = range(1, 13)
LARGEST = 1_000  # the largest numerator of x that is tried


def combination(g: Graph, rows: list[list[Node]], wanted: list[Node]) -> list[Fraction] | None:
    """Returns rational numbers x with M x = w, where M is `rows` and w is `wanted`. The equation is
    proved by normal forms. Returns None if no x is found, or if the proof fails."""
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
