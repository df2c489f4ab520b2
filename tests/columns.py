"""Columns of a run by their names."""

from pathlib import Path

import numpy as np

from conftest import HOSTED, case, run_pkgen

MODELS = HOSTED


# A parameter and a start that follow others, an input, a state.
RIG = case("rig")


def ran(model: Path, *words: object) -> dict[str, np.ndarray]:
    done = run_pkgen("run", model, *map(str, words))
    assert done.returncode == 0, done.stderr
    names, *rows = done.stdout.splitlines()
    values = np.array([[float(x) for x in row.split(",")] for row in rows])
    return dict(zip(names.split(","), values.T, strict=True))
