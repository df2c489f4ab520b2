"""Tries mutants: each patch of tests/mutants puts one fault into a copy of the tree.

    python tools/mutants.py [NAME…]    all of them, or some; prints a table

The first line of a patch says the fault. Its second line names the tests that have to fail:
arguments of pytest. A mutant is killed if a quick one fails, which has to pass without it, and
survives otherwise.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

from without_addons import ROOT, copied, python_of

FOLDER = ROOT / "tests" / "mutants"
TREE = ROOT / "build" / "mutants"
FAILED, PASSED = 1, 0  # exit codes of pytest


def head(patch: Path) -> tuple[str, list[str]]:
    """The fault, and the arguments of pytest."""
    fault, tests, *_ = patch.read_text(encoding="utf-8").splitlines()
    assert tests.startswith("tests: "), f"{patch}: its second line is 'tests: …'"
    return fault, tests.removeprefix("tests: ").split()


def patched(tree: Path, patch: Path, *options: str) -> bool:
    command = ["git", "apply", "--unidiff-zero", *options, patch]
    return not subprocess.run(command, cwd=tree).returncode


def outcome(python: Path, words: list[str]) -> tuple[int, str]:
    """The exit code of pytest, and the first test that fails."""
    quick = ["-q", "-x", "-m", "not long", "-p", "no:cacheprovider"]
    command = [python, "-m", "pytest", *quick, *words]
    env = os.environ | {"PYTHONPATH": "", "CFLAGS": "-O1"}
    done = subprocess.run(command, cwd=TREE, env=env, capture_output=True, text=True)
    failed = [line for line in done.stdout.splitlines() if line.startswith("FAILED ")]
    named = failed[0].removeprefix("FAILED ").rpartition(" (")[0] if failed else ""
    return done.returncode, named


def tried(python: Path, patch: Path) -> str:
    _, words = head(patch)
    if not patched(TREE, patch):
        return "it does not apply"
    try:
        code, where = outcome(python, words)
    finally:
        patched(TREE, patch, "--reverse")
    if code == PASSED:
        return "SURVIVED"
    if code != FAILED or not where:
        return f"pytest ends with {code}"
    if outcome(python, [where])[0] != PASSED:
        return f"{where} fails without it too"
    return f"killed by {where}"


def main() -> int:
    copied(TREE, [])
    subprocess.run(["git", "init", "-q"], cwd=TREE, check=True)  # tests ask git for the files
    subprocess.run(["git", "add", "-A"], cwd=TREE, check=True)
    python = python_of(TREE)
    patches = [FOLDER / f"{name}.patch" for name in sys.argv[1:]] or sorted(FOLDER.glob("*.patch"))
    killed = 0
    for patch in patches:
        start = time.monotonic()
        said = tried(python, patch)
        killed += said.startswith("killed")
        print(f"{patch.stem:24} {time.monotonic() - start:5.0f} s  {said}", flush=True)
    print(f"{killed} of {len(patches)} mutants are killed")
    return killed < len(patches)


if __name__ == "__main__":
    sys.exit(main())
