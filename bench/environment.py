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
    "casadi",
    "control",
    "numba",
    "distributed",
    "diffrax",
    "pydy",
    "scikit-sundae",
    "mechanicsdsl-core",
    "physicskit",
    "pin",
    "cmeel-eigen",
    "mujoco",
    "example-robot-data",
)
KNOWN = OUTPUT / "environment-installed.json"  # by package why it could not be, or nothing


def main() -> int:
    python = VENV / "bin" / "python"
    known = json.loads(KNOWN.read_text()) if KNOWN.exists() else {}
    if not known:
        OUTPUT.mkdir(parents=True, exist_ok=True)
        subprocess.run([sys.executable, "-m", "venv", "--clear", VENV], check=True)
    for name in (*NEEDED, *PEERS):
        if name not in known:
            known[name] = _install(python, name)
            KNOWN.write_text(json.dumps(known, indent=1))
    missing = [name for name in NEEDED if known[name]]
    if missing:
        KNOWN.unlink()
        print(f"bench: cannot install {', '.join(missing)}: {known[missing[0]]}")
        return 1
    for name, why in known.items():
        if why:
            print(f"bench: {name} could not be installed: {why}", file=sys.stderr)
    return 0


def with_peers(command: str, words: list[str]) -> int:
    """`python -m bench COMMAND` in the Python that has the peers."""
    if main():
        return 1
    again = [VENV / "bin" / "python", "-m", "bench", command, *words]
    return subprocess.run(again, cwd=OUTPUT.parent.parent, check=False).returncode


def _install(python: Path, name: str) -> str:
    """'' or why not."""
    print(f"bench: installing {name}", file=sys.stderr, flush=True)
    command = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    done = subprocess.run([*command, "--upgrade", name], capture_output=True, text=True)
    return "" if done.returncode == 0 else (done.stderr.strip().splitlines() or ["?"])[-1]


if __name__ == "__main__":
    sys.exit(main())
