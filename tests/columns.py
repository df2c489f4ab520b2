"""Columns of a run by their names."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from conftest import ROOT, run_pkgen

MODELS = sorted((ROOT / "models").rglob("*.lag"))


# A parameter and a start that follow others, an input, a state.
RIG = """model rig
param m = 2 [kg] in (0, 10]
param k = 4*m*(1 [1/s^2]) in [0, inf)
input F [N]
coord x [m]
state s
kinetic m/2*x'^2
potential k/2*x^2
force x = F
rate s = x/(1 [m*s])
start x = m*(0.5 [m/kg])
"""


def ran(model: Path, *words: object) -> dict[str, np.ndarray]:
    done = run_pkgen("run", model, *map(str, words))
    assert done.returncode == 0, done.stderr
    names, *rows = done.stdout.splitlines()
    values = np.array([[float(x) for x in row.split(",")] for row in rows])
    return dict(zip(names.split(","), values.T, strict=True))
