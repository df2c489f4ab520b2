"""The peers' own Python environment, build/bench/venv: each package installed by itself, so that
one that cannot be had is reported and the others stay.

    python bench/environment.py          prints the environment's interpreter
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

OUTPUT = Path(__file__).resolve().parent.parent / "build" / "bench"
VENV = OUTPUT / "venv"
# The first three are what the bench itself needs; the rest are peers.
NEEDED = ("sympy", "numpy", "matplotlib")
PEERS = (
    "scipy",
    "heyoka",
    "numba",
    "pydy",
    "scikit-sundae",
    "mechanicsdsl-core",
    "physicskit",
)
TROUBLES = OUTPUT / "environment.json"


def main() -> int:
    python = VENV / "bin" / "python"
    if not TROUBLES.exists():
        OUTPUT.mkdir(parents=True, exist_ok=True)
        subprocess.run([sys.executable, "-m", "venv", "--clear", VENV], check=True)
        found = {name: _install(python, name) for name in (*NEEDED, *PEERS)}
        missing = [name for name in NEEDED if found[name]]
        if missing:
            print(f"bench: cannot install {', '.join(missing)}: {found[missing[0]]}")
            return 1
        TROUBLES.write_text(json.dumps({n: w for n, w in found.items() if w}, indent=1))
    for name, why in json.loads(TROUBLES.read_text()).items():
        print(f"bench: {name} could not be installed: {why}", file=sys.stderr)
    return 0


def _install(python: Path, name: str) -> str:
    """'' or why not."""
    print(f"bench: installing {name}", file=sys.stderr, flush=True)
    command = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    done = subprocess.run([*command, "--upgrade", name], capture_output=True, text=True)
    return "" if done.returncode == 0 else (done.stderr.strip().splitlines() or ["?"])[-1]


if __name__ == "__main__":
    sys.exit(main())
