"""`make bench QUICK=1` whole, with the peers, on one model. No time is asserted.

The peers' environment is made first. Who cannot be installed is named in the report and takes no
part; without SymPy, NumPy or matplotlib there is no bench, which is a failure and not a skip.
"""

import json
import subprocess
import sys

from bench import environment
from conftest import ROOT

MODEL = "double_pendulum"
PARTS = ("Kernels", "Double pendulum", "Ensembles", "Chains", "Long run", "Derivation")


def test_the_quick_bench_runs_whole() -> None:
    made = subprocess.run(
        [sys.executable, ROOT / "bench" / "environment.py"], capture_output=True, text=True
    )
    assert made.returncode == 0, made.stdout + made.stderr
    known = json.loads(environment.KNOWN.read_text())
    missing = {name: why for name, why in known.items() if why}
    for name, why in missing.items():
        assert f"bench: {name} could not be installed: {why}" in made.stderr
        print(f"without {name}: {why}")
    python = environment.VENV / "bin" / "python"
    done = subprocess.run(
        [python, "-m", "bench", "--quick", "--models", MODEL],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr[-4000:]
    assert "bench: failed" not in done.stderr
    sections = dict(part.split("\n", 1) for part in done.stdout.split("\n## ")[1:])
    for part in PARTS:
        assert "|" in sections[part] or part == "Long run", sections[part]
    assert "gauss8" in sections["Long run"] and "not reached" not in sections["Derivation"]
    for name, package in (("heyoka", "heyoka"), ("SciPy DOP853", "scipy")):
        assert package in missing or f"| {name} " in sections["Double pendulum"]
