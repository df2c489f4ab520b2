"""A rigid body without torque: Jacobi's elliptic functions, and the turn about L in a period.

I1 < I2 < I3. From omega = (w1, 0, w3) with more of the motion about the third axis than about the
first, I1 (I2 - I1) w1^2 < I3 (I3 - I2) w3^2,

    omega = (w1 cn, s sn, w3 dn)(p t, k),   p^2 = w3^2 (I3 - I1)(I3 - I2)/(I1 I2)

and else with the axes 1 and 3 interchanged (Landau, Lifshitz, Mechanics, section 37). L turns in
the body; about L, which is at rest in space, the body's third axis goes round at the rate phi' =
|L| (I1 w1^2 + I2 w2^2)/((I1 w1)^2 + (I2 w2)^2).
"""

import mpmath as mp


def modulus(inertia: tuple, w1: float, w3: float) -> tuple[mp.mpf, mp.mpf, bool]:
    """p, k^2 and whether it goes round the third axis (else round the first)."""
    i1, i2, i3 = map(mp.mpf, inertia)
    w1, w3 = mp.mpf(w1), mp.mpf(w3)
    one, three = i1 * (i2 - i1) * w1**2, i3 * (i3 - i2) * w3**2
    if one < three:
        return abs(w3) * mp.sqrt((i3 - i1) * (i3 - i2) / (i1 * i2)), one / three, True
    return abs(w1) * mp.sqrt((i3 - i1) * (i2 - i1) / (i2 * i3)), three / one, False


def rates(inertia: tuple, w1: float, w3: float, t: float) -> list[mp.mpf]:
    i1, i2, i3 = map(mp.mpf, inertia)
    p, m, third = modulus(inertia, w1, w3)
    sn, cn, dn = (mp.ellipfun(f, p * t, m=m) for f in ("sn", "cn", "dn"))
    w1, w3 = mp.mpf(w1), mp.mpf(w3)
    if third:
        top = w1 * mp.sqrt(i1 * (i3 - i1) / (i2 * (i3 - i2))) * mp.sign(w3)
        return [w1 * cn, top * sn, w3 * dn]
    top = w3 * mp.sqrt(i3 * (i3 - i1) / (i2 * (i2 - i1))) * mp.sign(w1)
    return [w1 * dn, top * sn, w3 * cn]


def period(inertia: tuple, w1: float, w3: float) -> mp.mpf:
    """After which all three rates are again what they were."""
    p, m, _ = modulus(inertia, w1, w3)
    return 4 * mp.ellipk(m) / p


def period_from_the_middle(inertia: tuple, w1: float, w2: float, w3: float) -> mp.mpf:
    """The same, begun at omega = (w1, w2, w3): of its energy and momentum."""
    i1, i2, i3 = map(mp.mpf, inertia)
    w1, w2, w3 = map(mp.mpf, (w1, w2, w3))
    twice = i1 * w1**2 + i2 * w2**2 + i3 * w3**2
    square = (i1 * w1) ** 2 + (i2 * w2) ** 2 + (i3 * w3) ** 2
    return period(
        inertia,
        mp.sqrt((twice * i3 - square) / (i1 * (i3 - i1))),
        mp.sqrt((square - twice * i1) / (i3 * (i3 - i1))),
    )


def turn_about_momentum(inertia: tuple, w1: float, w3: float) -> mp.mpf:
    """By how much the body is turned about L after a period of its rates."""
    i1, i2, i3 = map(mp.mpf, inertia)
    size = mp.sqrt((i1 * mp.mpf(w1)) ** 2 + (i3 * mp.mpf(w3)) ** 2)

    def precession(t: mp.mpf) -> mp.mpf:
        a, b, _ = rates(inertia, w1, w3, t)
        return size * (i1 * a**2 + i2 * b**2) / ((i1 * a) ** 2 + (i2 * b) ** 2)

    end = period(inertia, w1, w3)
    return 4 * mp.quad(precession, mp.linspace(0, end / 4, 9))
