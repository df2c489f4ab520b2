"""What steps too long, or of the wrong kind, do to a motion: ghosts, parasites, chatter, drifts."""

from math import acosh, atan, cos, exp, log, pi, sin, sqrt

from .prediction import BOUNDARY, CLOSED, MEASURED, ORDER
from .shown import shown


def two_cycle(h: float) -> tuple[float, float]:
    """Of x + h x (1 - x), with the values h x - (1 + h/2) = +-sqrt(h^2 - 4)/2."""
    return (2 + h - sqrt(h * h - 4)) / (2 * h), (2 + h + sqrt(h * h - 4)) / (2 * h)


def parasite(h: float) -> tuple[float, float]:
    """When the second root of r^2 + 2 h r - 1 = 0 has overtaken the first, from y_1 = exp(-h), and
    the first step behind it at which y < 0: both are found where the second is the greater."""
    slow, fast = sqrt(1 + h * h) - h, -sqrt(1 + h * h) - h
    a = (exp(-h) - fast) / (slow - fast)
    n = log(a / (1 - a)) / log(-fast / slow)
    odd = 2 * int((n + 1) / 2) + 1  # the first odd step beyond n, where its sign is minus
    return n * h, odd * h


def impulse_limit(omega: float, k: float) -> float:
    """The step at which 2 cos(omega h) - (h k/omega) sin(omega h), the trace of a kick and a turn,
    is -2 below omega h = pi."""
    h = pi / omega
    for _ in range(60):
        h = 2 / omega * atan(2 * omega / (h * k))
    return h


def trace(h: float) -> float:
    return 2 * cos(10 * h) - h / 10 * sin(10 * h)


def radau5(y: float) -> float:
    """|R(iy)|^2, HW IV.3: the (2, 3) Pade approximant of exp."""
    z = 1j * y
    return abs((1 + 2 * z / 5 + z * z / 20) / (1 - 3 * z / 5 + 3 * z * z / 20 - z**3 / 60)) ** 2


LOGISTIC = "pkgen run logistic.lag --method euler --step 2.3 --until 460 --every 2.3"
TWO_STEP = "pkgen run two_step.lag --method verlet --step 0.2 --until 10 --every 0.2"
INDEX_ONE = "pkgen run index_one.lag --method rk4 --step 0.02 --until 40 --every 10"
RESPA = (
    "pkgen run two_springs.lag --method respa --step {0} --max-step {0}/1000 --until {1} "
    "--every {0}"
)
EJECTED = (
    'pkgen run kepler.lag --set e=0.99 --start x=1.99 --start "y\'=sqrt(0.01/1.99)" '
    "--method verlet --step {} --until {}"
)

EJECTED_LATER = (
    "when it is ejected is chaotic: each passage of the centre multiplies round-off. By a program "
    "of its own, with plain sums, it is at 32.9, and from 1e-15 further in at 142.5."
)

PREDICTIONS = [
    *(
        shown(
            id, "x' = x (1 - x), euler, h = 2.3", f"ends in a 2-cycle: its {end}",
            two_cycle(2.3)[i], 1e-9, LOGISTIC, f"{end}(x[-2:])", "--method rk4",
        )
        for i, (id, end) in enumerate((("G1a", "min"), ("G1b", "max")))
    ),
    shown(
        "G2", "x' = x (1 - x), rk2, h = 2.5", "comes to rest at 2/h, a ghost", 0.8, 1e-9,
        "pkgen run logistic.lag --method rk2 --step 2.5 --until 500 --start x=0.7", "x[-1]",
        "--method rk4",
    ),
    shown(
        "G3a", "y' = -y, two-step midpoint rule, h = .1", "the parasitic root has overtaken at t",
        parasite(0.1)[0], CLOSED, TWO_STEP, "first(t[q*exp(t) > 2])", "--method rk4",
    ),
    shown(
        "G3b", "y' = -y, two-step midpoint rule, h = .1", "y < 0 first at t",
        parasite(0.1)[1], 1e-9, TWO_STEP, "first(t[q' + 0.1*q > 0]) + 0.1", "--method rk4",
    ),
    *(
        shown(
            f"G4{'abc'[i]}", "pendulum of index 1 in x and y, rk4, h = .02, nothing projected",
            f"l^2 is lost, as t^2: at t = {t}", -lost, CLOSED, INDEX_ONE, f"stretch[{t // 10}]",
            "--method gauss",
        )
        for i, (t, lost) in enumerate(((10, 1.14e-3), (20, 4.59e-3), (40, 0.0184)))
    ),
    shown(
        "G5", "oscillator, radau5, y = .5", "the energy shrinks by 1 - |R|^2 a step",
        1 - radau5(0.5), 1e-6,
        "pkgen run oscillator.lag --method radau5 --step 0.5 --until 5000 --every 500 "
        "--record energy",
        "1 - (energy[-1]/energy[0])**(1/10000)", "--method radau9",
    ),
    shown(
        "G6", "oscillator, gauss1, y = 20", "its frequency saturates, at 2 atan(y/2)/y of the true",
        2 * atan(10) / 20, 1e-9,
        "pkgen run oscillator.lag --method gauss1 --step 20 --until 4000 --every 20",
        "acos(sum(q[1:-1]*(q[2:] + q[:-2]))/(2*sum(q[1:-1]**2)))/20", "--method gauss2",
    ),
    shown(
        "G7", "block at rest by dry friction, euler, h = .01",
        "chatters for ever, by what its last step before rest has left: v0 mod mu g h",
        1 % 0.02943, 1e-9,
        "pkgen run dry.lag --method euler --step 0.01 --until 1 --every 0.01", "max(abs(x'[60:]))",
        "--method rk4",
    ),
    shown(
        "G8", "ball that bounces by .8, gauss, floor located", "ends at t, of infinitely many",
        2 * 5 / 9.81 / (1 - 0.8), 1e-6,
        "pkgen run bounces.lag --method gauss --until 6", 'report["last_valid"]',
        "--method euler --step 0.01",
    ),
    shown(
        "G9a", "Kepler, e = .6, rk4, 400 steps an orbit", "the energy that an orbit loses",
        -1.038e-7, CLOSED,
        "pkgen run kepler.lag --method rk4 --step 2*pi/400 --until 2*pi --record energy",
        "energy[-1] - energy[0]", "--method rk3",
    ),
    shown(
        "G9b", "Kepler, e = .6, rk4", "the energy that an orbit loses goes with the power of h",
        5, ORDER,
        "for n in 400 800 1600; do pkgen run kepler.lag --method rk4 --step 2*pi/$n --until 2*pi "
        "--record energy; done", "power of n: 1/abs(energy[-1] - energy[0])", "--method rk3",
    ),
    *(
        shown(
            f"G10{'ab'[i]}", f"Kepler from the apocentre, e = .99, verlet, h = {h}",
            "is ejected: unbound and beyond r = 4 at t", at, MEASURED,
            EJECTED.format(h, until), "first(t[(energy > 0)*(hypot(x, y) > 4)])",
            "--method gauss", missed=EJECTED_LATER if i else "",
        )
        for i, (h, at, until) in enumerate(((0.005, 3.45, 10), (0.001, 33.5, 50)))
    ),
    *(
        shown(
            f"G11{'ab'[i]}", "fast spring, omega = 10, and slow one, k = 1, respa",
            f"resonance at half the fast period: unstable {says}", at, BOUNDARY,
            f"for h in {between}; do {RESPA.format('$h', '3*$h')}; done",
            "root of h: (q[2] + q[0])/q[1] + 2", "--method respa4",
        )
        for i, (says, at, between) in enumerate(
            (
                ("from h = 2 atan(2 omega/(h k))/omega", impulse_limit(10, 1), "0.309 0.313"),
                ("to h = pi/omega", pi / 10, "0.313 0.318"),
            )
        )
    ),
    shown(
        "G11c", "fast spring, omega = 10, and slow one, k = 1, respa, h = .3126",
        "energy grows at the rate 2 acosh(|trace|/2)/h", 2 * acosh(-trace(0.3126) / 2) / 0.3126,
        CLOSED, RESPA.format(0.3126, 300), "polyfit(t[500:], log(energy[500:]), 1)[0]",
        "--method respa4",
    ),
    shown(
        "G12", "x' = x (1 - x), euler, h = 3", "chaotic: |4 - 6 x| grows a step, in the mean, by "
        "log 2", log(2), CLOSED,
        "pkgen run logistic.lag --method euler --step 3 --until 30000 --every 3 --start x=0.3",
        "mean(log(abs(4 - 6*x)))", "--method rk4",
    ),
]  # fmt: skip
