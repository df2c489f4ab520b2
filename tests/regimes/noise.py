"""A bath by steps: rates too cold, a spread too wide, heat without a source.

BA1: of a harmonic well baoab has the right places, and rates of kT (1 - (h w)^2/4) (B. Leimkuhler,
C. Matthews, Appl. Math. Res. Express 2013, 34).
BA2: without a well the rates of its steps are those of the bath, and the way is their trapezoidal
sum: with C = coth(c h/2) it is h^2 kT (n C - 3/4 C^2) squared after n steps from rest, up to e^(-c
h n). The bath's own is 2 kT (t - 3/2)/c^2 for c = 1, and that of stochastic_verlet (N.
Gronbech-Jensen, O. Farago, Mol. Phys. 111 (2013) 983).
BA3: a step of heun is R = 1 + h A + h^2 A^2/2 and a shove by 1 + h A/2. The energy of an oscillator
grows by (h w)^4/4 in it, here by more than friction takes.
BA4: stochastic_verlet is stable where Verlet is, for any friction.
"""

from math import tanh

import numpy as np

from .prediction import BOUNDARY
from .shown import around, shown

STATISTICS = 0.02  # three deviations of a variance of 50,000
BATH = "pkgen run bath.lag --scene many --method {} --step {} --until {}"
LONG = "--step $h --until 20000*$h --every 20000*$h"


def heated(h: float, c: float, steps: int) -> float:
    """The variance of places."""
    a, s = np.array([[0, 1], [-1, -c]]), np.zeros((2, 2))
    r, shove = np.eye(2) + h * a + h * h * a @ a / 2, np.array([h / 2, 1 - h * c / 2])
    for _ in range(steps):
        s = r @ s @ r.T + 2 * c * h * np.outer(shove, shove)
    return float(s[0, 0])


PREDICTIONS = [
    shown(
        "BA1", "50,000 oscillators in a bath, c = .5, kT = 1, baoab, h w = 1",
        "rates are too cold, by 1 - (h w)^2/4", 0.75, STATISTICS,
        BATH.format("baoab", 1, 24) + " --set c=0.5", "mean(q'**2)", "--method heun",
    ),
    shown(
        "BA2", "50,000 particles in a bath, c = kT = 1, baoab, h = 2, 20 steps",
        "spread too far, by c h/2 coth(c h/2) in the end", 4 * (20 / tanh(1) - 0.75 / tanh(1) ** 2),
        STATISTICS, BATH.format("baoab", 2, 40) + " --set k=0", "mean(q**2)",
        "--method stochastic_verlet",
    ),
    shown(
        "BA3", "50,000 oscillators in a bath, c = .1, kT = 1, heun, h w = .8, 25 steps",
        "heat up, though damped: the mean of q^2", heated(0.8, 0.1, 25), STATISTICS,
        BATH.format("heun", 0.8, 20) + " --set c=0.1", "mean(q**2)", "--method baoab",
    ),
    shown(
        "BA4", "oscillator in a cold bath, c = .5, stochastic_verlet", "grows from h w = 2 on",
        2.0, BOUNDARY,
        f"for h in {around(2)}; do pkgen run bath.lag --set kT=0 --set c=0.5 --method "
        f"stochastic_verlet {LONG}; done", "edge of h: not abs(q[-1]) < 1", "--method heun",
    ),
]  # fmt: skip
