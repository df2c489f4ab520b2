"""Tables, whose rows break steps, alias and ring; a corner rounded by hand; a relay that slides.

KN1: steps end at each row, and go on from there by h. Where a row is d = a + b long and steps of
Verlet are a and b, the trace over a row is 2 - (w d)^2 + a b d^2 w^4/4, the product of the matrices
of GNI I.1.4. It is below -2 for 2/sqrt(a d) < w < 2/sqrt(b d), a > b. A step that divides d has no
such band.
KN2: straight lines between samples at the rate s pass on each image f + n s of a frequency f,
times sinc(pi (f + n s)/s)^2 (M. Unser, Proc. IEEE 88 (2000) 569). At resonance an oscillator at
rest grows by half of its force over w.
KN3: rk4 takes the integral of a given force by Simpson's rule, which for |t| over a step h about
its corner is h^2/6 in place of h^2/4. Steps end at a corner of abs() or of a table, and the order
is kept (KN1c).
KN4: the bend M of a spline has M[k-1] + 4 M[k] + M[k+1] = 6 (y[k-1] - 2 y[k] + y[k+1])/d^2 (C. de
Boor, A Practical Guide to Splines, IV). A ramp of half of a digit q a row is logged with the error
+-q/4 in turn, so M = -+12 (q/4)/d^2. Fewer rows than digits, or an approximation, do not ring.
IF1: x = 1 - t^2/2, x' = -t meets x + c x' = 0 at t = sqrt(c^2 + 2) - c. Both sides lead back there
if |x'| < c (A. F. Filippov, Differential Equations with Discontinuous Righthand Sides, 1988).
"""

from math import pi, sin, sqrt

from .prediction import ORDER
from .shown import shown

STEP = 0.6  # of KN1, on rows 1 apart
ROWS = "for w in {}; do pkgen run rows.lag --set w=$w --method verlet --step 0.6 --until 6"
ROWS += " --every 2; done"
ROW_TRACE = "root of w: (x[3] - x[2] + x[1] - x[0])/(x[2] - x[1]) - 2"
ALIAS = (sin(3 * pi / 8) / (3 * pi / 8)) ** 2 / (2 * 6 * pi)

PREDICTIONS = [
    *(
        shown(
            f"KN1{'ab'[i]}", "oscillator beside a table of rows 1 apart, verlet, h = .6",
            f"rows break steps into a = .6 and b = .4: it grows {says}", 2 / sqrt(part), 1e-6,
            ROWS.format(between), ROW_TRACE, "--method gauss1",
        )
        for i, (says, part, between) in enumerate(
            (
                ("from w = 2/sqrt(a d), far below 2/h", STEP, "2.5 2.7"),
                ("to w = 2/sqrt(b d)", 1 - STEP, "3.1 3.22"),
            )
        )
    ),
    shown(
        "KN1c", "oscillator beside a table of rows 1 apart, rk4, its chart",
        "keeps its order at the corners: the error goes with the power of h", 4.0, ORDER,
        "pkgen chart rows.lag --methods rk4 --until 7 --quick --json",
        'slope(*errors(report, 1e-3, 0.1, "rk4", "rk3"))', "--methods rk3", long=True,
    ),
    shown(
        "KN2", "oscillator of 3 Hz, a sine of 5 Hz in a linear table of 8 rows a second, gauss",
        "resounds with the alias 8 - 5: grows by sinc(3 pi/8)^2/(2 w)", ALIAS, 1e-6,
        "pkgen run recorded.lag --method gauss --until 50 --every 1",
        "polyfit(t, hypot(x, x'/(6*pi)), 1)[0]", "--set w=10*pi",
        no_method="the table holds the alias, whatever the method: an oscillator of 5 Hz",
    ),
    shown(
        "KN3", "integral of sqrt((t - 1)^2 + 1e-18), rk4, h = 2/21",
        "steps over a corner that is rounded by hand: h^2/12 is lost", (2 / 21) ** 2 / 12, 1e-6,
        "pkgen run corner.lag --method rk4 --step 2/21 --until 2 --every 2", "1 - z[-1]",
        "--method gauss",
    ),
    shown(
        "KN4", "a ramp logged each d = .1 to q = .001, two rows to each, in a spline",
        "height'' is +-3 q/d^2 in turn, where the ramp has none", 3 * 1e-3 / 0.1**2, 1e-6,
        "pkgen run logged.lag --method gauss --until 6 --every 0.1", "max(abs(bend[20:41]))",
        "--set v=0.9", no_method="the spline rings, whatever the method: another speed",
    ),
    shown(
        "IF1", "mass under a relay, u = -sign(x + x'), from x = 1, gauss",
        "slides on x + x' = 0 from t = sqrt(3) - 1, and is stopped there", sqrt(3) - 1, 1e-9,
        "pkgen run relay.lag --method gauss --until 5",
        'report["last_valid"] if report["status"] == "PK_SLIDING" else 0',
        "--method euler --step 0.1",
    ),
]  # fmt: skip
