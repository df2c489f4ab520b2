"""What is kept of members, against all of their rows."""

from __future__ import annotations

import random
from itertools import pairwise
from pathlib import Path

import pytest

pq = pytest.importorskip("pyarrow.parquet")
MODEL = """model wells
param c = 0.3
coord x, y
kinetic (x'^2 + y'^2)/2
potential x^4/4 - x^2/2 + y^2/2 + c*x*y
observe twist = x*y' - y*x'
observe root = sqrt(x)
"""
EVENT = "event left: x falling\n"  # with one, members run by themselves, not side by side
KEEP = ["max(x)", "min(x)", "mean(y')", "final(y)", "max(root)", "mean(root)", "rows"]
KEEP += ["drift(twist)", "drift", "max(y)"]


@pytest.mark.parametrize("event", [False, True])
def test_what_is_kept_is_of_the_rows(pkgen, tmp_path: Path, event: bool) -> None:
    pick = random.Random(int(event))
    keep = [*KEEP, *(["time(left)", "count(left)"] if event else [])]
    pick.shuffle(keep)
    model, plan, folder = (tmp_path / name for name in ("wells.lag", "plan.toml", "s"))
    model.write_text(MODEL + EVENT * event)
    plan.write_text(
        f'until = 12\nmethod = "rk4"\nstep = 0.05\nevery = 0.05\nmembers = 40\nkeep = {keep}\n'
        '[random]\nx = "-0.5 .. 2.5"\n"y\'" = "-1 .. 1"\nc = "0 .. 1"\n'
    )
    done = pkgen("sweep", model, "--plan", plan, "-o", folder, "--shard", 17)
    assert done.returncode == 0, done.stderr
    found = pq.read_table(folder / "data").to_pylist()
    kept = pq.read_table(folder / "rows").to_pylist()
    seen = set()
    for one in found:
        rows = [row for row in kept if row["member"] == one["member"]]
        x, y, root, twist, energy = (
            [row[name] for row in rows] for name in ("x", "y", "root", "twist", "energy")
        )
        assert len(rows) == 241 and one["status"] == "PK_DONE" and one["t"] == rows[-1]["t"] == 12
        assert (one["max(x)"], one["min(x)"], one["max(y)"]) == (max(x), min(x), max(y))
        assert one["mean(y')"] == pytest.approx(sum(row["y'"] for row in rows) / 241, rel=1e-12)
        assert one["final(y)"] == y[-1]
        whole = None not in root  # what is not a number once stays so
        assert one["max(root)"] == (max(root) if whole else None)
        assert one["mean(root)"] == (pytest.approx(sum(root) / 241) if whole else None)
        drift = max(abs(z - twist[0]) for z in twist) / max(map(abs, twist))
        assert one["drift(twist)"] == pytest.approx(drift)
        twice = [row["x'"] ** 2 + row["y'"] ** 2 for row in rows]  # the kinetic energy
        scale = max(t + abs(t - e) for t, e in zip(twice, energy, strict=True))
        drift = max(abs(e - energy[0]) for e in energy) / scale
        assert one["drift(energy)"] == pytest.approx(drift, rel=1e-6)
        if event:
            times = [
                (row["t"], after["t"])
                for row, after in pairwise(rows)
                if row["x"] > 0 >= after["x"]
            ]
            assert one["count(left)"] == len(times)
            if times:
                assert times[0][0] <= one["time(left)"] <= times[0][1]
            else:
                assert one["time(left)"] is None
        seen |= {("whole", whole), ("left", event and one["count(left)"])}
    assert len(seen) >= (5 if event else 3), seen
