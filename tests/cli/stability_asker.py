"""What the tests of `pkgen stability` share: a model that is asked in process, a map of one."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

from conftest import case, ran, written
from pkgen.analysis.stability.ask import Asker, Point
from pkgen.compiler import compile_model
from pkgen.front.read import from_text
from pkgen.run.build import build_library
from pkgen.run.settings import Settings

PENDULUM = case("stability_asker_pendulum")


def asker(text: str, *, until: float = 100.0) -> Asker:
    compilation = compile_model(from_text("model.lag", text), unroll=None)
    program = build_library(compilation.files, compilation.model.name)
    settings = Settings(
        method="rk4",
        until=until,
        every=None,
        step=None,
        rtol=1e-10,
        atol=1e-10,
        iteration="newton",
        max_steps=10**9,
        max_step=None,
        parameters=(),
        members=(),
        inputs=(),
        start_q=(),
        start_v=(),
        show=(),
        at=None,
    )
    return Asker(program, settings)


def start(asked: Asker, q: float, v: float = 0.0) -> Asker:
    return asked.with_settings(replace(asked.settings, start_q=((0, q),), start_v=((0, v),)))


def point(asked: Asker, method: str, h: float) -> Point:
    asked.motion()
    return asked.point(method, h)


def mapped(folder: Path, text: str, *words: object) -> dict:
    """A quick map, as --json has it."""
    words = ("--quick", "--json", "-o", folder, *words)
    return json.loads(ran("stability", written(folder, text), *words).stdout)
