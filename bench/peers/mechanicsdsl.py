"""mechanicsdsl-core: the C++ that it writes for each model from its own language.

Built as its compile_to_cpp() does it (g++ -O3), and by the flags of its CMakeLists.txt
(-march=native -O3 -ffast-math, its own choice): the faster takes part.
"""

from __future__ import annotations

import contextlib
import importlib.metadata
import io
import logging
from pathlib import Path

from ..builds import SOURCES, Build, Unavailable, compile_program, written
from ..contender import HALVINGS, Contender, Program, programs
from ..models import REFERENCES, Model

BUILDS = (
    Build("g++", ("-O3",)),
    Build("g++", ("-march=native", "-O3", "-ffast-math")),
)
ANGLE, LENGTH = "{Angle}{rad}", "{Position}{m}"
# (coordinates, L), with the names of REFERENCES as constants.
SOURCES_DSL = {
    "double_pendulum": (
        {"theta1": ANGLE, "theta2": ANGLE},
        r"\frac{1}{2} * (m1 + m2) * l1^2 * \dot{theta1}^2"
        r" + \frac{1}{2} * m2 * l2^2 * \dot{theta2}^2"
        r" + m2 * l1 * l2 * \dot{theta1} * \dot{theta2} * \cos{theta1 - theta2}"
        r" + (m1 + m2) * g * l1 * \cos{theta1} + m2 * g * l2 * \cos{theta2}",
    ),
    "coupled_oscillators": (
        {"q1": LENGTH, "q2": LENGTH, "q3": LENGTH},
        r"\frac{1}{2} * m * (\dot{q1}^2 + \dot{q2}^2 + \dot{q3}^2)"
        r" - \frac{1}{2} * k * q1^2 - \frac{1}{2} * k * q3^2"
        r" - \frac{1}{2} * kc * (q2 - q1)^2 - \frac{1}{2} * kc * (q3 - q2)^2",
    ),
    "bead_on_hoop": (
        {"theta": ANGLE},
        r"\frac{1}{2} * m * R^2 * (\dot{theta}^2 + Omega^2 * \sin{theta}^2)"
        r" + m * g * R * \cos{theta}",
    ),
    "elastic_pendulum": (
        {"s": LENGTH, "theta": ANGLE},
        r"\frac{1}{2} * m * (\dot{s}^2 + (l0 + s)^2 * \dot{theta}^2)"
        r" + m * g * (l0 + s) * \cos{theta} - \frac{1}{2} * k * s^2",
    ),
    "heavy_top": (
        {"phi": ANGLE, "theta": ANGLE, "psi": ANGLE},
        r"\frac{1}{2} * I1 * (\dot{theta}^2 + \dot{phi}^2 * \sin{theta}^2)"
        r" + \frac{1}{2} * I3 * (\dot{psi} + \dot{phi} * \cos{theta})^2"
        r" - M * g * l * \cos{theta}",
    ),
}


def source(model: Model) -> str:
    """The model in the language of mechanicsdsl."""
    coordinates, lagrangian = SOURCES_DSL[model.name]
    lines = [rf"\system{{{model.name}}}"]
    lines += [rf"\defvar{{{name}}}{kind}" for name, kind in coordinates.items()]
    for name, value in REFERENCES[model.name]["params"].items():
        lines.append(rf"\parameter{{{name}}}{{{value}}}{{1}}")
    lines.append(rf"\lagrangian{{{lagrangian}}}")
    given = [f"{c}={x}" for c, x in zip(coordinates, model.start, strict=False)]
    given += [f"{c}_dot={x}" for c, x in zip(coordinates, model.start[model.n :], strict=True)]
    lines.append(rf"\initial{{{', '.join(given)}}}")
    return "\n".join(lines) + "\n"


def _open(model: Model, _: tuple[Build, ...]) -> list[Program]:
    try:
        from mechanics_dsl import PhysicsCompiler
    except ImportError:
        raise Unavailable("mechanicsdsl-core is not installed") from None
    logging.getLogger("MechanicsDSL").setLevel(logging.CRITICAL)
    compiler = PhysicsCompiler()
    path = written(f"mechanicsdsl/{model.name}.cpp", "")
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        result = compiler.compile_dsl(source(model))
        made = result.get("success") and compiler.compile_to_cpp(str(path), compile_binary=False)
    if not made:
        raise Unavailable(f"mechanicsdsl-core refused the model: {result.get('error', '')}")
    version = importlib.metadata.version("mechanicsdsl-core")
    defines = {"BENCH_EQUATIONS": f'"{path}"'}

    def make(build: Build) -> Path:
        # The C part is an object of its own: g++ would read harness.c as C++.
        c = Build("gcc", build.flags)
        harness = compile_program(c, [SOURCES / "harness.c"], {}, ("-std=c11", "-c"))
        return compile_program(
            build, [SOURCES / "mechanicsdsl_rk4.cpp"], defines, ("-std=c++17", str(harness))
        )

    return programs(BUILDS, make, note=f"; mechanicsdsl-core {version}")


def contenders() -> list[Contender]:
    return [Contender("mechanicsdsl-core RK4", "C", True, _open, ladder=HALVINGS[:11])]
