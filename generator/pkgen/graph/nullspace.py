"""The null space of a matrix whose entries are polynomials in parameters.

A fast elimination modulo a prime, with pseudorandom residues for the parameters, finds the
dimension of the null space, independent rows, and the columns in which solutions are nonzero. This
smaller matrix is solved exactly, over the field of rational functions of the parameters. A vector
is returned only if it solves all rows exactly.
Reference: J. von zur Gathen, J. Gerhard, Modern Computer Algebra, 3rd edition, chapter 5.
"""

from __future__ import annotations

import random
from dataclasses import dataclass
from fractions import Fraction
from functools import reduce
from math import gcd, lcm

from .nodes import Node
from .normal import Polynomial
from .residues import PRIME

Row = dict[int, Polynomial]  # the nonzero entries by column
Vector = dict[int, Polynomial]
Residues = dict[int, int]


@dataclass
class Eliminated:
    """A matrix in reduced row echelon form modulo PRIME. The pivot of a row is its first nonzero
    entry."""

    rows: dict[int, Residues]  # {column of the pivot: row}
    origin: list[int]  # The numbers of the rows that were independent of earlier rows when added.

    def reduce(self, row: Residues) -> Residues:
        for column in sorted(self.rows):
            factor = row.get(column)
            if factor:
                row = _combined(row, self.rows[column], -factor)
        return row

    def add(self, row: Residues, number: int) -> None:
        row = self.reduce(row)
        if not row:
            return
        pivot = min(row)
        inverse = pow(row[pivot], -1, PRIME)
        row = {c: x * inverse % PRIME for c, x in row.items()}
        for other, there in self.rows.items():
            if pivot in there:
                self.rows[other] = _combined(there, row, -there[pivot])
        self.rows[pivot] = row
        self.origin.append(number)


def _combined(a: Residues, b: Residues, factor: int) -> Residues:
    """Returns the row a + factor * b modulo PRIME."""
    result = dict(a)
    for column, value in b.items():
        total = (result.get(column, 0) + factor * value) % PRIME
        if total:
            result[column] = total
        else:
            result.pop(column, None)
    return result


def null_space(rows: list[Row], columns: int) -> list[Vector]:
    """Returns a basis of the null space. The entries of each vector are polynomials without a
    common factor, and the last nonzero one has a positive leading coefficient."""
    done = _eliminated(rows)
    free = {c for c in range(columns) if c not in done.rows}
    if not free:
        return []
    # All vectors of the null space are zero in the columns that `support` does not contain.
    support = sorted(free | {p for p, row in done.rows.items() if not free.isdisjoint(row)})
    place = {column: k for k, column in enumerate(support)}
    inside = [{place[c]: entry for c, entry in row.items() if c in place} for row in rows]
    inside = [row for row in inside if row]
    needed = [inside[number] for number in _eliminated(inside).origin]
    found = _solved(needed, inside, len(support))
    return [{support[k]: entry for k, entry in vector.items()} for vector in found]


def _eliminated(rows: list[Row]) -> Eliminated:
    draw = random.Random(2385)
    atoms = sorted({b for row in rows for p in row.values() for m in p for b, _ in m})
    at = {base: draw.randrange(2, PRIME) for base in atoms}
    done = Eliminated({}, [])
    for number, row in enumerate(rows):
        values = {c: _residue(entry, at) for c, entry in row.items()}
        done.add({c: x for c, x in values.items() if x}, number)
    return done


def _residue(polynomial: Polynomial, at: dict[Node, int]) -> int:
    total = 0
    for monomial, coefficient in polynomial.items():
        value = coefficient.numerator * pow(coefficient.denominator, -1, PRIME)
        for base, exponent in monomial:
            value = value * pow(at[base], exponent, PRIME) % PRIME
        total += value
    return total % PRIME


def _solved(needed: list[Row], every: list[Row], width: int) -> list[Vector]:
    from sympy import QQ, ring
    from sympy.polys.matrices import DomainMatrix

    atoms = sorted({b for row in every for p in row.values() for m in p for b, _ in m})
    position = {base: k for k, base in enumerate(atoms)}
    polynomials, *_ = ring([f"a{k}" for k in range(len(atoms))] or ["unused"], QQ)

    def element(polynomial: Polynomial):
        terms = {}
        for monomial, c in polynomial.items():
            powers = [0] * polynomials.ngens
            for base, exponent in monomial:
                powers[position[base]] = exponent
            terms[tuple(powers)] = QQ(c.numerator, c.denominator)
        return polynomials.from_dict(terms)

    def polynomial_of(x) -> Polynomial:
        return {
            tuple((atoms[k], e) for k, e in enumerate(powers) if e): Fraction(
                int(c.numerator), int(c.denominator)
            )
            for powers, c in x.terms()
        }

    rows = [{c: element(entry) for c, entry in row.items()} for row in every]
    table = [[element(row.get(c, {})) for c in range(width)] for row in needed]
    matrix = DomainMatrix(table, (len(table), width), polynomials.to_domain())
    found = []
    # The field of fractions is used because SymPy 1.11 has no null space over a ring.
    for vector in matrix.to_field().nullspace().to_list():
        whole = _without_common_factors(polynomials, _without_denominators(polynomials, vector))
        # Each vector is tested with all rows, also with rows that were left out as dependent.
        if all(sum((x * whole[c] for c, x in row.items()), polynomials.zero) == 0 for row in rows):
            found.append({k: polynomial_of(x) for k, x in enumerate(whole) if x})
    return found


def _without_denominators(ring, fractions: list) -> list:
    common = reduce(lambda a, x: a.lcm(x.denom), fractions, ring.one)
    return [x.numer * common.exquo(x.denom) for x in fractions]


def _without_common_factors(ring, vector: list) -> list:
    divisor = reduce(lambda a, x: a.gcd(x), vector, ring.zero)
    whole = [x.exquo(divisor) for x in vector]
    sign = -1 if next(x for x in reversed(whole) if x).LC < 0 else 1
    # A greatest common divisor over the rationals does not contain numeric factors.
    numbers = [c for x in whole for c in x.coeffs()]
    scale = lcm(*(int(c.denominator) for c in numbers))
    scale = Fraction(scale, gcd(*(int(c.numerator * (scale // c.denominator)) for c in numbers)))
    return [x * ring.domain(sign * scale.numerator, scale.denominator) for x in whole]
