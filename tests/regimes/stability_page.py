"""results/stability.md: predicted against measured, a row a prediction, by PKGEN_UPDATE=1.

Each test that runs puts its own row in place, so that the long ones' stay when the short ones are
measured again; text, order and predictions are the catalogue's.
"""

import fcntl
import math
import os
import re
from datetime import date
from pathlib import Path

from .catalogue import MISSING, PREDICTIONS
from .prediction import Prediction

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs/dev/results/stability.md"
LOCK = ROOT / "build" / "stability-page.lock"
HEAD = """\
# Where methods fail: predicted and measured

Each prediction was made before it was run: a closed form, evaluated beside the test, or a value
converged by other means. The models are in `tests/regimes/models/` (some in `models/`), the
predictions and how each is measured in `tests/regimes/*.py`: by the runtime's own steps, taken one
by one, or by the commands that are shown below. A prediction is met if the measured value lies
within the tolerance of it, or in the band that it is, and the worse method beside it, measured in
the same way, does not; where no method can be worse, something else is changed, and why stands at
the end. A limit that is met says more: the motion is stable at .999 of it and grows at 1.001. `make
test` measures some, `make test-long` all, those marked *long* with the
day on which they were; with `PKGEN_UPDATE=1` either writes its rows here. Closed forms are to be
met within 1% or closer, boundaries within .1%, fitted powers within 5%, variances of many members
within 2%, what was only ever measured within its band or 20%.
y = h omega; frequencies are in units of omega where no unit is given.

"""
COLUMNS = (
    "id", "system and method", "prediction", "predicted", "tolerance", "measured", "difference",
    "worse", "its value", "result",
)  # fmt: skip


WITHOUT = """\
What is worse beside these is no other method but another motion, step or approximation.

"""


def without_method() -> list[Prediction]:
    return [e for e in PREDICTIONS if e.no_method]


def number(x: float) -> str:
    return "none" if math.isinf(x) else "lost" if math.isnan(x) else f"{x:.12g}"


def predicted(entry: Prediction) -> str:
    if isinstance(entry.predicted, tuple):
        return f"{entry.predicted[0]:.3g} to {entry.predicted[1]:.3g}"
    return number(entry.predicted)


def row(entry: Prediction, measured: float, worse: float) -> list[str]:
    band = isinstance(entry.predicted, tuple)
    return [
        entry.id,
        entry.system + (f" *(long, {date.today()})*" if entry.long else ""),
        entry.says.replace("|", "\\|"),
        predicted(entry),
        "band" if band else f"{100 * entry.tolerance:g}%" if entry.tolerance else "exact",
        number(measured),
        "" if band else f"{measured / entry.predicted - 1:+.1e}",
        entry.worse,
        number(worse),
        "met" if entry.met(measured) else "**MISSED**",
    ]


def cells(line: str) -> list[str]:
    return [c.strip() for c in re.split(r"(?<!\\)\|", line)[1:-1]]


def rows() -> dict[str, list[str]]:
    """Those of the page as it is, by id."""
    lines = PAGE.read_text(encoding="utf-8").splitlines() if PAGE.exists() else []
    found = [cells(line) for line in lines if line.startswith("| ")]
    return {c[0]: c for c in found if len(c) == len(COLUMNS) and c[0] not in ("id", "---")}


def write(entry: Prediction, measured: float, worse: float) -> None:
    if not os.environ.get("PKGEN_UPDATE"):
        return
    with LOCK.open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        known = rows() | {entry.id: row(entry, measured, worse)}
        new = LOCK.with_suffix(".md")
        new.write_text(text(known), encoding="utf-8")
        os.replace(new, PAGE)  # others read it


def table(entries: list[Prediction], known: dict[str, list[str]]) -> str:
    lines = [COLUMNS, ("---",) * len(COLUMNS)]
    lines += [known[e.id] for e in entries if e.id in known]
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)


COMMANDS = """\
These are measured by pkgen's commands alone. Each, in `tests/regimes/models`, is followed by
`-o rows.csv`, of a chart or a map by `-o` and a folder; what is read is an expression in the
columns, in `report` (that of `rows.csv.json`, of charts and maps what `--json` prints) and in what
`tests/regimes/shown.py` has (`times` of an event, `errors` of a chart, what is `mapped`; of a
loop's variable `power`, `root` and `edge`). The worse run has the options of the last column
instead of the same ones, or besides; `-` takes one away.

"""


def commands() -> str:
    found = [e for e in PREDICTIONS if e.command]
    cells = [("id", "command", "what is read", "worse"), ("---",) * 4]
    cells += [(e.id, f"`{e.command}`", f"`{e.read}`", f"`{e.instead}`") for e in found]
    return "".join("| " + " | ".join(line) + " |\n" for line in cells)


def command_of(id: str) -> str:
    """As the page shows it."""
    lines = [cells(x) for x in PAGE.read_text(encoding="utf-8").splitlines() if x.startswith("| ")]
    (found,) = [c[1] for c in lines if len(c) == 4 and c[0] == id]
    return found.strip("`")


CHARTS = """\

## Accuracy against cost beside impacts and friction

`make pictures ONLY="chart_walled_pendulum.svg chart_touched_wall.svg chart_creep.svg"` draws these,
by `pkgen chart` of three of the models above. The reference is that of every chart: the same motion
in `__float128`, by another method too.

A wall that is struck (CO1). Every method keeps its order, for its steps end at impacts:

![A pendulum that a wall reflects](../../pictures/chart_walled_pendulum.svg)

A wall that is only touched (CO3). The steps of Verlet's method strike it, and its order falls to 1;
the other methods shown keep theirs:

![An oscillator that touches a wall](../../pictures/chart_touched_wall.svg)

Friction that is written as tanh (CO6, CO7). Explicit methods pay for their stability whatever the
accuracy, at least as many evaluations as their longest step allows; radau does not. The statement
`friction` has no such price:

![A block that creeps](../../pictures/chart_creep.svg)
"""


def sections() -> tuple[list[Prediction], ...]:
    """The list of regimes, and what is not in it."""
    return [e for e in PREDICTIONS if not e.own], [e for e in PREDICTIONS if e.own]


def text(known: dict[str, list[str]]) -> str:
    listed, own = sections()
    shown = sum(bool(e.command) for e in PREDICTIONS)
    missed = [e for e in PREDICTIONS if e.missed]
    met = sum(known[e.id][-1] == "met" for e in PREDICTIONS if e.id in known)
    said = [
        HEAD,
        f"Of {len(PREDICTIONS)} predictions {met} are met. Of {shown} the commands by which ",
    ]
    said += ["they are measured stand below.\n\n## Regimes\n\n", table(listed, known)]
    said += ["\n## More of them\n\n", "Predictions that are not in that list.\n\n"]
    said += [table(own, known), "\n## Commands\n\n", COMMANDS, commands(), CHARTS]
    said += ["\n## Misses\n\n"]
    said += [f"- **{e.id}**: {e.missed}\n" for e in missed] or ["None.\n"]
    said += ["\n## Without a worse method\n\n", WITHOUT, "| id | changed | why |\n", "| --- " * 3]
    said += ["|\n", *(f"| {e.id} | {e.worse} | {e.no_method} |\n" for e in without_method())]
    if MISSING:
        said.append("\n## Not written yet\n\n")
        said += [f"- **{m.id}**, {m.system}: {m.lacks}\n" for m in MISSING]
    return "".join(said)
