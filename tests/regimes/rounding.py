"""Sums of many steps, and drifts that only many steps show."""

import subprocess
import tempfile
from functools import cache
from math import cos, log, sin
from pathlib import Path

import numpy as np

from conftest import run_pkgen
from pkgen.system import toolchain

from .prediction import MEASURED, ORDER, Prediction
from .shown import HERE, MODELS, shown

ORBITS = (
    "for n in 10 20 40 80; do pkgen run kepler.lag --method {} --until 2*pi*$n --every 0.1; done"
)
CLOSING = (
    "for n in 10 20 40 80; do pkgen run kepler.lag --method {} --until 2*pi*$n --every 2*pi; done"
)
ROD = (
    "for n in 20 80; do pkgen run ../../../models/constrained/pendulum_rod.lag "
    "--method {} --step 0.02 --until $n --every 0.5 --record energy; done"
)
DRIFT = "power of n: max(abs(energy - energy[0]))"

TOLERANCES = (
    "for e in 1e-7 1e-8 1e-9 1e-10 1e-11 1e-12; do pkgen run kepler.lag --set e=0.3 --method {} "
    "--rtol $e --until 20*pi --every 20*pi; done"
)
TOLERANCE = "power of e: hypot(x[-1] - 0.7, y[-1])"
WAVES = (
    "for n in 20 40 80 160; do pkgen run oscillator.lag --method {} --until 2*pi*$n "
    "--every 2*pi; done"
)
NEIGHBOURS = (
    "pkgen run ../../../models/double_pendulum.lag --ensemble neighbours.csv --method rk4 "
    "--step 0.01 --until 20 --every 1"
)
DENSE = "pkgen run oscillator.lag --method {} --step 1 --until 20 --every 0.5"


@cache
def clocks() -> tuple[float, float]:
    """Of clock.c, with far.lag's C and the runtime compiled for float."""
    tools = toolchain.find_toolchain()
    include, sources = toolchain.RUNTIME / "include", (toolchain.RUNTIME / "src").rglob("*.c")
    with tempfile.TemporaryDirectory() as folder:
        assert run_pkgen(MODELS / "far.lag", "--runtime", "-o", folder).returncode == 0
        command = [*tools.cc, "-std=c11", "-DPK_FLOAT", "-DPK_RUNTIME", f"-I{include}", "-I."]
        command += ["far.c", HERE / "clock.c", *sources, "-lm", "-o", "clock"]
        subprocess.run(command, cwd=folder, check=True)
        said = subprocess.run([Path(folder) / "clock"], capture_output=True, text=True, check=True)
    own, runtime = map(float, said.stdout.split())
    return own, runtime


PREDICTIONS = [
    shown(
        "R1", "x' = 1 from 1e16, verlet, h = .1", "steps below the last digit of x add up, to",
        1000.0, 0, "pkgen run far.lag --method verlet --step 0.1 --until 1000", "x[-1] - 1e16",
        "--method gsl_rkf45 --max-step 0.1",
    ),
    shown(
        "R2", "1 + 1e100 + 1 - 1e100, euler, h = 1", "W. Kahan's sum of it is 0, not Neumaier's 2",
        (0.0, 0.0), 0, "pkgen run terms.lag --method euler --step 1 --until 4", "s[-1]",
        "--method gsl_rkf45 --max-step 1",
    ),
    shown(
        "R3", "oscillator, exponential, one step of 1e6", "q is cos(1e6) but for rounding",
        cos(1e6), 1e-9, "pkgen run oscillator.lag --method exponential --until 1e6 --every 1e6",
        "q[-1]", "--method gauss",
    ),
    shown(
        "R4", "Kepler, e = .6, dopri5", "steps that follow the error do not reverse: energy drifts "
        "with the power of t", 1.0, ORDER, ORBITS.format("dopri5"), DRIFT,
        "--method adaptive_verlet --step 0.01",
    ),
    shown(
        "R5", "Kepler, e = .6, adaptive_verlet, first step .01", "reversible steps: energy drifts "
        "with the power of t", (-0.05, 0.05), 0, ORBITS.format("adaptive_verlet --step 0.01"),
        DRIFT, "--method dopri5",
    ),
    shown(
        "R6", "Kepler, e = .6, dopri5, 10 to 80 orbits", "the position error grows with the power "
        "of t", 2.0, ORDER, CLOSING.format("dopri5"), "power of n: hypot(x[-1] - 0.4, y[-1])",
        "--method adaptive_verlet --step 0.01",
    ),
    shown(
        "R7", "pendulum on a rod, rk4 and projection, h = .02", "on the constraint, and yet energy "
        "drifts with the power of t", 1.0, ORDER, ROD.format("rk4"), DRIFT, "--method rattle",
    ),
    shown(
        "R8", "pendulum on a rod, rattle, h = .02", "energy drifts with the power of t",
        (-0.01, 0.01), 0, ROD.format("rattle"), DRIFT, "--method rk4",
    ),
    shown(
        "R9", "Kepler, e = .3, gsl_rk8pd", "the error after ten orbits goes with the power of the "
        "tolerance", 1.0, ORDER, TOLERANCES.format("gsl_rk8pd"), TOLERANCE, "--method gsl_msbdf",
    ),
    shown(
        "R10", "Kepler, e = .3, radau", "its step is that for tolerance^(2/3), by an estimate of "
        "order 3: the error goes with its power", 5 / 6, ORDER, TOLERANCES.format("radau"),
        TOLERANCE, "--method gsl_rk8pd",
    ),
    shown(
        "R11", "oscillator, gsl_msbdf", "tolerance kept in each step, and yet energy grows "
        "with the power of t", 1.0, ORDER, WAVES.format("gsl_msbdf"),
        "power of n: abs(energy[-1]/energy[0] - 1)", "--method gauss4 --step 0.5",
    ),
    shown(
        "R12", "eight double pendulums side by side, rk4, two alike", "a lane does not know its "
        "neighbours: they differ by", (0.0, 0.0), 0, NEIGHBOURS,
        "max(abs(theta1[member == 1] - theta1[member == 8]))", "--ensemble strangers.csv",
        no_method="members are compared, by whatever method",
    ),
    shown(
        "R13", "logistic maps 1e-12 apart, euler, h = 3", "part by log 2 a step",
        log(2), MEASURED,
        "pkgen run logistic.lag --ensemble twins.csv --method euler --step 3 --until 105 --every 3",
        "mean(diff(log(abs(x[36:] - x[:36]) + 1e-300)))", "--method rk4 --step 2",
    ),
    shown(
        "R14", "oscillator, gauss8, h = 1, a cubic through the ends of steps",
        "half-way it is wrong by 1 - cos(h/2) - (h/4) sin(h/2), whatever the method's order",
        1 - cos(0.5) - sin(0.5) / 4, 1e-9, DENSE.format("gauss8"),
        "1 - mean(((q[:-2:2] + q[2::2])/2 + (q'[:-2:2] - q'[2::2])/8)/q[1::2])", "--method verlet",
    ),
    shown(
        "R15", "oscillator, gauss8, h = 1, rows between steps", "wrong by no more than its steps",
        (1e-17, 1e-14), 0, DENSE.format("gauss8"), "max(abs(q - cos(t)))", "--method kahan_li8",
    ),
    shown(
        "R18", "Kepler, e = .3, gsl_msbdf", "orders to 5: the error goes with the power 5/6 of the "
        "tolerance", 5 / 6, ORDER, TOLERANCES.format("gsl_msbdf"), TOLERANCE, "--method dopri5",
        missed="GSL's BDF has an error that falls as if it were of order 2. CVODE's has the power "
        "(R19).",
    ),
    shown(
        "R19", "Kepler, e = .1, CVODE's BDF", "orders to 5: the error goes with the power 5/6 of "
        "the tolerance", 5 / 6, ORDER,
        "pkgen chart kepler.lag --set e=0.1 --until 20*pi --seconds 20 --methods dop853 "
        "--against cvode --json",
        'slope(*errors(report, 1e-13, 1e-7, "cvode_BDF", "scipy_DOP853"))', "--against scipy",
        long=True, needs="sksundae", no_method="a method of another package",
    ),
    Prediction(
        "R16", "time in float, 200,000 times .001, a loop of one's own", "t += h comes to",
        200.4506, 1e-6, lambda: clocks()[0], "verlet", lambda: clocks()[1], own=True, long=True,
    ),
    Prediction(
        "R17", "time in float, verlet, 200,000 steps of .001", "the runtime's clock is right to "
        "the last bit but one", 200000 * float(np.float32(0.001)), 1e-7, lambda: clocks()[1],
        "without compensated sums", lambda: clocks()[0], own=True, long=True,
    ),
]  # fmt: skip
