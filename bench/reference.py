"""Final states known well beyond double precision, by c/reference.c in __float128.

Checked twice: against the 25 digits of tests/models/references.json, and for every start against
fewer, larger steps of the same method. Parameters and starts are the doubles that the contenders
have; the published digits are for decimal numbers, so that check is run with those.
"""

from __future__ import annotations

import subprocess
from decimal import Decimal, localcontext
from pathlib import Path

from . import codegen
from .builds import SOURCES, Build, compile_program, written
from .models import REFERENCES, Model

# Big steps a second of motion.
STEPS_A_SECOND = {"double_pendulum": 80, "heavy_top": 32}
USUAL_STEPS_A_SECOND = 16
MUST_AGREE = Decimal("1e-18")


class ReferenceError(Exception):
    """Reference and check differ: nothing can be compared."""


def finals(model: Model, starts: list[tuple[float, ...]]) -> list[list[float]]:
    """The state at t_end for each start, right to double precision."""
    program = _program(model.name, codegen.acceleration(model, "real"))
    numbers = REFERENCES[model.name]
    given = [*numbers["params"].values(), *numbers["y0"]]
    published = _run(program, _steps(model, model.t_end), model.t_end, given)
    _must_agree(published, [Decimal(x) for x in model.final], model.name)
    return finals_at(model, starts, model.t_end)


def finals_at(model: Model, starts: list[tuple[float, ...]], t_end: float) -> list[list[float]]:
    """The same at another time, for which nothing is published."""
    text = codegen.acceleration(model, "real")
    return finals_by(model, text, starts, t_end, _steps(model, t_end))


def finals_by(
    model: Model, text: str, starts: list[tuple[float, ...]], t_end: float, steps: int
) -> list[list[float]]:
    """Of equations that are given in C, a start being q and q'."""
    program, found = _program(model.name, text), []
    for start in starts:
        given = [x.hex() for x in (*model.values, *start)]
        exact = _run(program, steps, t_end, given)
        _must_agree(exact, _run(program, steps * 3 // 4, t_end, given), model.name)
        found.append([float(x) for x in exact])
    return found


def _steps(model: Model, t_end: float) -> int:
    return max(4, round(STEPS_A_SECOND.get(model.name, USUAL_STEPS_A_SECOND) * t_end))


def _program(name: str, text: str) -> Path:
    header = written(f"reference/{name.replace(' ', '-')}.h", text)
    return compile_program(
        Build("gcc", ("-O2",)),
        [SOURCES / "reference.c"],
        {"BENCH_EQUATIONS": f'"{header}"'},
        ("-std=gnu11",),
        ("-lquadmath",),
    )


def _run(program: Path, steps: int, t_end: float, numbers: list[str]) -> list[Decimal]:
    command = [program, str(steps), repr(t_end), *numbers]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return [Decimal(x) for x in done.stdout.split()]


def _must_agree(one: list[Decimal], other: list[Decimal], name: str) -> None:
    with localcontext() as context:
        context.prec = 40
        worst = max(abs(a - b) / max(Decimal(1), abs(b)) for a, b in zip(one, other, strict=True))
    if not worst < MUST_AGREE:
        raise ReferenceError(f"{name}: the reference and its check differ by {worst:.1e}")
