"""The bench starts in the peers' Python, which has no pkgen."""

import ast
import importlib
import subprocess
import sys
from pathlib import Path

import pytest

from conftest import ROOT

WITHOUT = """
import sys
sys.modules['pkgen'] = None
import bench.__main__, bench.rotations, bench.side_by_side
"""


def test_the_bench_starts_without_pkgen() -> None:
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("path", sorted((ROOT / "bench").rglob("*.py")), ids=lambda p: p.stem)
def test_what_the_bench_takes_from_pkgen_is_there(path: Path) -> None:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "pkgen":
            folder = importlib.import_module(node.module)
            for name in node.names:
                if not hasattr(folder, name.name):
                    importlib.import_module(f"{node.module}.{name.name}")
