"""The bench starts in the peers' Python, which has no pkgen."""

from __future__ import annotations

import subprocess
import sys

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
