"""Predictions that are measured by pkgen's commands alone, as the page shows them.

An entry has a command, to be run in tests/regimes/models, and what is read of its output: an
expression in the columns of the rows (x' is the rate of x), `t`, `report` (the JSON) and the
functions below. `instead` are options of the worse run, in place of the same ones or besides; `-`
takes one away. In `for h in 0.1 0.05; do ...; done` a command is run for each value; "power of h:
EXPRESSION" is the exponent by which what is read, h in it, goes with it. Between two values of h
"root of h: EXPRESSION" is where it is zero, "edge of h: EXPRESSION" from where on it is true: false
at the first, true at the second. Both are infinite where the ends do not differ.
"""

import json
import math
import re
import shlex
import tempfile
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from conftest import run_pkgen

from .prediction import Prediction, slope

HERE = Path(__file__).parent
MODELS = HERE / "models"
LOOP = re.compile(r"for (\w+) in ([^;]+); do (.+); done")
OVER = re.compile(r"(power|root|edge) of (\w+): (.+)")


def with_options(command: str, instead: str) -> str:
    """The command with these options, each with a value, in place of its own or besides."""
    words, changes = shlex.split(command), shlex.split(instead)
    for option, given in zip(changes[::2], changes[1::2], strict=True):
        assert option.startswith("--"), instead
        name = given.split("=")[0] + "=" if option in ("--set", "--start") else ""
        for i in range(len(words) - 1):
            if words[i] == option and words[i + 1].startswith(name):
                words[i : i + 2] = [option, given] if given != "-" else []
                break
        else:
            words += [option, given]
    return " ".join(w if re.fullmatch(r"[\w.$=+*/,-]+", w) else f'"{w}"' for w in words)


@cache
def outcome(command: str) -> dict[str, object]:
    """What a command leaves: its columns, and what it reports."""
    program, *words = shlex.split(command)
    assert program == "pkgen", command
    with tempfile.TemporaryDirectory() as folder:
        rows = Path(folder) / "rows.csv"
        done = run_pkgen(*words, "-o", rows if words[0] == "run" else folder, cwd=MODELS)
        found: dict[str, object] = {"exit_code": done.returncode, "said": done.stderr}
        if words[0] != "run":
            found["report"] = json.loads(done.stdout)
            return found
        if not rows.exists():  # of a run that failed
            rows = rows.with_suffix(".csv.partial")
        if not rows.exists():
            return found
        found["report"] = json.loads(Path(f"{rows}.json").read_text())["report"]
        head, *lines = rows.read_text().splitlines()
    numbers = np.array([[float(x) for x in line.split(",")] for line in lines])
    return found | dict(zip(map(identifier, head.split(",")), numbers.T, strict=True))


def identifier(column: str) -> str:
    return re.sub(r"\W+", "_", column.replace("'", "_rate"))


def times(report: dict, name: str) -> np.ndarray:
    """Those of an event or a switch."""
    (found,) = [e for e in (*report["events"], *report["switches"]) if e["name"] == name]
    return np.array(found["times"])


def errors(report: dict, low: float, high: float, *methods: str) -> np.ndarray:
    """Tolerances between these, or fixed steps, and the errors of these methods at them, of a
    chart."""
    points = [p for p in report["points"] if p["method"] in methods and p["error"] is not None]
    found = [(x, p["error"]) for p in points if low < (x := p["rtol"] or p["step"]) < high]
    if len(found) < 3:
        pytest.skip(f"the chart had no time for {methods[0]}: a machine with more to do")
    return np.array(found).T


def mapped(report: dict, kind: str, what: str = "measured") -> float:
    """What a map has of its first prediction of a kind."""
    return first([p[what] for p in report["predictions"] if p["kind"] == kind and p[what]])


def ghosts(report: dict, kind: str) -> list[tuple[float, np.ndarray]]:
    """Of a map: the step of each, and what its points have of the first state or coordinate."""
    found = [o for g in report["ghosts"] if g["kind"] == kind for o in g["orbits"]]
    return [(o["h"], np.array(o["states"])[:, -1]) for o in found]


def first(found: Sequence[float]) -> float:
    """Infinite if there is none."""
    return found[0] if len(found) else math.inf


NAMES = "abs sqrt log exp diff arctan2 hypot unwrap median sign max min mean sum cos sin polyfit"
FUNCTIONS = {name: getattr(np, name) for name in NAMES.split()}
FUNCTIONS |= {"acos": np.arccos, "pi": math.pi, "len": len, "int": int}
FUNCTIONS |= {
    "times": times,
    "first": first,
    "errors": errors,
    "slope": slope,
    "mapped": mapped,
    "ghosts": ghosts,
}


def read(command: str, expression: str, **more: float) -> float:
    text = re.sub(r"(\w+)'", lambda m: identifier(m[0]), expression)
    return float(eval(text, {"__builtins__": {}} | FUNCTIONS | outcome(command) | more))


def root(f: Callable[[float], float], low: float, high: float) -> float:
    """By regula falsi, the end that stays weighted down (M. Dowell, P. Jarratt, 1971)."""
    a, b = f(low), f(high)
    if a * b > 0:
        return math.inf
    for _ in range(12):
        x = (low * b - high * a) / (b - a)
        c = f(x)
        if b * c < 0:
            low, a = high, b
        else:
            a *= 0.5
        high, b = x, c
        if c == 0 or abs(high - low) < 1e-9 * abs(high):
            break
    return high


def edge(true: Callable[[float], float], low: float, high: float, bits: int = 3) -> float:
    if true(low) or not true(high):
        return math.inf
    for _ in range(bits):
        middle = (low + high) / 2
        low, high = (low, middle) if true(middle) else (middle, high)
    return (low + high) / 2


def value(command: str, expression: str) -> float:
    loop = LOOP.fullmatch(command)
    if not loop:
        return read(command, expression)
    name, values, body = loop.groups()
    kind, over, expression = OVER.fullmatch(expression).groups()
    assert over == name, expression
    at = [float(x) for x in values.split()]
    if kind != "power":
        way = {"root": root, "edge": edge}[kind]
        return way(lambda x: read(body.replace(f"${name}", f"{x:.12g}"), expression), *at)
    given = [(x, {name: float(x)}) for x in values.split()]
    return slope(at, [read(body.replace(f"${name}", x), expression, **v) for x, v in given])


def worse_command(command: str, instead: str) -> str:
    loop = LOOP.fullmatch(command)
    if not loop:
        return with_options(command, instead)
    return command.replace(loop[3], with_options(loop[3], instead))


def around(limit: float) -> str:
    """The ends of a loop: where a motion is to be stable still, and to grow."""
    return f"{0.999 * limit:.9g} {1.001 * limit:.9g}"


def shown(
    id: str,
    system: str,
    says: str,
    predicted: float | tuple[float, float],
    tolerance: float,
    command: str,
    read: str,
    instead: str,
    own: bool = True,
    **more,
) -> Prediction:
    worse = re.sub(r"^--methods? (\w+) ?", r"\1, ", instead).removesuffix(", ")
    return Prediction(
        id, system, says, predicted, tolerance,
        lambda: value(command, read), worse, lambda: value(worse_command(command, instead), read),
        own=own, command=command, read=read, instead=instead, **more,
    )  # fmt: skip


def listed(*entry, **more) -> Prediction:
    """One of the list of regimes."""
    return shown(*entry, own=False, **more)
