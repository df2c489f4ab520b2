"""What a command imports: nothing that it does not use."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from conftest import ROOT

MODEL = ROOT / "models/double_pendulum.lag"
HEAVY = {"sympy", "numpy", "matplotlib", "rich", "pint", "jinja2"}
COMMANDS = {
    "--version": ([], {"lark", "pkgen.compiler"} | HEAVY),
    "check": ([MODEL], {"pkgen.back.c.render", "pkgen.run.library"} | HEAVY),
    "run": ([MODEL, "--until", "1"], {"pkgen.analysis", "pkgen.explain"} | HEAVY - {"jinja2"}),
    "explain": ([MODEL], {"pkgen.run.library", "matplotlib", "numpy", "rich"}),
    "methods": ([], {"lark", "pkgen.compiler"} | HEAVY),
}


def imported(command: str, words: list[object], folder: Path) -> set[str]:
    done = subprocess.run(
        [sys.executable, "-X", "importtime", "-m", "pkgen", command, *map(str, words)],
        cwd=folder,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return set(re.findall(r"^import time: .*\| +(\S+)$", done.stderr, re.MULTILINE))


@pytest.mark.parametrize("command", COMMANDS)
def test_no_command_imports_what_it_does_not_use(command: str, tmp_path: Path) -> None:
    words, without = COMMANDS[command]
    found = imported(command, words, tmp_path)
    assert "pkgen.system.exits" in found
    assert sorted(found & without) == []


def test_models_compile_without_sympy(tmp_path: Path) -> None:
    """And what needs it says so."""
    script = (
        "import sys; from importlib.machinery import PathFinder; find = PathFinder.find_spec\n"
        "def some(name, *more):\n"
        "    return None if name in ('sympy', 'mpmath') else find(name, *more)\n"
        "PathFinder.find_spec = some\n"
        "from pkgen.__main__ import main; sys.exit(main(sys.argv[1:]))"
    )

    def run(*words: object) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-c", script, *map(str, words)]
        return subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)

    models = sorted(ROOT.glob("models/*.lag"))
    assert len(models) >= 5
    for model in models:
        done = run(model, "-o", tmp_path / model.stem)
        assert done.returncode == 0, f"{model.name}: {done.stderr}"
        assert run("check", model).returncode == 0
    done = run("explain", MODEL)
    assert done.returncode == 2 and "SymPy, which is not installed" in done.stderr
    assert "internal error" not in done.stderr
