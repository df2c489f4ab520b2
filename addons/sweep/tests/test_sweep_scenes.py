"""Sweeps of scenes: a promise of accuracy, what is expected of a whole run."""

from __future__ import annotations

import json
import random
from pathlib import Path

import pytest

pq = pytest.importorskip("pyarrow.parquet")
MODEL = """model spring
param k = 1 in (0, inf)
coord x
kinetic x'^2/2
potential k*x^2/2
start x = 1
event low: x falling
scene s
  until 5
  record x every 1
  ACCURACY
  expect x < 2
  expect drift(energy) < 1e-3
  expect time(low) > 1
end
"""
PLAN = 'scene = "s"\nseed = SEED\nmembers = 30\nkeep = KEEP\n[random]\nk = "LOW .. 2"\n'


@pytest.fixture
def swept(pkgen, tmp_path: Path):
    def sweep(seed: int, keep: list[str], low: float, high: float = 2, accuracy: bool = True):
        text = MODEL.replace("ACCURACY", "accuracy 1e-6" if accuracy else "")
        (tmp_path / "m.lag").write_text(text)
        plan = PLAN.replace("SEED", str(seed)).replace("KEEP", json.dumps(keep))
        (tmp_path / "p.toml").write_text(plan.replace("LOW .. 2", f"{low} .. {high}"))
        return pkgen("sweep", "m.lag", "--plan", "p.toml", "-o", "s", cwd=tmp_path)

    return sweep


@pytest.mark.parametrize("low", [-0.3, -5])
def test_a_member_out_of_bounds_costs_itself_where_a_method_is_chosen(
    swept, pkgen, tmp_path: Path, low: float
) -> None:
    done = swept(random.randrange(100), ["final"], low)
    assert done.returncode == 0, done.stderr
    found = pq.read_table(tmp_path / "s/data").to_pylist()
    out = [one["k"] <= 0 for one in found]
    assert [one["status"] == "PK_OUT_OF_BOUNDS" for one in found] == out
    assert all((one["x"] is None) == bad for one, bad in zip(found, out, strict=True))
    assert not all(out) and (any(out) or low > -1)
    before = (tmp_path / "s/data/part-000000.parquet").read_bytes()
    (tmp_path / "s/data/part-000000.parquet").unlink()
    done = pkgen("sweep", "--resume", "s", cwd=tmp_path)
    assert done.returncode == 0 and "trials" not in done.stderr, done.stderr
    assert (tmp_path / "s/data/part-000000.parquet").read_bytes() == before


def test_where_no_member_is_within_bounds_that_is_said(swept) -> None:
    done = swept(1, ["final"], -2, high=-1)
    assert done.returncode == 2 and "parameter k is outside its bounds" in done.stderr


def test_what_is_expected_of_a_whole_run_is_named(swept) -> None:
    done = swept(1, ["expects"], 0.1, accuracy=False)
    assert done.returncode == 2
    assert "expect 2, 'expect drift(energy) < 1e-3', is of a whole run" in done.stderr
    assert 'keep = ["drift(energy)"]' in done.stderr
    done = swept(1, ["drift(energy)", "time(low)"], 0.1, accuracy=False)
    assert done.returncode == 0, done.stderr
