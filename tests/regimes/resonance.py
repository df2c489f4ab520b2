"""Nonlinear resonance of the step with the motion (N2 to N8), and misuse of a step."""

from math import pi, sqrt

import numpy as np

from .prediction import BOUNDARY, MEASURED, Prediction, boundary
from .probe import Probe
from .shown import listed

# --- N2: the pendulum under Verlet is the standard map with K = (h omega)^2 -----------------


def residue(method: str, h: float, turns: int, steps: int, origin: float) -> float:
    """Greene's residue (2 - trace)/4 of the orbit that turns `turns` times in `steps` steps, and
    starts on the line theta = origin, to which the map is symmetric (J. Greene, J. Math. Phys. 20
    (1979) 1183). The orbit is followed from a small step, where it turns at a constant rate."""

    def after(theta: float, v: float, h: float) -> np.ndarray:
        probe = Probe("pendulum", method, h, start={"theta": theta, "theta'": v})
        return probe.steps(steps, steps)[-1, 1:3]

    whole = 2 * pi * turns
    advance = whole / steps  # h v at the start, which hardly changes with h
    for part in np.linspace(0.05, 1, 40) * h:
        x0, x1 = advance, advance * (1 + 1e-7)
        f0, f1 = (after(origin, x / part, part)[0] - origin - whole for x in (x0, x1))
        for _ in range(30):
            if f1 == f0 or abs(f1) < 1e-11:
                break
            x0, x1, f0 = x1, x1 - f1 * (x1 - x0) / (f1 - f0), f1
            f1 = after(origin, x1 / part, part)[0] - origin - whole
        advance = x1
    assert abs(f1) < 1e-9
    v, d = advance / h, 1e-6
    d_theta = (after(origin + d, v, h) - after(origin - d, v, h))[0] / (2 * d)
    d_v = (after(origin, v + d, h) - after(origin, v - d, h))[1] / (2 * d)
    return (2 - d_theta - d_v) / 4


def last_golden_curve(turns: int, steps: int, predicted: float) -> float:
    """The curve of golden winding is there as long as the residues of its convergents stay below
    1/4; one convergent stands for the limit."""
    return boundary(predicted, lambda h: residue("verlet", h, turns, steps, 0.0) > 0.25, bits=11)


# --- N3, N5: swing and stretch of the elastic pendulum as Verlet sees them ------------------


def resonant_step(method: str, predicted: float) -> float:
    """The middle of the band of steps where a stretch of 5e-4 passes half of what it can over
    to the swing; the band's width shrinks with the stretch."""
    rate = 1e-5

    def resonant(h: float) -> bool:
        start = {"x": 0.0, "x'": rate, "y": -1.0005}
        probe = Probe("spring_plane", method, h, set={"k": 3.61}, start=start)
        swing = probe.steps(int(20_000 / h), 5)[:, 1]
        return np.abs(swing).max() > 40 * rate

    steps = predicted * (1 + np.linspace(-0.02, 0.02, 101))
    inside = [h for h in steps if resonant(h)]
    within = inside and steps[0] < inside[0] and inside[-1] < steps[-1]
    return (inside[0] + inside[-1]) / 2 if within else 0.0


# --- N8: a step misused ------------------------------------------------------------------

REST = {"theta1": 0.5, "theta2": 0.5, "theta1'": 0.0, "theta2'": 0.0}


def misused(until: float) -> float:
    probe = Probe("double_pendulum", "gauss1", 0.02, start=REST)
    q, v = probe.q.copy(), probe.v.copy()
    return abs(probe.lib.misused_verlet(probe.p, 0.02, round(until / 0.02), q, v))


def energy_error(method: str, h: float, until: float) -> float:
    probe = Probe("double_pendulum", method, h, start=REST)
    first = probe.energy(probe.q, probe.v)
    return np.abs(probe.steps(round(until / h))[:, -1] - first).max()


SPRING = (
    'pkgen run spring_plane.lag --set k={} --start x=0 --start y=-1.05 --start "x\'=0.001" '
    "--method verlet --step {1} --until {2} --every {1}"
).replace("{}", "{0}")
SWINGS = (
    "pkgen run ../../../models/double_pendulum.lag --start theta1=0.5 --start theta2=0.5 "
    '--start "theta1\'=0" --start "theta2\'=0" --method {0} --step 0.02 --until {1} '
    "--every 0.02 --record energy"
)
K_CRITICAL = 0.971635406  # R. MacKay, Physica D 7 (1983) 283
RESONANT = 2 * sqrt(1 - (1.9 / 2) ** 2)  # where omega_s = 1.9 and 2 sqrt(1 - h^2/4) agree

PREDICTIONS = [
    Prediction(
        "N2", "pendulum, verlet", "the last rotational curve breaks where (h omega)^2 = .971635406",
        sqrt(K_CRITICAL), BOUNDARY, lambda: last_golden_curve(89, 144, sqrt(K_CRITICAL)),
        "convergent 3/5 alone", lambda: last_golden_curve(3, 5, sqrt(K_CRITICAL)),
        no_method="the map is the prediction: symplectic_euler is the same map in other variables, "
        "and where a curve of another method breaks is not known",
    ),
    Prediction(
        "N3a", "elastic pendulum 1 : 1.9, verlet",
        "spurious 1:2 where omega_s = 2 omega_p sqrt(1 - (h omega_p/2)^2): at h",
        RESONANT, BOUNDARY, lambda: resonant_step("verlet", RESONANT),
        "yoshida4: no such band", lambda: resonant_step("yoshida4", RESONANT),
    ),
    *(
        listed(
            id, f"elastic pendulum 1 : {ratio}, verlet, h = {h:.7g}, stretch .05, swing .001", says,
            predicted, MEASURED, SPRING.format(k, f"{h:.12g}", until), "max(abs(x))/0.001",
            f"--method {worse}",
        )
        for id, ratio, k, h, until, says, predicted, worse in (
            ("N3b", 1.9, 3.61, RESONANT, 4000, "stretch turns into swing, which gains", 87.0,
             "yoshida4"),
            ("N5a", 2, 4, 0.01, 400, "the true 1:2 resonance: the swing gains", 100.0,
             "symplectic_euler --step 0.6"),
            ("N5b", 2, 4, 0.6, 2000, "detuned by the step: the swing gains", 2.2, "yoshida4"),
        )
    ),
    *(
        listed(
            id, f"free flight past the pole of a polar chart, verlet, hv/b = {h}",
            "max |dE/E|", predicted, MEASURED,
            f"pkgen run radial.lag --scene past --set h={h} --method verlet",
            "max(abs(energy/0.5 - 1))", "--method symplectic_euler",
        )
        for id, h, predicted in (
            ("N7a", 0.1, 8.3796e-4), ("N7b", 0.5, 0.02493), ("N7c", 1.0, 0.2395),
        )
    ),
    *(
        Prediction(
            id, "double pendulum, .5/.5, velocity Verlet misused, h = .02",
            f"|dE| at t = {until:g}", predicted, MEASURED, lambda t=until: misused(t),
            "gauss1", lambda t=until: energy_error("gauss1", 0.02, min(t, 1000)),
        )
        for id, until, predicted in (
            ("N8a", 1e2, 0.00195), ("N8b", 1e3, 0.0234), ("N8c", 1e4, 0.247),
        )
    ),
    listed(
        "N8e", "double pendulum, verlet", "the runtime refuses the misuse: exit code", 4, 0,
        SWINGS.format("verlet", 1), "exit_code", "--method gauss1",
    ),
    listed(
        "N8d", "double pendulum, .5/.5, gauss1, h = .02, to t = 1000",
        "max |dE|", 1.09e-4, MEASURED, SWINGS.format("gauss1", 1000),
        "max(abs(energy - energy[0]))", "--method rk2",
    ),
]  # fmt: skip
