"""The double pendulum (D) and two coupled oscillators (O)."""

from math import log, pi, sqrt

from .prediction import BOUNDARY, MEASURED
from .shown import around, listed


def mode(sign: int) -> float:
    """Frequency of the double pendulum's modes: omega^2 = (2 -+ sqrt 2) g/l."""
    return sqrt((2 - sign * sqrt(2)) * 9.81)


SMALL = (
    'pkgen run ../../../models/double_pendulum.lag --start theta1=1e-5 --start "theta2={}" '
    '--start "theta1\'=0" --start "theta2\'=0" --method {} --until {} --every {}'
)
# Of what swings at one frequency, by recurrence of three samples.
FREQUENCY = "acos(sum({0}[1:-1]*({0}[2:] + {0}[:-2]))/(2*sum({0}[1:-1]**2)))/{1}"


OF_THE_FLOW = (
    "a mean over 1e5 s of the growth that belongs to the start; no worse method has been run for "
    "so long"
)

PREDICTIONS = [
    *(
        listed(
            id, f"double pendulum, {text} mode, gauss", "frequency", mode(sign), 1e-8,
            SMALL.format(f"{sign}*sqrt(2)*1e-5", "gauss", 400, 0.1),
            FREQUENCY.format("theta1", 0.1), "--method rk4 --step 0.05",
        )
        for id, text, sign in (("D1a", "slow", 1), ("D1b", "fast", -1))
    ),
    listed(
        "D1c", "double pendulum, rk4", "limit 2 sqrt 2 / omega of the fast mode",
        2 * sqrt(2) / mode(-1), BOUNDARY,
        f"for h in {around(2 * sqrt(2) / mode(-1))}; do "
        + SMALL.format("-1*sqrt(2)*1e-5", "rk4 --step $h", "1500*$h", "$h") + "; done",
        "edge of h: not max(abs(theta1[-200:])) < 1e-5", "--method rk3",
    ),
    *(
        listed(
            id, f"double pendulum from rest at {text}, gauss, 1e5 s",
            "largest Lyapunov exponent, per second", predicted, 0.05,
            SMALL.replace("1e-5", start.split()[0]).format(start.split()[1], "gauss", 1e5, 1e4)
            + " --diagnose lyapunov", 'abs(report["diagnostics"]["lyapunov"]["exponent"])',
            "--start theta1={} --start theta2={}".format(*other.split()), long=True,
            no_method=OF_THE_FLOW,
        )
        for id, text, start, predicted, other in (
            ("D2a", "pi/2, pi/2", "pi/2 pi/2", 0.926, "2 2"),
            ("D2b", "2, 2", "2 2", 1.343, "3 3"),
            ("D2c", "3, 3", "3 3", 1.005, "2 2"),
            ("D2d", ".5, .5", "0.5 0.5", (1e-9, 1e-3), "pi/2 pi/2"),
        )
    ),
    listed(
        "D3a", "double pendulum from rest at pi/2, pi/2, gauss1, h = .001",
        "reversal is lost near ln(1/eps)/lambda, lambda = .926", log(2**52) / 0.926, MEASURED,
        SMALL.replace("1e-5", "pi/2").format("pi/2", "gauss1 --step 0.001", 90, 90)
        + " --diagnose reversal",
        'mean([report["diagnostics"]["reversal"][end] for end in ("horizon_lo", "horizon_hi")])',
        "--method rk4 --step 0.01",
    ),
    listed(
        "D3b", "double pendulum from rest at .3, .3, gauss1, h = .001, to 60 s",
        "a regular orbit returns to its start but for", (1e-18, 1e-14), 0,
        SMALL.replace("1e-5", "0.3").format("0.3", "gauss1 --step 0.001", 60, 60)
        + " --diagnose reversal", 'report["diagnostics"]["reversal"]["times"][-1][1]',
        "--method rk4 --step 0.01",
    ),
    *(
        listed(
            id, f"two coupled masses, {method}", says, at, BOUNDARY,
            f"for h in {around(at)}; do pkgen run two_masses.lag --start x1=1 --start x2=-0.5 "
            f"--method {method} --step $h --until 1500*$h --every 1500*$h; done",
            f"edge of h: not energy[-1] < {grown}", f"--method {worse}",
        )
        for id, method, says, at, grown, worse in (
            ("O1a", "verlet", "limit 2 / sqrt(1 + 2 k_c)", sqrt(2), 1e6, "rk4"),
            ("O1b", "rk4", "limit 2 sqrt 2 / sqrt(1 + 2 k_c)", 2.0, 1.13, "verlet"),
        )
    ),
    listed(
        "O1c", "two coupled masses, gauss", "beat 2 pi/(sqrt 2 - 1)", 2 * pi / (sqrt(2) - 1), 1e-8,
        "pkgen run two_masses.lag --method gauss --until 400 --every 0.1",
        f"2*pi/({FREQUENCY.format('(x1 - x2)', 0.1)} - {FREQUENCY.format('(x1 + x2)', 0.1)})",
        "--method verlet --step 0.1",
    ),
]  # fmt: skip
