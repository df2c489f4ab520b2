"""Pinocchio and MuJoCo, of which an arm's dynamics are asked: from C++ and C, and from Python.

Pinocchio's templates are compiled here, from the headers of its wheel and of Eigen's, so that it
has the compilers and flags of all others; the wheel's own build, which Python calls, is measured
too.
"""

from __future__ import annotations

import importlib.util
import time
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path

from ..arm_models import GRAVITY, Link
from ..builds import COMPILERS, FUSED, Build, Unavailable

# What Pinocchio's CMake files say.
LIMITS = {
    "BOOST_MPL_LIMIT_LIST_SIZE": "30",
    "BOOST_MPL_LIMIT_VECTOR_SIZE": "30",
    "BOOST_MPL_CFG_NO_PREPROCESSED_HEADERS": "",
    "BOOST_FUSION_INVOKE_MAX_ARITY": "12",
    "NDEBUG": "",
}
IN_CXX = {"gcc": "g++", "clang": "clang++"}
# Each takes minutes to compile, once.
PINOCCHIO_BUILDS = (
    *(Build(IN_CXX[cc], FUSED) for cc in COMPILERS),
    *(Build(IN_CXX[cc], ("-O3",)) for cc in COMPILERS[:1]),
)


@cache
def pinocchio_headers() -> tuple[str, ...]:
    """Flags."""
    folder = folder_of("pinocchio", "pin").parents[3] / "include"
    if not (folder / "pinocchio" / "algorithm" / "aba.hpp").exists():
        raise Unavailable("the wheel of pin has no headers")
    if not (folder / "eigen3").exists():
        raise Unavailable("cmeel-eigen is not installed")
    return ("-std=c++17", "-w", "-isystem", str(folder), "-isystem", str(folder / "eigen3"))


@cache
def mujoco_library() -> tuple[Path, Path]:
    """The folder of its headers, and the library."""
    folder = folder_of("mujoco", "mujoco")
    libraries = sorted(folder.glob("libmujoco.so*"))
    if not libraries:
        raise Unavailable("the wheel of mujoco has no library for C")
    return folder / "include", libraries[0]


def folder_of(module: str, package: str) -> Path:
    found = importlib.util.find_spec(module)
    if not found or not found.origin:
        raise Unavailable(f"{package} is not installed")
    return Path(found.origin).resolve().parent


def pinocchio_in_python(arm: Sequence[Link]) -> Callable[[], object]:
    """One call of aba() by the wheel."""
    folder_of("pinocchio", "pin")
    import numpy as np
    import pinocchio as pin

    model = pin.Model()
    model.gravity.linear = np.array([0, 0, -GRAVITY])
    kinds = {
        "revolute": pin.JointModelRevoluteUnaligned,
        "prismatic": pin.JointModelPrismaticUnaligned,
    }
    about = (pin.JointModelRX, pin.JointModelRY, pin.JointModelRZ)
    for k, link in enumerate(arm):
        place = pin.SE3(np.array(link.turn), np.array(link.at))
        aligned = link.kind == "revolute" and 1 in link.axis
        joint = about[link.axis.index(1)]() if aligned else kinds[link.kind](*link.axis)
        model.addJoint(link.parent + 1, joint, place, f"q{k + 1}")
        body = pin.Inertia(link.mass, np.array(link.centre), np.array(link.inertia))
        model.appendBodyToJoint(k + 1, body, pin.SE3.Identity())
    data, q, v, zero = model.createData(), *(np.full(len(arm), x) for x in (0.3, 0.2, 0.0))
    return lambda: pin.aba(model, data, q, v, zero)


def mujoco_in_python(text: str) -> Callable[[], object]:
    """One call of mj_forward()."""
    folder_of("mujoco", "mujoco")
    import mujoco

    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = 0.3, 0.2
    return lambda: mujoco.mj_forward(model, data)


def nanoseconds(call: Callable[[], object], seconds: float) -> float:
    """Of a call from Python, with what Python spends on it."""
    done, begin = 0, time.perf_counter()
    while True:
        for _ in range(100):
            call()
        done += 100
        elapsed = time.perf_counter() - begin
        if elapsed > seconds:
            return 1e9 * elapsed / done
