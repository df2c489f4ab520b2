"""`make demo`: the five first models, from .lag text to C to motion, and how well it went.

For each model: generate its C into build/demo, integrate it from the start of its reference by
several methods, and print cost, error of the final state, and drift of the invariants.
The references (tests/models/references.json) have 25 digits, from an independent derivation.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
OUTPUT = ROOT / "build" / "demo"
REFERENCES = json.loads((ROOT / "tests/models/references.json").read_text())

# Of each method: the options that it runs with. The steps of the fixed-step methods are alike,
# so that their drifts can be compared.
METHODS = {
    "dop853": ["--rtol", "1e-13"],
    "gauss": ["--rtol", "1e-13"],
    "gauss4": ["--step", "0.005"],
    "gauss1": ["--step", "0.005"],
    "rk4": ["--step", "0.005"],
    "verlet": ["--step", "0.005"],
}
COLUMNS = "{:<20} {:<7} {:>9} {:>11} {:>9} {:>9} {:>9} {:>9}"
HEADINGS = (
    ("model", "method", "steps", "evaluations", "ms", "error", "energy", "others"),
    ("", "", "", "", "", "of state", "drift", "drift"),
)


def main() -> int:
    OUTPUT.mkdir(parents=True, exist_ok=True)
    print(f"C sources and trajectories in {OUTPUT.relative_to(ROOT)}/\n")
    for heading in HEADINGS:
        print(COLUMNS.format(*heading))
    failures, refusals = 0, []
    for name, reference in REFERENCES.items():
        pkgen(str(model(name)), "-o", str(OUTPUT))
        for method in METHODS:
            failures += not show(name, method, reference, refusals)
    print("", *refusals, sep="\n")
    if failures:
        print(f"\n{failures} run(s) failed", file=sys.stderr)
        return 1
    print("\nnext: .venv/bin/pkgen chart models/double_pendulum.lag  # which method is cheapest")
    return 0


def model(name: str) -> Path:
    return ROOT / "models" / f"{name}.lag"


def show(name: str, method: str, reference: dict, refusals: list[str]) -> bool:
    """Run one model by one method and print its line; whether that went as it should."""
    done = pkgen("run", str(model(name)), *options(name, method, reference), check=False)
    result = json.loads(done.stdout)
    report = result.get("report", {})
    status = report.get("status")
    if status == "PK_REFUSED":
        refusals.append(report["reason"])
        print(COLUMNS.format(name, method, "-", "-", "-", "-", "-", "refused"))
        return True
    if status != "PK_DONE":
        print(name, method, "failed:", done.stdout, done.stderr, file=sys.stderr)
        return False
    drifts = report["drifts"]
    others = [d["max"] for d in drifts if d["name"] != "energy"]
    energy = [d["max"] for d in drifts if d["name"] == "energy"]
    cells = [
        name,
        method,
        report["steps"],
        report["evaluations"],
        f"{1000 * report['seconds']:.1f}",
        f"{error(report, reference):.1e}",
        f"{energy[0]:.1e}" if energy else "-",
        f"{max(others):.1e}" if others else "-",
    ]
    print(COLUMNS.format(*cells))
    return True


def options(name: str, method: str, reference: dict) -> list[str]:
    said = ["--json", "--method", method, *METHODS[method], "--until", reference["t_end"]]
    said += ["-o", str(OUTPUT / f"{name}-{method}.csv")]
    for parameter, value in reference["params"].items():
        said += ["--set", f"{parameter}={value}"]
    coordinates = reference["coords"]
    starts = [*coordinates, *(f"{c}'" for c in coordinates)]
    for coordinate, value in zip(starts, reference["y0"], strict=True):
        said += ["--start", f"{coordinate}={value}"]
    return said


def error(report: dict, reference: dict) -> float:
    """Largest error of the final state, each component relative to max(1, its size)."""
    final = [*report["q"], *report["v"]]
    exact = [float(x) for x in reference["y"]]
    return max(abs(a - b) / max(1.0, abs(b)) for a, b in zip(final, exact, strict=True))


def pkgen(*arguments: str, check: bool = True) -> subprocess.CompletedProcess[str]:
    done = subprocess.run(
        [sys.executable, "-m", "pkgen", *arguments], capture_output=True, text=True
    )
    if check and done.returncode != 0:
        sys.exit(f"pkgen {' '.join(arguments)} failed ({done.returncode}):\n{done.stderr}")
    return done


if __name__ == "__main__":
    sys.exit(main())
