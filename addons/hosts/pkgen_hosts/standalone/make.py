"""Makes the standalone exports: one C file; a folder for firmware; an Arduino library."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from pkgen.back.c.ctext import string
from pkgen.back.exported import Exported, Host
from pkgen.back.templates import filled
from pkgen.system.exits import UsageError

from .step import HERE, KERNELS, Step, places

OPTIONS: tuple[tuple[str, dict[str, Any]], ...] = (
    (
        "--scalar",
        {
            "choices": ("double", "float"),
            "help": "the type of its numbers: double, of firmware float",
        },
    ),
    ("--no-libm", {"action": "store_true", "help": "angles up to 1.5e6 (float: 1.5e3), no libm"}),
)
EVERY: tuple[tuple[str, dict[str, Any]], ...] = (
    ("--every", {"metavar": "DT", "help": "time between rows"}),
)


def how(options: object) -> dict[str, object]:
    """Returns compiler options for the exports: families are unrolled; of the kernels, only those
    for steps and for rows are generated."""
    return {"kernels": KERNELS}


def how_single(options: object) -> dict[str, object]:
    """Returns the options of how(), with the kernel of event functions, which main() needs."""
    return {"kernels": KERNELS | {"event"}}


def _sources(step: Step) -> dict[str, str]:
    name = step.name
    return {
        f"{name}.h": step.header,
        f"{name}.c": step.source,
        f"{name}_step.h": step.step_header(f'#include "{name}.h"\n'),
        f"{name}_step.c": f'#include "{name}_step.h"\n\n{step.step_source}',
    }


def freestanding(model: Exported) -> dict[str, bytes]:
    return {path: text.encode() for path, text in _sources(Step(model, "float")).items()}


def single(model: Exported) -> dict[str, bytes]:
    step = Step(model, "double", has_main=True)
    source = step.source.replace(f'#include "{step.name}.h"\n', "", 1)
    parts = [step.header, source, step.step_header(""), step.step_source, _main(step)]
    return {f"{step.name}_single.c": "\n".join(parts).encode()}


def arduino(model: Exported) -> dict[str, bytes]:
    step = Step(model, "float")
    name = step.name
    place, first = places(model.description)[0]
    context = {
        "name": name,
        "says": model.description["description"] or model.description["title"],
        "step": step.number(model.description["run"]["step"]),
        "first": first["name"],
        "place": place,
    }
    files = {f"src/{path}": text for path, text in _sources(step).items()}
    for path in ("library.properties", "library.json"):
        files[path] = filled(HERE, f"{path}.j2", **context)
    files[f"examples/{name}/{name}.ino"] = filled(HERE, "sketch.ino.j2", **context)
    return {path: text.encode() for path, text in files.items()}


def _intervals(whole: float, part: float, words: str) -> int:
    """Returns the number of parts in a whole. Raises UsageError if it is not an integer up to
    round-off."""
    count = round(whole / part)
    if count < 1 or abs(whole / part - count) > 1e-9 * count:
        raise UsageError(f"{words}: give whole multiples")
    return count


def _main(step: Step) -> str:
    of, name = step.of, step.name
    run = of["run"]
    h, every, until = run["step"], run["every"], run["until"]
    per_row = _intervals(every, h, f"rows every {every:g} s by steps of {h:g} s")
    # The runtime's step is exactly the double `every / per_row`; `h` may differ from it by
    # round-off.
    h = every / per_row if abs(every / per_row - h) <= 1e-12 * h else h
    count = max(1, math.ceil(until / every * (1 - 1e-12)))
    rest = until - (count - 1) * every
    last = _intervals(rest, h, f"a duration of {until:g} s by steps of {h:g} s")
    shown = [(f"m->{place}", y["name"]) for place, y in places(of)]
    outputs = [(f"y[{y['index']}]", y["name"]) for y in of["outputs"] if not y["hidden"]]
    u = "m->u" if of["inputs"] else "NULL"
    if f"{name}_energy(" in step.source:
        outputs.append((f"{name}_energy(&m->p, m->t, m->q, m->v, {u})", "energy"))
    shown += outputs
    labels = ["t", *(label for _, label in shown)]
    return filled(
        HERE,
        "main.c.j2",
        name=name,
        u=u,
        digits=9 if step.float else 17,
        n_outputs=sum(not y["hidden"] for y in of["outputs"]),
        columns=[value for value, _ in shown],
        head=[string(f"{',' if k else ''}{label}") for k, label in enumerate(labels)],
        h=step.number(h),
        every=repr(float(every)),
        until=step.number(until),
        count=f"{count}ul",
        per_row=per_row,
        last=last,
        stops=step.stops,
        events=[string(event["name"]) for event in of["events"]],
    )


SINGLE = Host(
    "single",
    "one C file: the model, one method, a program that prints rows",
    single,
    ".c",
    (*OPTIONS, *EVERY),
    how=how_single,
    warnings=lambda model: Step(model, "double", has_main=True).missed,
)


def _firmware(name: str, doc: str, make: Callable[[Exported], dict[str, bytes]]) -> Host:
    missed = lambda model: Step(model, "float").missed  # noqa: E731
    return Host(name, doc, make, options=OPTIONS, how=how, warnings=missed)


FREESTANDING = _firmware(
    "freestanding", "the model and the step of one method for firmware", freestanding
)
ARDUINO = _firmware("arduino", "an Arduino and PlatformIO library with a sketch", arduino)
