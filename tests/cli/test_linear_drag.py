"""Splitting where forces have C v is symplectic where C turns."""

from __future__ import annotations

from pathlib import Path

import pytest

from conftest import diagnosed

HEAD = "model m\nparam w = 0.8\ncoord x, y\nstart x = 1, y = 0.2, y' = 0.5\n"
FREE = "kinetic x'^2/2 + y'^2 + x'*y'/3\npotential x^2 + x^4/4 + cos(x - y)\n"
MODELS = {
    "drag": FREE + "dissipation w*(x' - 2*y')^2/4\n",
    "field": FREE + "lagrangian w*x*y'\n",
    "frame": FREE.replace("x'", "(x' - w*y)").replace("y'", "(y' + w*x)"),
}


@pytest.mark.parametrize(("name", "keeps"), [("field", True), ("frame", True), ("drag", False)])
def test_the_form(tmp_path: Path, name: str, keeps: bool) -> None:
    def defect(method: str) -> float:
        how = ("--until", 2, "--method", method, "--step", 0.2)
        found, *_ = diagnosed(tmp_path, HEAD + MODELS[name], "symplectic", *how)
        return found["symplectic"]["defect"]

    for method in ("verlet", "blanes_moan4"):
        assert (defect(method) < 1e-13) is keeps
    assert defect("rk4") > 1e-6 and (not keeps or defect("boris") > 1e-6)
