"""Runs that fail or are cut short: what is said, and the exit code."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from conftest import MODELS, ROOT, case
from pkgen import limits
from pkgen.compiler import compile_model
from pkgen.front.read import read
from pkgen.run import members_file
from pkgen.system.exits import UsageError

HOOP = ROOT / "models/bead_on_hoop.lag"


FALL = case("failures_fall")


def test_numerical_failure_says_when(pkgen, tmp_path: Path) -> None:
    (tmp_path / "fall.lag").write_text(FALL)  # reaches x < 0, where sqrt(x) is not a number
    done = pkgen("run", tmp_path / "fall.lag", "--until", "10", "--json")
    assert done.returncode == 4
    report = json.loads(done.stdout)["report"]
    assert report["status"] != "PK_DONE" and 1 < report["t"] < 2
    assert all(x == x for row in json.loads(done.stdout)["rows"] for x in row)


def test_broken_compiler(pkgen, tmp_path: Path) -> None:
    env = {**os.environ, "CC": "false", "PKGEN_CACHE": str(tmp_path)}
    done = pkgen("run", HOOP, "--until", "1", env=env)
    assert done.returncode == 3, done.stderr
    done = pkgen("run", HOOP, "--until", "1", env={**env, "CC": "no-such-compiler"})
    assert done.returncode == 3 and "no-such-compiler" in done.stderr


FULL, CLOSED = "standard output: No space left on device", "Bad file descriptor"
HOSTILE = {  # the command line as a shell has it: its exit code, the one line that is said
    "max-seconds nan": ("check M --max-seconds nan", 2, "--max-seconds nan: give seconds"),
    "max-seconds inf": ("check M --max-seconds inf", 2, "--max-seconds inf: give seconds"),
    "max-seconds -1": ("run M --max-seconds -1", 2, "--max-seconds -1: give seconds"),
    "max-seconds 0": ("M --max-seconds 0", 2, "--max-seconds 0: give seconds"),
    "every": ("run M --every 1e-300", 2, "--every 1e-300: 1e+301 rows of 4 numbers are some"),
    "full": ("run M --until 1 --json >/dev/full", 2, FULL),
    "full for rows": ("run M --until 1 >/dev/full", 2, "cannot write rows: No space left"),
    "full for a table": ("methods >/dev/full", 2, FULL),
    "closed": ("run M --until 1 >&-", 2, f"run: cannot write rows: {CLOSED}"),
    "closed for JSON": ("run M --until 1 --json >&-", 2, f"standard output: {CLOSED}"),
    "closed errors": ("run M --until 1 2>&-", 0, ""),
    "not text": ("run M --ensemble /dev/zero", 2, "/dev/zero:1: a line of more than 1,000,000"),
    "files": ("(ulimit -f 2; P run M --until 9 -o rows.csv)", 2, "rows: File too large"),
    "no file": ("(ulimit -f 0; P run M --until 9 -o rows.csv)", 2, "json: File too large"),
    "no compiler": ("CC='gcc \"' P run M", 3, 'the environment variable CC is gcc ": no closing'),
    "head": ("run M --until 500 --every 0.001 | head -1 >/dev/null; exit ${PIPESTATUS[0]}", 0, ""),
}


@pytest.fixture(scope="module")
def compiled() -> None:
    """The model is in the cache: a limit is for what is written besides."""
    subprocess.run([sys.executable, "-m", "pkgen", "run", str(HOOP), "--until", "1"], check=True)


@pytest.mark.parametrize("case", HOSTILE)
def test_a_hostile_call_ends_with_one_clear_line(case: str, tmp_path: Path, compiled) -> None:
    text, code, said = HOSTILE[case]
    text = text if " P " in text else f"P {text}"
    script = re.sub(r"\bM\b", str(HOOP), re.sub(r"\bP\b", f"{sys.executable} -m pkgen", text))
    done = subprocess.run(
        ["bash", "-c", f"ulimit -v 6000000; {script}"],
        capture_output=True,
        text=True,
        timeout=600,
        cwd=tmp_path,
    )
    assert done.returncode == code, done.stderr
    said_of_rows = "rows as far as they came"
    lines = [line for line in done.stderr.splitlines() if said_of_rows not in line]
    assert len(lines) == bool(said) and said in "".join(lines)


def test_an_ensemble_without_end_is_refused_by_its_size(pkgen, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr(limits, "SWARM", 1000)
    path = tmp_path / "many.csv"
    path.write_text("theta\n" + 1001 * "1\n")
    (model,) = [m for m in MODELS if m.name == HOOP.name]
    compilation = compile_model(read(model), unroll=None)
    with pytest.raises(UsageError, match=r"many.csv:1002: the limit is 1,000 members"):
        members_file.read(str(path), compilation)
    path.write_text("theta\n" + 1000 * "1\n")
    assert len(members_file.read(str(path), compilation).lines) == 1000
