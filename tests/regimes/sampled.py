"""Controllers that sample too rarely, or act too late: limits by the z-transform.

A mass under u = -kp x - kd x', held for T, has z^2 - (2 - kp T^2/2 - kd T) z + 1 + kp T^2/2 - kd T;
by Jury's criterion it is stable for T < 2 kd/kp and T < 2/kd. x' = -x read k samples ago has
z^(k+1) - z^k + T, stable for T < 2 cos(k pi/(2 k + 1)) (S. A. Kuruklis, J. Math. Anal. Appl. 188
(1994) 719).
"""

from math import cos, pi

from .prediction import BOUNDARY
from .shown import around, shown

HELD = "for T in {}; do pkgen run sampled_pd.lag{} --set T=$T --method gauss2 --step $T"
HELD += " --until 20000*$T --every 20000*$T; done"
LATE = "for T in {}; do pkgen run sampled_late.lag{} --set T=$T --method rk4 --step $T"
LATE += " --until 20000*$T --every 20000*$T; done"
NO_METHOD = "the limit is the controller's, and the same for every method: another gain"
GROWS = "edge of T: not abs({}[-1]) < 0.01"


def late(k: int) -> float:
    return 2 * cos(k * pi / (2 * k + 1))


PREDICTIONS = [
    shown(
        "SC1", "mass, PD controller of period T, kp = 4, kd = 1", "spirals out from T = 2 kd/kp",
        0.5, BOUNDARY, HELD.format(around(0.5), ""), GROWS.format("x"), "--set kd=0.9",
        no_method=NO_METHOD,
    ),
    shown(
        "SC2", "mass, PD controller of period T, kp = 1, kd = 3", "jumps to and fro from T = 2/kd",
        2 / 3, BOUNDARY, HELD.format(around(2 / 3), " --set kp=1 --set kd=3"), GROWS.format("x"),
        "--set kd=3.3", no_method=NO_METHOD,
    ),
    *(
        shown(
            f"SC{2 + k}", f"x' = u, u = -x of period T, {k} samples late",
            f"unstable from T = 2 cos({k} pi/{2 * k + 1})", late(k), BOUNDARY,
            LATE.format(around(late(k)), "" if k == 1 else f" --size k={k}"), GROWS.format("v"),
            f"--size k={k + 1}", no_method="a limit of the controller's delay: a longer delay",
        )
        for k in (1, 2)
    ),
]  # fmt: skip
