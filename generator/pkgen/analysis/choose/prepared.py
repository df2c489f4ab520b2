"""A program of all candidates for a system, by which choices are made."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

from ...record import record
from ...run.build import build_library
from ...run.settings import Settings
from ..chart.chart import methods as all_methods
from . import reference
from .candidates import Candidate, candidates
from .choice import Choice
from .choose import choose
from .reference import Task
from .trials import LAND, Trials


@record
class Prepared:
    program: Path
    methods: tuple[str, ...]  # that are fastest in it
    seconds: float  # that it took to compile
    able: tuple[Candidate, ...]
    exact: tuple[str, ...]
    damped: bool
    timed: bool

    @staticmethod
    def of(
        files: dict[str, str], name: str, structure: object, *, land: bool, events: bool = False
    ) -> Prepared:
        """`land`: rows are where steps end. Raises BuildError."""
        began = time.perf_counter()
        able = candidates(structure, all_methods(None))  # of the runtime, which is compiled first
        methods = tuple(dict.fromkeys(c.name for c in able))
        program = build_library(files, name, *methods)
        return Prepared(
            program,
            methods,
            time.perf_counter() - began,
            tuple(c for c in able if c.rows == LAND or not land),
            reference.methods(structure, events),
            not getattr(structure, "variational", False),
            not getattr(structure, "autonomous", True),
        )

    def only(self, method: str) -> Prepared:
        return replace(self, able=tuple(c for c in self.able if c.name == method))

    def choose(self, settings: Settings, accuracy: float) -> Choice:
        trials = Trials(self.program, settings)
        found = choose(Task(trials, self.able, self.exact, self.damped, accuracy, self.timed))
        return replace(found, compile_seconds=self.seconds)
