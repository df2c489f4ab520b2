"""The recipe of the README for Kubernetes, with a stand-in for kubectl that runs the command of
the container for each index of the Job."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest
from sweeps import DOUBLE, PLAN, contents

from conftest import ROOT

pytest.importorskip("pyarrow")
KUBECTL = r"""#!/bin/sh
[ "$1" = get ] && { echo "$2" >> "$0.asked"; echo Complete; exit; }
cat > "$0.yaml"
n=$(sed -n 's/^  completions: //p' "$0.yaml")
script=$(sed -n 's/.*command: \[sh, "\([^"]*\)"\].*/\1/p' "$0.yaml")
for k in $(seq 0 $((n - 1))); do JOB_COMPLETION_INDEX=$k sh "$script" >&2; done
echo job.batch/pkgen-x1
"""


def test_an_indexed_job_writes_the_bytes_of_local(pkgen, tmp_path: Path) -> None:
    text = (ROOT / "addons/sweep/README.md").read_text(encoding="utf-8")
    scripts = dict(re.findall(r"`(sbatch|squeue)`:\n\n```sh\n(.*?)```", text, re.S))
    queue, plan = tmp_path / "bin", tmp_path / "plan.toml"
    queue.mkdir()
    for name, what in {**scripts, "kubectl": KUBECTL}.items():
        (queue / name).write_text(what)
        (queue / name).chmod(0o755)
    plan.write_text(PLAN.replace("members = 8", "members = 50"))
    env = {**os.environ, "PATH": f"{queue}{os.pathsep}{os.environ['PATH']}"}
    env.pop("SLURM_ARRAY_TASK_ID", None)
    assert pkgen("sweep", DOUBLE, "--plan", plan, "-o", tmp_path / "local").returncode == 0
    more = ("--engine", "slurm", "--shard", 9, "-o", tmp_path / "jobs")
    done = pkgen("sweep", DOUBLE, "--plan", plan, *more, env=env)
    assert done.returncode == 0, done.stderr
    assert "submitted as array job.batch/pkgen-x1, 6 shards" in done.stderr
    assert contents(tmp_path / "jobs") == contents(tmp_path / "local")
    said = (queue / "kubectl.yaml").read_text()
    assert "completionMode: Indexed" in said and "completions: 6" in said
    yaml = pytest.importorskip("yaml")
    assert yaml.safe_load(said)["spec"]["template"]["spec"]["containers"][0]["command"][0] == "sh"
