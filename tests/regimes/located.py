"""What ends or bends a motion within a step: pulses, switches, peaks, singular times."""

from math import acos, asin, pi, sqrt

from .shown import shown

PEAK = "pkgen run peak.lag --method rk4 --step 0.7 --until 30"
BLOCK = "pkgen run dry_spring.lag --method gauss --until 20"
PLATEAU = pi + 2 * asin(0.5) + 2 * acos(0.5 / sqrt(0.8))  # to x = 1/2, over it and back, x < 1/2

PREDICTIONS = [
    shown(
        "V1", "x = t, rk4, h = .7", "sin(20 x) rises so many times to t = 30",
        int(30 * 20 / (2 * pi)), 0, PEAK, 'len(times(report, "often"))',
        "--until 29", no_method="events are looked for within a step, whatever made it",
    ),
    shown(
        "V2", "x = t, rk4, h = .7", "a peak of an event 1e-3 wide is between all that is looked at",
        (0.0, 0.0), 0, PEAK, 'len(times(report, "seen"))', "--method rk4 --step 0.0005",
    ),
    shown(
        "V3", "blow of unit area, 1e-6 wide, gauss", "seen: the rate behind it", 1.0, 1e-6,
        "pkgen run pulse.lag --set w=1e-6 --method gauss --until 10 --every 10", "x'[-1]",
        "--method rk4 --step 0.01",
    ),
    shown(
        "V4", "spring with a plateau of .1 from x = 1/2 on, gauss",
        "period pi + 2 asin(1/2) + 2 acos((1/2)/sqrt(.8))", PLATEAU, 1e-9,
        "pkgen run plateau.lag --method gauss --until 50", 'diff(times(report, "top"))[-1]',
        "--method verlet --step 0.1",
    ),
    shown(
        "V5", "block on a spring with dry friction .15, gauss",
        "loses .3 a swing, and sticks after the third, at t = 3 pi", 3 * pi, 1e-9, BLOCK,
        'report["last_valid"]', "--method rk2 --step 0.5",
    ),
    shown(
        "V6", "block on a spring with dry friction .15, gauss", "sticks at x", -0.1, 1e-6, BLOCK,
        'report["q"][0]', "--method rk2 --step 0.5",
    ),
    shown(
        "V7", "x' = x^2 from 1, dop853", "ends at t = 1/x(0)", 1.0, 1e-9,
        "pkgen run blow_up.lag --method dop853 --until 2", 'report["last_valid"]',
        "--method rk4 --step 0.01",
    ),
    shown(
        "V8", "straight fall to a centre from r = 1, gauss", "ends at t = pi/(2 sqrt 2)",
        pi / (2 * sqrt(2)), 1e-9, "pkgen run collapse.lag --method gauss --until 2",
        'report["last_valid"]', "--method verlet --step 0.01",
    ),
]  # fmt: skip
