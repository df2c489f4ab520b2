"""The table rows of elliptic functions and of Kepler's equation. m is the parameter, k^2 of the
modulus k, at most 1; beyond it the values are NaN.

Reference: M. Abramowitz, I. Stegun, Handbook of Mathematical Functions, 16.4 and 17.6, by the
arithmetic-geometric mean of 1 and sqrt(1 - m); J. Danby, Fundamentals of Celestial Mechanics, 6.6.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from .interval import POSITIVE
from .row import DIVISOR, Function

_MOST = 16  # halvings; a number of 113 bits needs 10


def _means(m: float) -> tuple[float, list[tuple[float, float]]]:
    """Returns the mean of 1 and sqrt(1 - m); of each step on the way r = (a - b)/(a + b), and
    sqrt(1 - r^2)."""
    a, b, ratios = 1.0, math.sqrt(1 - m), []
    for _ in range(_MOST):
        r = (a - b) / (a + b)
        a, b = (a + b) / 2, math.sqrt(a * b)
        ratios.append((r, b / a))
        if not 1 + r * r > 1:
            break
    return b, ratios


def _ellipk(m: float) -> float:
    return math.inf if m == 1 else math.pi / (2 * _means(m)[0])


def _am(u: float, m: float) -> float:
    if m == 1:
        return 2 * math.atan(math.tanh(u / 2))
    mean, ratios = _means(m)
    phi = mean * u * 2 ** len(ratios)
    for r, rest in reversed(ratios):  # atan2 is asin(r sin) without its loss of digits near 1
        s, c = math.sin(phi), math.cos(phi)
        phi = (phi + math.atan2(r * s, math.hypot(c, rest * s))) / 2
    return phi


def _kepler(M: float, e: float) -> float:
    """Returns E = M + d with E - e sin E = M, by Newton's method for d. For M between 0 and pi the
    equation is convex in d: steps from the upper end min(e, pi - M) shrink until they are rounding.
    """
    d = math.copysign(min(e, math.pi - math.acos(math.cos(M))), math.sin(M))
    step, last = 4.0, 8.0
    while abs(step) < abs(last):
        last, step = step, (d - e * math.sin(M + d)) / (1 - e * math.cos(M + d) or 1)
        d -= step
    return M + d + 0 * math.sqrt(e - e * e)


def _array(real: Callable[..., float]) -> Callable:
    def known(*x: float) -> float:
        try:
            return real(*x)
        except ValueError:
            return math.nan

    return lambda np, *x: np.vectorize(known, otypes=[float])(*x)


def _dn(g, am, m):
    """Returns dn = sqrt(cos^2 + (1 - m) sin^2) of the amplitude, the derivative of am by u."""
    squares = (g.power(g.call(name, am), 2) for name in ("cos", "sin"))
    cn, sn = squares
    return g.call("sqrt", g.add(cn, g.multiply(g.subtract(g.number(1), m), sn)))


def _along_orbit(g, n, e):
    """Returns the derivatives of E by M and by e."""
    inverse = g.power(g.subtract(g.number(1), g.multiply(e, g.call("cos", n))), -1)
    return inverse, g.multiply(g.call("sin", n), inverse)


_MEANS = f"""\
    pk_real a = 1, b = PK_F(sqrt)(1 - m), r[{_MOST}], rest[{_MOST}];
    int n = 0;
    do {{
        const pk_real mean = PK_F(sqrt)(a * b);
        r[n] = (a - b) / (a + b);
        a = (a + b) / 2;
        b = mean;
        rest[n] = b / a;
        n++;
    }} while (1 + r[n - 1] * r[n - 1] > 1 && n < {_MOST});
"""

ELLIPTIC: dict[str, Function] = {
    "ellipk": Function(
        arguments=("m",),
        real=_ellipk,
        array=_array(_ellipk),
        undefined=lambda m: "ellipk of a number that is not below 1" if m >= 1 else "",
        derivative=lambda g, n, m: (g.number(0),),
        still="m",
        interval=lambda m: POSITIVE,
        steps=_MEANS.replace(f", rest[{_MOST}]", "").replace("        rest[n] = b / a;\n", ""),
        body="PK_F(acos)(0 * a) / b",
        note="The complete elliptic integral K(m), by the arithmetic-geometric mean.",
        sympy="elliptic_k",
    ),
    "am": Function(
        arguments=("u", "m"),
        real=_am,
        array=_array(_am),
        undefined=lambda u, m: "am of a parameter beyond 1" if m > 1 else "",
        derivative=lambda g, n, u, m: (_dn(g, n, m), g.number(0)),
        still="m",
        steps=f"""{_MEANS}\
    for (int i = 0; i < n; i++)
        u += u;
    pk_real phi = b * u;
    while (n-- > 0) {{
        const pk_real s = PK_F(sin)(phi), c = PK_F(cos)(phi);
        const pk_real far = PK_F(sqrt)(c * c + rest[n] * s * (rest[n] * s));
        phi = (phi + PK_F(atan2)(r[n] * s, far)) / 2;
    }}
""",
        body="m == 1 ? 2 * PK_F(atan)(PK_F(tanh)(u / 2)) : phi",
        note="Jacobi's amplitude of u and the parameter m, by the arithmetic-geometric mean.",
    ),
    "kepler": Function(
        arguments=("M", "e"),
        real=_kepler,
        array=_array(_kepler),
        undefined=lambda M, e: "" if 0 <= e <= 1 else "kepler of an eccentricity outside [0, 1]",
        derivative=lambda g, n, M, e: _along_orbit(g, n, e),
        singular=lambda g, M, e: (g.subtract(g.number(1), e), DIVISOR),
        steps="""\
    const pk_real far = PK_F(acos)(0 * e - 1) - PK_F(acos)(PK_F(cos)(M)), side = PK_F(sin)(M);
    pk_real d = (e < far ? e : far) * (side < 0 ? -1 : 1), step = 4, last;
    do {
        const pk_real slope = 1 - e * PK_F(cos)(M + d);
        last = step;
        step = (d - e * PK_F(sin)(M + d)) / (slope > 0 ? slope : 1);
        d -= step;
    } while (PK_F(fabs)(step) < PK_F(fabs)(last));
""",
        body="M + d + 0 * PK_F(sqrt)(e - e * e)",
        remark="NaN for e outside [0, 1]",
        note="The E of Kepler's equation E - e sin(E) = M.",
    ),
}
