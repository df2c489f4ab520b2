"""Models for checkpoints, one of each way that a run is made, and what is common to their tests."""

import argparse
import random
from dataclasses import replace
from pathlib import Path
from unittest.mock import patch

import tomllib

from conftest import case
from pkgen.api.prepare import Prepared
from pkgen.cli.commands import parsed
from pkgen.cli.run import prepared
from pkgen.run.library import load

MODELS = tomllib.loads(Path(__file__).with_name("checkpoint_models.toml").read_text("utf-8"))
BLOCKS = case("blocks")  # integrated in two
UNTIL, ROWS, STEPS = 3.0, 37, 230
SECONDS = ("seconds", "processor")


def text(name: str) -> str:
    return f"model of_{name}\n{MODELS[name]}"


def of(name: str, folder: Path, *words: str) -> Prepared:
    """A model's run, compiled; without words, for every method."""
    path = folder / f"{name}.lag"
    path.write_text(text(name))
    with patch("pkgen.run.diagnostics.refuse_diagnostics"):  # none is made, below
        what = prepared(options(path, *(words or ("--diagnose", "modes"))))
    return replace(what, settings=replace(what.settings, diagnose=()))


def options(path: Path, *words: str) -> argparse.Namespace:
    return parsed(["run", str(path), *words])[1]


def methods(what: Prepared) -> list[str]:
    return [str(method["name"]) for method in load(what.library).methods()]


def by(what: Prepared, method: str, **more: object) -> Prepared:
    """The same by another method."""
    given = {"method": method, "until": UNTIL, "every": UNTIL / ROWS, "step": UNTIL / STEPS}
    settings = replace(what.settings, **{**given, "max_steps": 2000, "rtol": 1e-8, **more})
    return replace(what, settings=settings)


def run(what: Prepared, **more: object) -> tuple:
    """Code, rows, report but for its seconds, messages."""
    done = load(what.library).run(what.settings, None, what.ensemble, threads=2, **more)
    report = {k: v for k, v in done.report.items() if k not in SECONDS}
    return done.code, done.rows().tobytes(), report, done.messages


def chopped(what: Prepared, path: Path, dice: random.Random, most: int) -> tuple[tuple, int]:
    """The same, left after up to `most` steps at a time and gone on with; how often."""
    left = 0
    while True:
        after = {"checkpoint": bytes(path), "checkpoint_after": dice.randint(1, most)}
        found = run(what, **after, resume=int(left > 0))
        if found[0] != 75:
            path.unlink(missing_ok=True)
            return found, left
        left += 1
