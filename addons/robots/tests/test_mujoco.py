"""Models in MJCF from the wheels of mujoco, dm_control and gymnasium move as MuJoCo moves them."""

from __future__ import annotations

import random
import re
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from random_states import state_of
from test_mjcf import ROBOT

from pkgen.front.check.check import check_text
from pkgen.graph.evaluate import evaluate
from pkgen.middle.derive.derive import derive
from pkgen.source import ModelError, Source
from pkgen_robots.read import imported

mujoco = pytest.importorskip("mujoco", reason="pip install mujoco dm_control gymnasium")
WHEELS = ("mujoco", "dm_control", "gymnasium")
LEAST = 1e-3  # accelerations are compared beside this if they are smaller: the rest is rounding


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch):
    """MuJoCo writes its warnings to a file in the working folder."""
    monkeypatch.chdir(tmp_path)


def models() -> list[str]:
    """The files of the wheels that are here, by their paths in the folder of packages."""
    found = []
    for wheel in WHEELS:
        spec = find_spec(wheel)
        for folder in spec.submodule_search_locations if spec else ():
            paths = sorted(Path(folder).rglob("*.xml"))
            found += [str(path.relative_to(Path(folder).parent)) for path in paths]
    return [path for path in found if "schema" not in path]


@cache
def loaded(path: str):
    """MuJoCo's model; None if MuJoCo refuses it or nothing in it moves."""
    wheel, _, inside = path.partition("/")
    file = next(Path(folder) / inside for folder in find_spec(wheel).submodule_search_locations)
    try:
        model = mujoco.MjModel.from_xml_path(str(file))
    except ValueError:
        return file, None
    return file, model if model.nv else None


def difference(own, text: str, robot, seed: int) -> float:
    """The largest difference of accelerations, beside the largest of them."""
    model = check_text(Source("robot.lag", text))[0]
    e = derive(model)
    symbols, values, rates = state_of(model, random.Random(seed))
    off = mujoco.mjtDisableBit
    own.opt.disableflags |= off.mjDSBL_CONSTRAINT | off.mjDSBL_ACTUATION
    data, order = mujoco.MjData(own), []
    turns = {r.name: r.turns for r in model.rotations}
    names = re.findall(r"^joint (\w+):", text, re.M)
    moving = [n for n, j in zip(names, robot.joints, strict=True) if j.kind != "fixed"]
    for j, name in zip(range(own.njnt), moving, strict=True):
        q, v, kind = own.jnt_qposadr[j], own.jnt_dofadr[j], own.jnt_type[j]
        free = kind == mujoco.mjtJoint.mjJNT_FREE
        numbers = [f"{name}_{x}" for x in "xyz"] * free or [name] * (name not in turns)
        data.qpos[q : q + len(numbers)] = [values[x] for x in numbers]
        data.qvel[v : v + len(numbers)] = [rates[x] for x in numbers]
        if name in turns:
            q, v = q + len(numbers), v + len(numbers)
            data.qpos[q : q + 4], data.qvel[v : v + 3] = values[name], rates[name]
        order += [*numbers, *turns.get(name, ())]
    mujoco.mj_forward(own, data)
    coordinates = [c.name for c in model.coordinates]
    found = np.array(evaluate(e.graph, e.acceleration[: len(coordinates)], symbols))
    found = found[[coordinates.index(name) for name in order]]
    wanted = data.qacc_smooth
    return abs(found - wanted).max() / max(abs(wanted).max(), LEAST)


@pytest.mark.parametrize("seed", range(3))
def test_the_robot_by_hand_too(tmp_path, seed):
    (tmp_path / "robot.xml").write_text(ROBOT)
    text, robot = imported(tmp_path / "robot.xml")
    assert difference(mujoco.MjModel.from_xml_string(ROBOT), text, robot, seed) < 1e-12


@pytest.mark.long
@pytest.mark.parametrize("path", models())
def test_accelerations_are_those_of_mujoco(path):
    file, own = loaded(path)
    try:
        text, robot = imported(file)
    except ModelError as error:
        pytest.skip(f"not read: {'; '.join(d.message for d in error.diagnostics)}")
    if own is None:
        pytest.skip("MuJoCo refuses it")
    assert difference(own, text, robot, 1) < 1e-10


@pytest.mark.long
def test_how_many_are_read():
    """Of those in which something moves. What is not read is said by the test above."""
    if not all(find_spec(wheel) for wheel in WHEELS):
        pytest.skip("pip install mujoco dm_control gymnasium")
    read = 0
    for path in models():
        file, own = loaded(path)
        if own is not None:
            try:
                read += bool(imported(file))
            except ModelError as error:
                assert error.diagnostics
    assert read >= 35
