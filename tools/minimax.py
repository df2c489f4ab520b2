"""The polynomials of runtime/include/pk/sincos.h: minimax, by the exchange algorithm of E. Remez.

    .venv/bin/python tools/minimax.py

    sin r = r + r z S(z),  cos r = 1 - z/2 + z^2 C(z),  z = r^2,  |r| <= pi/4

S and C make the largest relative error of sin r and cos r as small as polynomials of their degree
can. Prints their coefficients rounded to the type, as C has them, and the errors before and after
rounding, in half units in the last place of 1.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from mpmath import cos, lu_solve, matrix, mp, mpf, nstr, pi, polyval, sin, sqrt, workprec

PRECISION = 250  # bits

# A little beyond pi/4, since k is rounded from a product that is.
END = (pi / 4 * (1 + mpf(2) ** -9)) ** 2
DEGREES = {"double": (53, 5, 5), "float": (24, 2, 2)}

Function = Callable[[mpf], mpf]


@dataclass(frozen=True)
class Target:
    """What to approximate on [0, END], and the weight that makes its error a relative one."""

    name: str
    value: Function
    weight: Function


def _sine(z: mpf) -> mpf:
    r = sqrt(z)
    return (sin(r) / r - 1) / z


def _cosine(z: mpf) -> mpf:
    return (cos(sqrt(z)) - 1 + z / 2) / z**2


TARGETS = [
    Target("S", _sine, lambda z: z * sqrt(z) / sin(sqrt(z))),
    Target("C", _cosine, lambda z: z**2 / cos(sqrt(z))),
]


def remez(target: Target, degree: int) -> tuple[list[mpf], mpf]:
    """Coefficients, lowest first, and the largest weighted error."""
    # Both functions are 0/0 at 0, and the weight vanishes there: start a little later.
    count, start = degree + 2, END / 10**6
    points = [_chebyshev(i / mpf(count - 1), start) for i in range(count)]
    grid = [_chebyshev(i / mpf(60 * count), start) for i in range(60 * count + 1)]
    for _ in range(10):
        rows = matrix(count, count)
        for i, z in enumerate(points):
            for j in range(degree + 1):
                rows[i, j] = z**j
            rows[i, degree + 1] = (-1) ** i / target.weight(z)
        solved = lu_solve(rows, matrix([target.value(z) for z in points]))
        coefficients = list(solved)[: degree + 1]
        errors = [(z, error(target, coefficients, z)) for z in grid]
        points = _extrema(errors, count)
    return coefficients, max(abs(e) for _, e in errors)


def _chebyshev(fraction: mpf, start: mpf) -> mpf:
    return start + (END - start) * (1 - cos(pi * fraction)) / 2


def error(target: Target, coefficients: Sequence[mpf], z: mpf) -> mpf:
    return target.weight(z) * (target.value(z) - polyval(list(coefficients)[::-1], z))


def _extrema(errors: list[tuple[mpf, mpf]], count: int) -> list[mpf]:
    """Where the error is largest between its zeros; `count` neighbours of alternating sign."""
    best: list[tuple[mpf, mpf]] = []
    for z, e in errors:
        if best and (e > 0) == (best[-1][1] > 0):
            if abs(e) > abs(best[-1][1]):
                best[-1] = (z, e)
        else:
            best.append((z, e))
    assert len(best) >= count, "the error does not alternate"
    kept = best[:count] if abs(best[0][1]) >= abs(best[-1][1]) else best[-count:]
    return [z for z, _ in kept]


def _without(target: Target, lowest: mpf) -> Target:
    """What the higher coefficients have to approximate, once the lowest is settled."""
    return Target(
        target.name,
        lambda z: (target.value(z) - lowest) / z,
        lambda z: target.weight(z) * z,
    )


def rounded(value: mpf, bits: int) -> mpf:
    mantissa, exponent = mp.frexp(value)
    return mp.ldexp(mp.nint(mp.ldexp(mantissa, bits)), exponent - bits)


@workprec(PRECISION)
def polynomial(target: Target, bits: int, degree: int) -> tuple[list[float], mpf, mpf]:
    """Coefficients as the type has them, and the error before and after rounding them."""
    exact, before = remez(target, degree)
    at_once = [rounded(c, bits) for c in exact]
    # Or the lowest first, and the others make up for it as far as they can.
    in_turn, rest = at_once[:1], _without(target, at_once[0])
    for left in range(degree - 1, -1, -1):
        in_turn.append(rounded(remez(rest, left)[0][0], bits))
        rest = _without(rest, in_turn[-1])
    grid = [END * (i + 1) / 1000 for i in range(1000)]
    found = [(max(abs(error(target, c, z)) for z in grid), c) for c in (at_once, in_turn)]
    after, coefficients = min(found)
    return [float(c) for c in coefficients], before * 2**bits, after * 2**bits


def main() -> None:
    for scalar, (bits, *degrees) in DEGREES.items():
        for target, degree in zip(TARGETS, degrees, strict=True):
            coefficients, before, after = polynomial(target, bits, degree)
            print(f"{target.name} in {scalar}: {nstr(before, 3)}, rounded {nstr(after, 3)}")
            for c in coefficients:
                print(f"    {c.hex()}")


mp.prec = PRECISION

if __name__ == "__main__":
    main()
