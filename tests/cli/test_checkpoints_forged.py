"""Checkpoints that somebody has forged, their sum with them: refused, or a run; see tests/fuzz."""

from __future__ import annotations

import random
import subprocess
import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import checkpoint_runs as runs
import pytest

from conftest import ROOT
from pkgen.run.library import load

FUZZ = ROOT / "tests/fuzz/checkpoints.py"


def test_nothing_is_read_outside_memory() -> None:
    done = subprocess.run([sys.executable, FUZZ, "20", str(random.randrange(10**6))], text=True)
    assert done.returncode == 0


@pytest.mark.parametrize("case", [("events", "dop853"), ("free", "verlet")], ids="-".join)
def test_what_is_no_state_is_refused(case: tuple[str, str], tmp_path: Path) -> None:
    spec = spec_from_file_location("forging", FUZZ)
    forging = module_from_spec(spec)
    spec.loader.exec_module(forging)
    name, method = case
    what = runs.by(runs.of(name, tmp_path), method)
    run, ck, dice = load(what.library).run, tmp_path / "c", random.Random(name)
    how = {"checkpoint": bytes(ck)}
    assert run(what.settings, None, None, checkpoint_after=30, **how).code == 75
    good, codes = ck.read_bytes(), set()
    for _ in range(300):
        ck.write_bytes(forging.forged(good, dice))
        found = run(what.settings, None, None, checkpoint_after=20, resume=1, **how)
        assert found.code in (0, 2, 4, 75)
        codes.add(found.code)
    assert 2 in codes and codes & {0, 75}
