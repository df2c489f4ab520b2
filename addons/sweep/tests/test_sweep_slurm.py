"""The Slurm engine without Slurm: a queue that runs all tasks of an array at once, in order."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest
from sweeps import contents

pytest.importorskip("pyarrow.parquet")
SBATCH = """#!/bin/sh
n=$(sed -n 's/^#SBATCH --array=1-\\([0-9]*\\).*/\\1/p' "$2")
for task in $(seq "$n"); do SLURM_ARRAY_TASK_ID=$task sh "$2" >&2; done
echo 17
"""
MODEL = """model heavy
param m = 1 in (0, inf)
coord q
kinetic m*(1 - q)*q'^2/2
event half: q - 0.5 rising
start q' = 0.5
"""


@pytest.mark.long
@pytest.mark.parametrize("rows", [True, False])
def test_programs_write_the_shards_that_python_does(pkgen, tmp_path: Path, rows: bool) -> None:
    """Some of their members fail; with rows there are several blocks in a shard."""
    queue, model, plan = (tmp_path / name for name in ("bin", "heavy.lag", "plan.toml"))
    queue.mkdir()
    for name, text in (("sbatch", SBATCH), ("squeue", "#!/bin/sh\n")):
        (queue / name).write_text(text)
        (queue / name).chmod(0o755)
    model.write_text(MODEL)
    keep = ["max(q)", "count(half)", "time(half)", "drift", *(["rows"] if rows else [])]
    plan.write_text(
        f'until = 0.5\nevery = 0.1\nmethod = "rk4"\nstep = 1e-2\nmembers = 700\nkeep = {keep}\n'
        '[sobol]\nq = "0 .. 1"\nm = "-0.1 .. 2"\n'
    )
    path = f"{queue}{os.pathsep}{os.environ['PATH']}"
    for engine in ("local", "slurm"):
        more = ("--engine", engine, "--shard", 300, "-o", tmp_path / engine)
        env = {**os.environ, "PATH": path} if engine == "slurm" else None
        done = pkgen("sweep", model, "--plan", plan, *more, env=env)
        assert done.returncode == 0, done.stderr
    assert "submitted as array 17, 3 shards" in done.stderr
    assert contents(tmp_path / "slurm") == contents(tmp_path / "local")
    ran, made = (
        json.loads((tmp_path / engine / "parts/000000").read_text())
        for engine in ("local", "slurm")
    )
    assert ran == made
    failed = {one["status"] for one in made["failures"]}
    assert failed == {"PK_OUT_OF_BOUNDS", "PK_SINGULAR_COORDINATES"}
    assert not list((tmp_path / "slurm/slurm").glob("s*-*"))
