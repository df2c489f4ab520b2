"""The rattleback's averaged equations, undamped, by quadrature.

With y' = S, P = p0 exp(lambda y) and R = sqrt(lambda) p0 exp(-y) from where S is largest, s0:

    y'^2 = s0^2 + (1 + lambda) p0^2 - p0^2 exp(2 lambda y) - lambda p0^2 exp(-2 y)

(Toda's potential for unlike walls), so the spin is reversed by pitching after the quarter to the
right, by rolling after that to the left. For lambda = 1 it is S0 sn: T = K(s0/s1)/s1, s1^2 = s0^2 +
4 p0^2.
"""

import mpmath as mp


def quarters(growth: float, p0: float, s0: float = 1) -> tuple[mp.mpf, mp.mpf]:
    """Times from the largest spin to rest through pitching, and from the least through rolling."""
    growth, p0, s0 = mp.mpf(growth), mp.mpf(p0), mp.mpf(s0)

    def quarter(side: int, guess: mp.mpf) -> mp.mpf:
        turn = mp.findroot(
            lambda y: s0**2 - p0**2 * (mp.expm1(2 * growth * y) + growth * mp.expm1(-2 * y)), guess
        )
        pitch, roll = mp.exp(2 * growth * turn), growth * mp.exp(-2 * turn)

        def under(u: mp.mpf) -> mp.mpf:
            # y = turn - side u^2 takes the root's singularity at the turn away.
            d = -side * u**2
            return 2 * u / mp.sqrt(-pitch * mp.expm1(2 * growth * d) - roll * mp.expm1(-2 * d)) / p0

        whole = mp.sqrt(abs(turn))
        return mp.quad(under, [0, whole / 4, whole / 2, whole])

    return quarter(1, mp.log(s0 / p0) / growth), quarter(-1, -mp.log(s0 / p0 / mp.sqrt(growth)))


def reversals(growth: float, p0: float, many: int, sense: int = 1) -> list[mp.mpf]:
    """When the spin is zero, begun with 1 (or -1)."""
    quarter = quarters(growth, p0)[::sense]
    times, now = [], mp.mpf(0)
    for k in range(many):
        times.append(now + quarter[k % 2])
        now += 2 * quarter[k % 2]
    return times


def damped(times: list[mp.mpf], friction: float) -> list[mp.mpf]:
    """What is left of these times under friction: tau = (1 - exp(-nu t))/nu."""
    return [-mp.log(1 - friction * t) / friction for t in times if friction * t < 1]
