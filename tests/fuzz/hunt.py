"""Runs random bent models beside their smooth twins: python tests/fuzz/hunt.py [first] [last]."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from bent_models import CLAIMS, PLACES, Place, model

PKGEN = str(Path(__file__).parents[2] / ".venv/bin/pkgen")


def checked(text: str) -> tuple[int, str]:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "bent.lag")
        path.write_text(text)
        done = subprocess.run([PKGEN, "check", str(path)], capture_output=True, text=True)
    return done.returncode, done.stderr


def run(text: str, *options: str) -> tuple[int, list[list[float]], str]:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "bent.lag")
        path.write_text(text)
        done = subprocess.run(
            [PKGEN, "run", str(path), "--scene", "s", *options],
            capture_output=True, text=True, timeout=300,
        )
    rows = [[float(x) for x in line.split(",")[1:]] for line in done.stdout.splitlines()[1:]]
    return done.returncode, rows, done.stderr


def judge(place: Place, seed: int) -> tuple[str, str]:
    """(verdict, what was seen): agrees, refused, ends, WRONG, ..."""
    sharp = model(seed, place, True)
    code, rows, err = run(sharp, "--method", "gauss", "--rtol", "1e-10")
    if code in (1, 2):
        return "refused", err.strip().splitlines()[0]
    if code == 4:
        return "ends", next((x for x in err.splitlines() if x.startswith("run:")), err)
    if code:
        return "BROKEN", err
    code5, rows5, err5 = run(sharp, "--method", "dop853", "--rtol", "1e-10")
    far = []
    for w in (0.002, 0.0005):
        c, r, e = run(
            model(seed, place, False), "--method", "dop853", "--rtol", "1e-10",
            f"--set=w={w}", f"--max-step={w / 2}",
        )
        if c:
            return "no twin", e.strip().splitlines()[-1]
        far.append(max(abs(a - b) for one, two in zip(r, rows) for a, b in zip(one, two)))
    mutual = 9.0
    if not code5:
        mutual = max(abs(a - b) for one, two in zip(rows5, rows) for a, b in zip(one, two))
    seen = f"{far[0]:.1e} {far[1]:.1e} methods {mutual:.0e}" + (" | " + err.strip().splitlines()[0] if "warning" in err else "")
    good = far[1] < 1e-8 or (far[1] < 0.02 and far[1] < 0.6 * far[0])
    if mutual > 1e-6:
        return "METHODS", seen
    return ("agrees" if good else "WRONG"), seen


def claims(place: Place, seed: int) -> tuple[str, str]:
    """A claim that is proved is seen to hold on the smooth twin."""
    proved = []
    for claim in CLAIMS:
        if "z" in claim and len(place.free) < 3 or place.name in ("fixed", "torque", "turned"):
            continue
        if place.name == "hold" and "z" in claim:
            continue
        code, err = checked(model(seed, place, True, claim))
        if "Traceback" in err or "internal" in err:
            return "BROKEN", err
        if code:
            continue
        c, rows, err = run(
            model(seed, place, False, claim), "--method", "dop853", "--rtol", "1e-10",
            "--set=w=0.001", "--max-step=0.0005",
        )
        if c:
            return "no twin", claim + err
        drift = max(abs(row[0] - rows[0][0]) for row in rows)
        if drift > 0.005:
            return "FALSE", f"{claim} drifts {drift:.2g}"
        proved.append(claim)
    return "true", ", ".join(proved)


if __name__ == "__main__":
    first, last = int(sys.argv[1]), int(sys.argv[2])
    only = [word for word in sys.argv[3:] if word != "claims"]
    by_claims = "claims" in sys.argv
    count: Counter[str] = Counter()
    for seed in range(first, last):
        for place in PLACES:
            if only and place.name not in only:
                continue
            try:
                verdict, seen = (claims if by_claims else judge)(place, seed)
            except subprocess.TimeoutExpired:
                verdict, seen = "HANGS", ""
            count[verdict] += 1
            print(f"{place.name:14} {seed:4} {verdict:8} {seen}", flush=True)
    print(count)
