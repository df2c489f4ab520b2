"""Implicit steps of a motion that comes to rest where large forces cancel: Newton's corrections end
in the round-off of those forces, far above that of the motion."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from conftest import case, ran, written

DISPLACED = case("displaced")


@pytest.mark.parametrize("method", ["gauss1", "gauss2", "gauss4", "lobatto3", "radau5", "radau9"])
def test_motion_to_rest_goes_on(tmp_path: Path, method: str) -> None:
    model = written(tmp_path, DISPLACED)
    run = ["run", model, "--method", method, "--step", "0.2", "--every", "2"]
    done = ran(*run, "--until", "200", "--json")
    rows = json.loads(done.stdout)["rows"]
    assert 0 < abs(rows[1][2]) < 0.1  # y at 2 s, on its way
    assert max(map(abs, rows[-1][1:5])) < 1e-15  # and at rest
