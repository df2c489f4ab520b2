"""Random models with a bend or a jump in one place, run beside their smooth twins.

python tests/fuzz/hunt.py FIRST LAST [claims] [pairs] [roots] [PLACE...]

Seeds go from FIRST to before LAST.

Each model is run one way more, drawn by its text: with fixed steps, as an ensemble, with rows at
events, or with one column. With `pairs` each model has two bends, some at once; with `roots`,
roots of them, of which radau takes the place of gauss; with `claims`, what is proved constant of
free models is watched on the twin instead. Exit code 1 where a motion is wrong, methods or ways
differ, a proof is false or a run breaks.
"""

import math
import os
import random
import re
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from bent_models import CLAIMS, KINDS, PLACES, ROOTS, Place, model, together

COMMAND = [sys.executable, "-m", "pkgen"]
HERE = os.environ | {"PYTHONPATH": str(Path(__file__).parents[2] / "generator")}
GAUSS = ("--method", "gauss", "--rtol", "1e-10")
RADAU = ("--method", "radau", "--rtol", "1e-12")
TIGHT = ("--method", "dop853", "--rtol", "1e-10")
BAD = ("WRONG", "METHODS", "WAYS", "FALSE", "BROKEN", "HANGS", "no twin")
Rows = list[list[float]]
Places = tuple[Place, ...]


def pkgen(command: str, text: str, *options: str) -> tuple[int, Rows, str]:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "bent.lag")
        path.write_text(text)
        Path(folder, "members.csv").write_text("g\n0.7\n1\n1.6\n")
        options = tuple(x.replace("members.csv", f"{folder}/members.csv") for x in options)
        words = [*COMMAND, command, str(path), *options]
        done = subprocess.run(words, capture_output=True, text=True, timeout=300, env=HERE)
    if done.returncode and "No module named" in done.stderr:
        raise RuntimeError(done.stderr)  # else all would count as refused
    rows = [[float(x) for x in line.split(",")[1:]] for line in done.stdout.splitlines()[1:]]
    return done.returncode, rows, done.stderr


def run(text: str, *options: str) -> tuple[int, Rows, str]:
    return pkgen("run", text, "--scene", "s", *options)


def first(text: str) -> tuple[str, ...]:
    """A method that is not TIGHT's. gauss is refused where roots of bends stand."""
    return RADAU if "sqrt(max" in text or "^1.5" in text else GAUSS


def twin(text: str, width: float) -> tuple[int, Rows, str]:
    return run(text, *TIGHT, f"--set=w={width}", f"--max-step={width / 2}")


def apart(a: Rows, b: Rows) -> float:
    if len(a) != len(b):
        return float("inf")
    pairs = [(x, y) for one, two in zip(a, b, strict=True) for x, y in zip(one, two, strict=True)]
    return max(abs(x - y) for x, y in pairs)


def judge(places: Places, seed: int, kinds: tuple[str, ...] = KINDS) -> tuple[str, str]:
    """What became of a model, and how far its twins of two widths, methods and ways are."""
    sharp, smooth = (model(seed, places, x, kinds=kinds) for x in (True, False))
    code, rows, err = run(sharp, *first(sharp))
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
    if not (far[1] < 1e-8 or (far[1] < 0.02 and far[1] < 0.6 * far[0])):
        return "WRONG", seen
    way = random.Random(sharp).choice(WAYS)
    worst = way(sharp, rows)
    seen += f" {way.__name__} {worst:.0e}"
    # From where a root sets in, fixed steps are of order 1.5.
    most = 1e-5 if kinds == ROOTS else 1e-6
    return ("agrees" if worst < most else "WAYS"), seen


def fixed(text: str, rows: Rows) -> float:
    """Methods of fixed steps: each switch is a step's end, so their order is kept."""
    theirs = (run(text, "--method", method, "--step=0.001") for method in ("rk4", "gauss4"))
    return max(apart(found, rows) if code == 0 else math.inf for code, found, _ in theirs)


def ensemble(text: str, _: Rows) -> float:
    """Three members are those three runs: to the tolerance, and with fixed steps to the bit."""
    worst = 0.0
    for method, most in ((first(text), 1e-8), (("--method", "rk4", "--step=0.01"), 0)):
        code, rows, _ = run(text, *method, "--ensemble=members.csv")
        alone = [run(text, *method, f"--set=g={g}") for g in (0.7, 1, 1.6)]
        if code or any(one[0] for one in alone):
            return math.inf if bool(code) != any(one[0] for one in alone) else 0.0
        off = apart([row[1:] for row in rows], [x for one in alone for x in one[1]])
        worst = max(worst, off if off <= most else 1.0)
    return worst


def events(text: str, rows: Rows) -> float:
    """Rows at the surface of a bend: as many by both methods, and the others unchanged."""
    found = []
    for method in (first(text), TIGHT):
        code, theirs, _ = run(text, *method, "--at=e", "--every=1")
        if code:
            return math.inf
        found.append(theirs)
    return max(apart(*found), max(min(apart([a], [b]) for b in found[0]) for a in rows))


def column(text: str, rows: Rows) -> float:
    """A scene that records one column has no more than that needs, and the same numbers."""
    names = re.search(r"record (.*) every", text)
    assert names
    names = [name for name in names[1].split(", ") if "R" not in name]
    worst = 0.0
    for at in (0, len(names) - 1):
        code, theirs, _ = run(text, *first(text), f"--record={names[at]}")
        worst = max(worst, apart(theirs, [[row[at]] for row in rows]) if code == 0 else math.inf)
    return worst


WAYS = (fixed, ensemble, events, column)


def claims(places: Places, seed: int) -> tuple[str, str]:
    """A claim that is proved is seen to hold on the smooth twin."""
    proved = []
    held = any(place.name == "hold" for place in places)
    free = max(len(place.free) for place in places)
    for claim in CLAIMS:
        if "z" in claim and (free < 3 or held):
            continue
        if held and claim in ("energy", "T"):
            continue  # they are the model's, and the scene holds a coordinate
        code, _, err = pkgen("check", model(seed, places, True, claim))
        if "Traceback" in err or "internal error" in err:
            return "BROKEN", err
        if code:
            continue
        code, rows, err = twin(model(seed, places, False, claim), 0.001)
        if code:
            return "no twin", f"{claim}: {err}"
        drift = max(abs(row[0] - rows[0][0]) for row in rows)
        if drift > 0.005:
            return "FALSE", f"{claim} drifts {drift:.2g}"
        proved.append(claim)
    return "true", ", ".join(proved)


def hunt(seeds: range, of: list[Places], words: list[str]) -> Counter[str]:
    count: Counter[str] = Counter()
    for seed in seeds:
        for places in of:
            try:
                if "claims" in words:
                    verdict, seen = claims(places, seed)
                else:
                    verdict, seen = judge(places, seed, ROOTS if "roots" in words else KINDS)
            except subprocess.TimeoutExpired:
                verdict, seen = "HANGS", ""
            count[verdict] += 1
            name = " ".join(place.name for place in places)
            print(f"{name:26} {seed:4} {verdict:8} {seen}", flush=True)
    return count


if __name__ == "__main__":
    words = sys.argv[3:]
    only = [place for place in PLACES if place.name in words] or list(PLACES)
    pairs = [(a, b) for a in only for b in only if together(a, b)]
    of: list[Places] = pairs if "pairs" in words else [(place,) for place in only]
    count = hunt(range(int(sys.argv[1]), int(sys.argv[2])), of, words)
    print(", ".join(f"{n} {verdict}" for verdict, n in count.items()))
    sys.exit(any(count[verdict] for verdict in BAD))
