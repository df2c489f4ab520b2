"""Models in MJCF of pip's mujoco, dm_control and gymnasium: their accelerations are MuJoCo's."""

from __future__ import annotations

import random
import re
import sys
from pathlib import Path

import numpy as np
import pytest
from random_states import state_of

from pkgen.front.check.check import check_text
from pkgen.graph.evaluate import evaluate
from pkgen.middle.derive.derive import derive
from pkgen.source import Source
from pkgen_robots.read import imported

mujoco = pytest.importorskip("mujoco", reason="pip install mujoco dm_control gymnasium")


def difference(file: Path, seed: int = 1) -> float:
    text, robot = imported(file)
    model = check_text(Source("robot.lag", text))[0]
    e = derive(model)
    symbols, values, rates = state_of(model, random.Random(seed))
    own = mujoco.MjModel.from_xml_path(str(file))
    own.opt.disableflags |= (
        mujoco.mjtDisableBit.mjDSBL_CONSTRAINT | mujoco.mjtDisableBit.mjDSBL_ACTUATION
    )
    data = mujoco.MjData(own)
    names = re.findall(r"^joint (\w+):", text, re.M)
    moving = [n for n, j in zip(names, robot.joints) if j.kind != "fixed"]
    assert len(moving) == own.njnt, (len(moving), own.njnt)
    turns = {r.name: r.turns for r in model.rotations}
    order = []
    for j, name in enumerate(moving):
        q, v = own.jnt_qposadr[j], own.jnt_dofadr[j]
        kind = own.jnt_type[j]
        if kind == 0:
            for x in "xyz":
                data.qpos[q], data.qvel[v] = values[f"{name}_{x}"], rates[f"{name}_{x}"]
                order.append(f"{name}_{x}")
                q, v = q + 1, v + 1
        if kind <= 1:
            data.qpos[q : q + 4] = values[name]
            data.qvel[v : v + 3] = rates[name]
            order += turns[name]
        else:
            data.qpos[q], data.qvel[v] = values[name], rates[name]
            order.append(name)
    mujoco.mj_forward(own, data)
    coordinates = [c.name for c in model.coordinates]
    found = np.array(evaluate(e.graph, e.acceleration[: len(coordinates)], symbols))
    found = found[[coordinates.index(name) for name in order]]
    wanted = data.qacc_smooth
    return abs(found - wanted).max() / abs(wanted).max(), own.nv, abs(wanted).max()
