"""Each mutant still applies, and its header names tests that are there (tools/mutants.py)."""

import re
import subprocess

import pytest

from conftest import ROOT

PATCHES = sorted((ROOT / "tests" / "mutants").glob("*.patch"))


@pytest.mark.parametrize("patch", PATCHES, ids=lambda path: path.stem)
def test_a_mutant_applies(patch) -> None:
    fault, tests, minus, *_ = patch.read_text(encoding="utf-8").splitlines()
    if not (ROOT / minus.removeprefix("--- a/")).exists() and "addons/" in minus:
        pytest.skip("the add-on is not here")
    assert fault.endswith(".") and re.fullmatch(r"tests: [\w/. ]+", tests)
    assert all((ROOT / path).exists() for path in tests.split()[1:])
    assert (
        subprocess.run(["git", "apply", "--unidiff-zero", "--check", patch], cwd=ROOT).returncode
        == 0
    )
