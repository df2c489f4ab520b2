"""What an N-link pendulum costs to derive, emit and compile: bench/chain.py, run by pkgen's own
interpreter; its last line of output is JSON."""

from __future__ import annotations

import json
import subprocess

from .builds import Unavailable
from .models import ROOT
from .peers.own import pkgen_python


def measure() -> dict[int, dict[str, float]]:
    """By N: derive_seconds, emit_seconds, operations, gcc_seconds."""
    command = [pkgen_python(), str(ROOT / "bench" / "chain.py"), "20", "100"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
    said = done.stdout.strip().splitlines()
    if done.returncode or not said or not said[-1].startswith("{"):
        raise Unavailable((done.stderr.strip().splitlines() or ["bench/chain.py says no JSON"])[-1])
    return {row["n"]: row for row in json.loads(said[-1])["rows"]}
