"""Stiff, fast and forced motions, and what methods make of a step that is long for them."""

from math import atan

from .linear import axis_limit
from .prediction import CLOSED, MEASURED, ORDER
from .shown import shown

# By Taylor's series of order 30 in 30 digits, as van der Pol's periods are.
ROBERTSON = {"a": 0.71582706871940509, "b": 9.1855347645577639e-6, "c": 0.284163745745830352}
VAN_DER_POL = (
    (1, 6.66328685932313, "gauss", 100), (10, 19.078369566939014, "gauss", 100),
    (100, 162.83707109237, "radau", 500),
)  # fmt: skip
DECAY = "pkgen run decay.lag --set c=1000 --method {} --rtol 1e-3 --until 100 --every 100"
MEAN_STEP = '1000*report["t"]/report["steps"]'
ALIASED = "pkgen run aliased.lag --method {} --step 1 --until 100 --every 1"
GYRATION = "pkgen run gyration.lag --method {} --step 0.5 --until 500 --every {}"
FOLLOW = "for h in {}; do pkgen run follow.lag --method {} --step $h --until 4 --every 4; done"

PREDICTIONS = [
    *(
        shown(
            f"Q1{name}", "Robertson's reactions, radau, tolerance 1e-11", f"{name} at t = 40",
            value, 1e-9, "pkgen run robertson.lag --method radau --rtol 1e-11 --until 40",
            f"{name}[-1]", "--method gsl_msbdf",
        )
        for name, value in ROBERTSON.items()
    ),
    *(
        shown(
            f"Q2{'abc'[i]}", f"van der Pol's oscillator, mu = {mu}, {method}", "period",
            period, 1e-9,
            f"pkgen run van_der_pol.lag --set mu={mu} --method {method} --until {until}",
            'diff(times(report, "top"))[-1]', "--method dopri5 --rtol 1e-6",
        )
        for i, (mu, period, method, until) in enumerate(VAN_DER_POL)
    ),
    shown(
        "Q3a", "q'' = -1000 q', dopri5, tolerance 1e-3", "mean h lambda: the limit of its formula",
        axis_limit("dopri5", -1), CLOSED, DECAY.format("dopri5"), MEAN_STEP, "--method gsl_rkf45",
    ),
    shown(
        "Q3b", "q'' = -1000 q', dopri5, tolerance 1e-3", "mean h lambda: SciPy's RK45, the same "
        "formula, has 2.80", 2.80, MEASURED, DECAY.format("dopri5"), MEAN_STEP,
        "--method gsl_rkf45",
    ),
    shown(
        "Q4", "q'' = -1000 q', gauss1, h = 1", "A-stable, and rings: a step multiplies the rate by "
        "(1 - 500)/(1 + 500)", -499 / 501, 1e-9,
        "pkgen run decay.lag --set c=1000 --method gauss1 --step 1 --until 1 --every 1", "q'[-1]",
        "--method radau5",
    ),
    shown(
        "Q5a", "q' held to sin t by friction 1e6, gauss4", "order 8 falls to s = 4, R(inf) being 1",
        4.0, ORDER, FOLLOW.format("1 0.5 0.25 0.125", "gauss4"),
        "power of h: abs(q'[-1] - sin(t[-1]))", "--method gauss5",
    ),
    shown(
        "Q5b", "q' held to sin t by friction 1e6, gauss5", "order 10 falls to s + 1 = 6, R(inf) "
        "being -1", 6.0, ORDER, FOLLOW.format("2 1 0.5 0.25", "gauss5"),
        "power of h: abs(q'[-1] - sin(t[-1]))", "--method gauss4",
    ),
    *(
        shown(
            f"Q6{'abc'[i]}", f"x'' = cos(2 pi t), {method}, h = 1", "an alias: pushed steadily, by",
            push, 1e-9, ALIASED.format(method), "x'[-1]/t[-1]", "--method gauss",
        )
        for i, (method, push) in enumerate((("verlet", 1.0), ("gauss1", -1.0), ("rk4", -1 / 3)))
    ),
    shown(
        "Q7", "charge in a magnetic field, rk4, y = .5", "its energy falls by y^6/72 - y^8/576 a "
        "step", 0.5**6 / 72 - 0.5**8 / 576, 1e-6, GYRATION.format("rk4", 50),
        "1 - (energy[-1]/energy[0])**(1/1000)", "--method rk3",
    ),
    *(
        shown(
            f"Q8{'ab'[i]}", f"charge in a magnetic field, {method}, y = .5",
            "gyrates at 2 atan(y/2)/y of the true frequency", -2 * atan(0.25) / 0.5, 1e-9,
            GYRATION.format(method, 0.5), "unwrap(arctan2(y', x'))[-1]/t[-1]", f"--method {worse}",
        )
        for i, (method, worse) in enumerate((("gauss1", "gauss2"), ("boris", "boris4")))
    ),
    shown(
        "Q9", "Lorenz's equations, dop853", "largest Lyapunov exponent", 0.9056, 0.02,
        "pkgen run lorenz.lag --method dop853 --until 2000 --every 2000 --diagnose lyapunov",
        'report["diagnostics"]["lyapunov"]["exponent"]', "--method euler --step 0.02",
    ),
]  # fmt: skip
