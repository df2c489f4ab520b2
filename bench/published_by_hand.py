"""Some of the published problems again, by nothing of pkgen: accelerations written out by hand, in
the 64-bit significands of numpy's longdouble, by Gragg's method and extrapolation (Hairer, Norsett,
Wanner I, II.9). tests/bench/test_published.py compares the references of published.py with them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy
from numpy import cos, longdouble, sin, sqrt

Array = numpy.ndarray
Acceleration = Callable[[Array, Array], Array]  # of q and q'
COLUMNS = 8  # of the table of extrapolation: order 16


def integrate(f: Acceleration, q: Sequence, v: Sequence, until: float, steps: int) -> Array:
    """q and q' at the end, by steps of one length."""
    y = numpy.array([*q, *v], dtype=longdouble)
    n, h = len(y) // 2, longdouble(until) / steps

    def slope(y: Array) -> Array:
        return numpy.concatenate([y[n:], f(y[:n], y[n:])])

    lost = numpy.zeros_like(y)  # what additions round away
    for _ in range(steps):
        change = _step(slope, y, h) - lost
        new = y + change
        lost, y = (new - y) - change, new
    return y


def _step(slope: Callable[[Array], Array], y: Array, h: longdouble) -> Array:
    first, table = slope(y), []
    for k in range(1, COLUMNS + 1):
        d = h / (2 * k)
        before, d_now = numpy.zeros_like(y), d * first
        for _ in range(2 * k - 1):
            before, d_now = d_now, before + 2 * d * slope(y + d_now)
        # Gragg's smoothing keeps the expansion in even powers.
        row = [(before + d_now + d * slope(y + d_now)) / 2]
        for j, old in enumerate(table, start=1):
            ratio = (longdouble(k) / (k - j)) ** 2
            row.append(row[-1] + (row[-1] - old) / (ratio - 1))
        table = row
    return table[-1]


def planets(until: float, steps: int) -> Array:
    """Of the outer planets and Pluto, from the sun: X, Y, Z of one after the other."""
    mass = numpy.array(
        [1.00000597682, 0.000954786104043, 0.000285583733151, 0.0000437273164546,
         0.0000517759138449, 1 / 1.3e8],
        dtype=longdouble,
    )  # fmt: skip
    x = [
        [0, 0, 0], [-3.5023653, -3.8169847, -1.5507963], [9.0755314, -3.0458353, -1.6483708],
        [8.3101420, -16.2901086, -7.2521278], [11.4707666, -25.7294829, -10.8169456],
        [-15.5387357, -25.2225594, -3.1902382],
    ]  # fmt: skip
    v = [
        [0, 0, 0], [0.00565429, -0.00412490, -0.00190589], [0.00168318, 0.00483525, 0.00192462],
        [0.00354178, 0.00137102, 0.00055029], [0.00288930, 0.00114527, 0.00039677],
        [0.00276725, -0.00170702, -0.00136504],
    ]  # fmt: skip
    G = longdouble(2.95912208286e-4)

    def f(q: Array, _: Array) -> Array:
        r = q.reshape(6, 3)
        apart = r[None] - r[:, None]
        squares = (apart**2).sum(axis=2)
        numpy.fill_diagonal(squares, 1)
        pulls = mass[None, :, None] * apart / (squares * sqrt(squares))[:, :, None]
        return G * pulls.sum(axis=1).ravel()

    end = integrate(f, numpy.ravel(x), numpy.ravel(v), until, steps)[:18].reshape(6, 3)
    return (end[1:] - end[0]).ravel()


def stiff_pendulum(until: float, steps: int) -> Array:
    def f(q: Array, _: Array) -> Array:
        r = sqrt(q @ q)
        return -q * (longdouble(10) ** 6 * (r - 1) / r) - numpy.array([0, 1])

    return integrate(f, [1, 0], [0, 0], until, steps)[:2]


def fpu_stiff(until: float, steps: int) -> Array:
    """I1, I2, I3 and their sum."""
    one = longdouble(1)

    def f(q: Array, _: Array) -> Array:
        pulled = numpy.zeros(7, dtype=longdouble)  # by the spring before each mass, and the wall
        pulled[1::2] = 1250 * (q[1::2] - q[::2])
        pulled[0], pulled[6] = 4 * q[0] ** 3, -4 * q[5] ** 3
        pulled[2:6:2] = 4 * (q[2:6:2] - q[1:5:2]) ** 3
        return pulled[1:] - pulled[:-1]

    q = [(1 - one / 50) / sqrt(2 * one), (1 + one / 50) / sqrt(2 * one), 0, 0, 0, 0]
    y = integrate(f, q, [0, sqrt(2 * one), 0, 0, 0, 0], until, steps)
    s, ds = (y[1:6:2] - y[:6:2]) / sqrt(2 * one), (y[7::2] - y[6::2]) / sqrt(2 * one)
    energies = (ds**2 + 2500 * s**2) / 2
    return numpy.array([*energies, energies.sum()])


def governor(until: float, steps: int) -> Array:
    """Height of the slider, angle of the rods, the shaft's rate. Both rods move alike, the angular
    momentum is conserved, and springs pull along the line from a rod's middle to the slider."""
    m, ms, ball, g = longdouble("0.3"), longdouble(3), longdouble(5), longdouble("9.81")
    thick, across = m * 2 * longdouble("1e-4") / 12, m * (1 + longdouble("1e-4")) / 12
    rod = ball + m / 4 + across  # about its hinge, both balls' arms 1

    def spin(a: longdouble) -> tuple[longdouble, longdouble]:
        """The moment of inertia about the shaft, and its derivative."""
        c, s = cos(a), sin(a)
        far, near = longdouble("0.05") + c, longdouble("0.05") + c / 2
        of = ball * far**2 + m * near**2 + across * c**2 + thick * s**2
        rate = -2 * ball * far * s - m * near * s - 2 * (across - thick) * c * s
        return thick + ms * longdouble("0.02") / 12 + 2 * of, 2 * rate

    start = numpy.arcsin(longdouble(1) / 2)
    momentum = spin(start)[0] * 12 * start  # 2 pi a second

    def f(q: Array, v: Array) -> Array:
        a, s = q
        c, n = cos(a), sin(a)
        dx, dz = c / 2, 1 - n / 2 - s
        d = sqrt(dx**2 + dz**2)
        rate = (-dx * n * v[0] / 2 + dz * (-c * v[0] / 2 - v[1])) / d
        pull = 8 * longdouble(10) ** 5 * (d - longdouble("0.5")) + 4 * longdouble(10) ** 4 * rate
        inertia, slope = spin(a)
        swing = momentum**2 / inertia**2 * slope / 4 + (ball + m / 2) * g * c
        swing -= pull * (-dx * n - dz * c) / (2 * d)
        return numpy.array([swing / rod, -g + 2 * pull * dz / (d * ms)])

    y = integrate(f, [start, longdouble("0.5")], [0, 0], until, steps)
    return numpy.array([y[1], y[0], momentum / spin(y[0])[0]])


def andrews(until: float, steps: int) -> Array:
    """The seven angles. Mass matrix and forces as the test set has them; the last rows of a linear
    system are the second derivatives of the constraints."""
    m1, m2, m3, m4, m5, m6, m7 = _numbers("0.04325 0.00365 0.02373 0.00706 0.0705 0.00706 0.05498")
    i1, i2, i3, i4 = _numbers("2.194e-6 4.410e-7 5.255e-6 5.667e-7")
    i5, i6, i7 = _numbers("1.169e-5 5.667e-7 1.912e-5")
    d, da, e, ea, rr, ra = _numbers("0.028 0.0115 0.02 0.01421 0.007 0.00092")
    ss, sa, sb, sc, sd = _numbers("0.035 0.01874 0.01043 0.018 0.02")
    ta, tb, u, ua, ub = _numbers("0.02308 0.00916 0.04 0.01228 0.00449")
    zf, zt, fa = _numbers("0.02 0.04 0.01421")
    xb, yb, xc, yc = _numbers("-0.03635 0.03273 0.014 0.072")
    c0, l0, mom = _numbers("4530 0.07785 0.033")
    k4, k6 = e - ea, zf - fa

    def f(q: Array, v: Array) -> Array:
        be, th, ga, ph, de, om, ep = q
        vb, vt, _, vp, vd, vo, ve = v
        a = numpy.zeros((13, 14), dtype=longdouble)
        a[0, 0] = m1 * ra**2 + m2 * (rr**2 - 2 * da * rr * cos(th) + da**2) + i1 + i2
        a[0, 1] = a[1, 0] = m2 * (da**2 - da * rr * cos(th)) + i2
        a[1, 1] = m2 * da**2 + i2
        a[2, 2] = m3 * (sa**2 + sb**2) + i3
        a[3, 3] = m4 * k4**2 + i4
        a[3, 4] = a[4, 3] = m4 * (k4**2 + zt * k4 * sin(ph)) + i4
        a[4, 4] = m4 * (zt**2 + 2 * zt * k4 * sin(ph) + k4**2) + m5 * (ta**2 + tb**2) + i4 + i5
        a[5, 5] = m6 * k6**2 + i6
        a[5, 6] = a[6, 5] = m6 * (k6**2 - u * k6 * sin(om)) + i6
        a[6, 6] = m6 * (k6**2 - 2 * u * k6 * sin(om) + u**2) + m7 * (ua**2 + ub**2) + i6 + i7
        xd, yd = sd * cos(ga) + sc * sin(ga) + xb - xc, sd * sin(ga) - sc * cos(ga) + yb - yc
        long = sqrt(xd**2 + yd**2)
        fx, fy = -c0 * (long - l0) / long * xd, -c0 * (long - l0) / long * yd
        b = a[:, 13]
        b[0] = mom - m2 * da * rr * vt * (vt + 2 * vb) * sin(th)
        b[1] = m2 * da * rr * vb**2 * sin(th)
        b[2] = fx * (sc * cos(ga) - sd * sin(ga)) + fy * (sd * cos(ga) + sc * sin(ga))
        b[3] = m4 * zt * k4 * vd**2 * cos(ph)
        b[4] = -m4 * zt * k4 * vp * (vp + 2 * vd) * cos(ph)
        b[5] = -m6 * u * k6 * ve**2 * cos(om)
        b[6] = m6 * u * k6 * vo * (vo + 2 * ve) * cos(om)
        # Each row is a sum of places r (cos w, sin w) with angles w of some coordinates.
        arms = [(rr, be, (0,)), (-d, be + th, (0, 1))]
        ends = ((ss, ga - right, (2,)),), ((e, ph + de - right, (3, 4)), (zt, de, (4,))), (
            (zf, om + ep, (5, 6)), (u, ep - right, (6,)),
        )  # fmt: skip
        for k, end in enumerate(ends):
            for r, w, of in [*arms, *((-r, w, of) for r, w, of in end)]:
                rate = sum(v[j] for j in of)
                for j in of:
                    a[7 + 2 * k, j] -= r * sin(w)
                    a[8 + 2 * k, j] += r * cos(w)
                b[7 + 2 * k] += r * cos(w) * rate**2
                b[8 + 2 * k] += r * sin(w) * rate**2
        a[:7, 7:13] = a[7:, :7].T
        return _solved(a)[:7]

    right = 2 * numpy.arctan(longdouble(1))
    q = _numbers(
        "-0.0617138900142764496358948458001 0 0.455279819163070380255912382449"
        " 0.222668390165885884674473185609 0.487364979543842550225598953530"
        " -0.222668390165885884674473185609 1.23054744454982119249735015568"
    )
    return integrate(f, q, [0] * 7, until, steps)[:7]


def _numbers(text: str) -> list[longdouble]:
    return [longdouble(x) for x in text.split()]


def _solved(a: Array) -> Array:
    """By elimination with pivots; the right side is the last column."""
    n = len(a)
    for k in range(n):
        pivot = k + int(numpy.argmax(abs(a[k:, k])))
        a[[k, pivot]] = a[[pivot, k]]
        a[k] /= a[k, k]
        rest = numpy.arange(n) != k
        a[rest] -= numpy.outer(a[rest, k], a[k])
    return a[:, n]
