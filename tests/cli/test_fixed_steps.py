"""Fixed steps that nobody looks at are made many at a time: the same bits as one by one."""

from __future__ import annotations

import pytest

from conftest import ROOT, rows, written

DRIVEN = "model driven\ncoord x\nkinetic x'^2/2\npotential x^4/4\nforce x = sin(3*t)\nstart x = 1\n"
CASES = [
    ("driven", ["verlet", "rk4", "gauss4"]),
    ("coupled_oscillators", ["verlet", "rk4", "blanes_moan4", "gauss4"]),
    ("double_pendulum", ["rk4", "gauss4", "lie_midpoint"]),
]


@pytest.mark.parametrize("model, method", [(m, x) for m, of in CASES for x in of])
def test_many_steps_have_the_bits_of_single_ones(pkgen, tmp_path, model, method) -> None:
    """A row at every step has each made by itself; 1.024 s are 1,024 steps, the first looked at."""
    options = ["--method", method, "--step", "0.001", "--until", "3.0005"]
    path = ROOT / f"models/{model}.lag"
    if model == "driven":
        path = written(tmp_path, DRIVEN)
    single = rows(pkgen, path, *options, "--every", "0.001")[-1]
    for more in ([], ["--watch", "none"]):
        assert rows(pkgen, path, *options, "--every", "3.0005", *more)[-1] == single
