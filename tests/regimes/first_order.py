"""Lagrangians of first degree in the rates: a form that vanishes, a collapse, two vortices.

FO1: L = e B (x + x^2/(2 R)) y' - k (x^2 + y^2)/2 has the form e B (1 + x/R), zero at x = -R, where
motions end (D. Correa-Restrepo, H. K. Wimmel, Phys. Scr. 32 (1985) 552). On the circle of radius r,
x = r cos(a), it is reached at t = e B/k (a + r/R sin(a)), cos(a) = -R/r.
FO2: vortices with G1 G2 + G2 G3 + G3 G1 = 0 and sum of Gi Gj dij^2 = 0 keep their shape and meet
(W. Groebli, 1877; H. Aref, Phys. Fluids 22 (1979) 393), at -d12^2 over its rate, of the size (2/pi)
G3 A (1/d23^2 - 1/d31^2), A the area. For 2, 2, -1 at d12^2 = 4, d23^2 = 2, d31^2 = 6 this is
3 sqrt(2) pi.
FO3 to FO6: the difference z of two equal vortices has z' = i z/|z|^2 in units of d and of 1/W, W
their rate; y = h W. By the midpoint rule |z| stays and sin(turn) = y, which has no root for y > 1,
though the rule is A-stable. A step of rk2 is (1 + i y/2)/(1 - i y/2): it has no limit, though no
step of rk2 is stable for an oscillator. By rk4 |z|^2 grows by 1 + y^6/144 + y^8/72 + O(y^10), where
that of an oscillator shrinks by 1 - y^6/72. By euler it grows by 1 + y^2, |z|^4 by 2 y^2 a step.
FO7: log x and log y turn about (1, 1) with the rate 1, where rk4 has its limit on the imaginary
axis (HW IV.2).
"""

from math import atan, pi, sqrt

from .prediction import BOUNDARY
from .shown import around, shown

CENTRE = "pkgen run ../../../models/particles/guiding_centre.lag --set R=1 --set k=5 --start x=2"
MEET = "pkgen run ../../../models/particles/point_vortices.lag"
MEET += ' --set "G[1]=2" --set "G[2]=2" --set "G[3]=-1" --start "x[1]=-1" --start "y[1]=0"'
MEET += ' --start "x[2]=1" --start "y[2]=0" --start "x[3]=1" --start "y[3]=sqrt(2)"'
PAIR = "pkgen run vortex_pair.lag --method {} --step {} --until {} --every {}"
TURN = "mean(diff(unwrap(arctan2(y_1_, x_1_))))"
APART = "hypot(x_1_ - x_2_, y_1_ - y_2_)[-1]"

PREDICTIONS = [
    shown(
        "FO1", "guiding centre, e B/k = 1, r = 2, where B falls to 0 at x = -1, dop853",
        "ends with PK_SINGULAR_TIME at t = 2 pi/3 + sqrt(3)", 2 * pi / 3 + sqrt(3), 1e-9,
        f"{CENTRE} --method dop853 --until 10",
        'report["last_valid"] if report["status"] == "PK_SINGULAR_TIME" else 0',
        "--method rk4 --step 0.01",
    ),
    shown(
        "FO2", "three vortices, 2, 2 and -1, of a shape that collapses, dop853",
        "meet, and end, at t = 3 sqrt(2) pi", 3 * sqrt(2) * pi, 1e-9,
        f"{MEET} --method dop853 --until 20", 'report["last_valid"]', "--method rk4 --step 0.01",
    ),
    shown(
        "FO3a", "two equal vortices, gauss1, h = .5 d^2 of them", "turn by asin(h W) a step",
        pi / 6, 1e-9, PAIR.format("gauss1", "0.5", "50", "0.5"), TURN, "--method gauss2",
    ),
    shown(
        "FO3b", "two equal vortices, gauss1", "A-stable, yet its equations have no root from "
        "h W = 1 on", 1.0, BOUNDARY,
        f"for h in {around(1)}; do {PAIR.format('gauss1', '$h', '12*$h', '$h')}; done",
        'edge of h: report["status"] != "PK_DONE"', "--method rk2",
    ),
    shown(
        "FO4", "two equal vortices, rk4, h W = .1",
        "spread: d^2 grows by y^6/144 + y^8/72 a step", 1e-6 / 144 + 1e-8 / 72, 1e-3,
        PAIR.format("rk4", "0.1", "200", "20"), f"({APART}**2)**(1/2000) - 1", "--method rk3",
    ),
    shown(
        "FO5", "two equal vortices, rk2, h W = 10", "no limit: stay apart, turn by 2 atan(y/2)",
        2 * atan(5), 1e-9, PAIR.format("rk2", "10", "1000", "10"), TURN, "--method rk4",
    ),
    shown(
        "FO6", "two equal vortices, euler, h W = .1, 1e4 steps",
        "spread as by friction: d^4 is 1 + 2 y^2 n", 201.0, 1e-3,
        PAIR.format("euler", "0.1", "1000", "100"), f"{APART}**4", "--method rk2",
    ),
    shown(
        "FO7", "Lotka's and Volterra's equations, rk4, their map", "rest is lost at h = 2 sqrt(2)",
        2 * sqrt(2), BOUNDARY, "pkgen stability lotka_volterra.lag --methods rk4 --quick --json",
        'mapped(report, "limit")', "--methods rk3", long=True,
    ),
]  # fmt: skip
