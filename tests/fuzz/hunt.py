"""Random models with a bend or a jump in one place, run beside their smooth twins.

python tests/fuzz/hunt.py FIRST LAST [claims] [PLACE...]   seeds from FIRST to before LAST; with
`claims`, what is proved constant of free models is watched on the twin instead. Exit code 1 where
a motion is wrong, methods differ, a proof is false or a run breaks.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from bent_models import CLAIMS, PLACES, Place, model

COMMAND = [sys.executable, "-m", "pkgen"]
HERE = os.environ | {"PYTHONPATH": str(Path(__file__).parents[2] / "generator")}
TIGHT = ("--method", "dop853", "--rtol", "1e-10")
BAD = ("WRONG", "METHODS", "FALSE", "BROKEN", "HANGS", "no twin")
Rows = list[list[float]]


def pkgen(command: str, text: str, *options: str) -> tuple[int, Rows, str]:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "bent.lag")
        path.write_text(text)
        words = [*COMMAND, command, str(path), *options]
        done = subprocess.run(words, capture_output=True, text=True, timeout=300, env=HERE)
    if done.returncode and "No module named" in done.stderr:
        raise RuntimeError(done.stderr)  # else all would count as refused
    rows = [[float(x) for x in line.split(",")[1:]] for line in done.stdout.splitlines()[1:]]
    return done.returncode, rows, done.stderr


def run(text: str, *options: str) -> tuple[int, Rows, str]:
    return pkgen("run", text, "--scene", "s", *options)


def twin(text: str, width: float) -> tuple[int, Rows, str]:
    return run(text, *TIGHT, f"--set=w={width}", f"--max-step={width / 2}")


def apart(a: Rows, b: Rows) -> float:
    if len(a) != len(b):
        return float("inf")
    pairs = [(x, y) for one, two in zip(a, b, strict=True) for x, y in zip(one, two, strict=True)]
    return max(abs(x - y) for x, y in pairs)


def judge(place: Place, seed: int) -> tuple[str, str]:
    """What became of a model, and how far its twins of two widths and two methods are."""
    sharp, smooth = model(seed, place, True), model(seed, place, False)
    code, rows, err = run(sharp, "--method", "gauss", "--rtol", "1e-10")
    if "Traceback" in err or "internal error" in err:
        return "BROKEN", err
    if code:
        said = next((x for x in err.splitlines() if "run:" in x or "error" in x), err)
        return ("ends" if code == 4 else "refused"), said
    far = []
    for width in (0.002, 0.0005):
        code, theirs, err = twin(smooth, width)
        if code:
            return "no twin", err.strip().splitlines()[-1]
        far.append(apart(theirs, rows))
    code, theirs, _ = run(sharp, *TIGHT)
    between = apart(theirs, rows) if code == 0 else float("inf")
    seen = f"{far[0]:.1e} {far[1]:.1e} methods {between:.0e}"
    if between > 1e-6:
        return "METHODS", seen
    good = far[1] < 1e-8 or (far[1] < 0.02 and far[1] < 0.6 * far[0])
    return ("agrees" if good else "WRONG"), seen


def claims(place: Place, seed: int) -> tuple[str, str]:
    """A claim that is proved is seen to hold on the smooth twin."""
    proved = []
    for claim in CLAIMS:
        if "z" in claim and (len(place.free) < 3 or place.name == "hold"):
            continue
        if place.name == "hold" and claim in ("energy", "T"):
            continue  # they are the model's, and the scene holds a coordinate
        code, _, err = pkgen("check", model(seed, place, True, claim))
        if "Traceback" in err or "internal error" in err:
            return "BROKEN", err
        if code:
            continue
        code, rows, err = twin(model(seed, place, False, claim), 0.001)
        if code:
            return "no twin", f"{claim}: {err}"
        drift = max(abs(row[0] - rows[0][0]) for row in rows)
        if drift > 0.005:
            return "FALSE", f"{claim} drifts {drift:.2g}"
        proved.append(claim)
    return "true", ", ".join(proved)


def hunt(seeds: range, places: list[Place], by_claims: bool) -> Counter[str]:
    count: Counter[str] = Counter()
    for seed in seeds:
        for place in places:
            try:
                verdict, seen = (claims if by_claims else judge)(place, seed)
            except subprocess.TimeoutExpired:
                verdict, seen = "HANGS", ""
            count[verdict] += 1
            print(f"{place.name:14} {seed:4} {verdict:8} {seen}", flush=True)
    return count


if __name__ == "__main__":
    words = sys.argv[3:]
    only = [place for place in PLACES if place.name in words] or list(PLACES)
    count = hunt(range(int(sys.argv[1]), int(sys.argv[2])), only, "claims" in words)
    print(", ".join(f"{n} {verdict}" for verdict, n in count.items()))
    sys.exit(any(count[verdict] for verdict in BAD))
