"""No feature is lost: features.txt was first written before there were add-ons, at 321f31f0."""

from __future__ import annotations

import subprocess
import sys

import pytest

from conftest import ROOT, gone


@pytest.mark.needs_addon
@pytest.mark.skipif(bool(gone()), reason="add-ons have some")
def test_commands_options_statements_methods_and_exports_are_the_listed_ones() -> None:
    command = [sys.executable, ROOT / "tools/features.py"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    listed = (ROOT / "tests/features.txt").read_text(encoding="utf-8").splitlines()
    lost, new = set(listed) - {*done.stdout.splitlines()}, {*done.stdout.splitlines()} - {*listed}
    assert lost == set() and new == set(), "new ones: python tools/features.py > tests/features.txt"
