"""Compiles the program that runs the trials, with all candidates for a system."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

import numpy

from ...record import record
from ...run.build import build_library
from ...run.settings import Settings
from ..chart import wide
from ..chart.chart import methods as all_methods
from . import reference
from .candidates import Candidate, candidates
from .choice import Choice
from .choose import choose
from .reference import Task
from .trials import LAND, Trials

WIDE = 63  # a type with fewer mantissa bits does not count as wider than double


@record
class Prepared:
    program: Path
    files: dict[str, str]
    name: str
    methods: tuple[str, ...]  # methods whose steps are inlined
    seconds: float  # how long the compilation took
    able: tuple[Candidate, ...]
    exact: tuple[str, ...]
    damped: bool
    timed: bool

    @staticmethod
    def of(
        files: dict[str, str], name: str, structure: object, *, land: bool, events: bool = False
    ) -> Prepared:
        """Compiles the program. With `land`, it has only methods whose steps end at the times of
        rows. Raises BuildError."""
        began = time.perf_counter()
        able = candidates(structure, all_methods(None))  # compiles the runtime
        methods = tuple(dict.fromkeys(c.name for c in able))
        exact = reference.methods(structure, events)
        program = build_library(files, name, *methods, able=("gauss", *exact))
        return Prepared(
            program,
            files,
            name,
            methods,
            time.perf_counter() - began,
            tuple(c for c in able if c.rows == LAND or not land),
            exact,
            not getattr(structure, "variational", False),
            not getattr(structure, "autonomous", True),
        )

    def only(self, method: str) -> Prepared:
        return replace(self, able=tuple(c for c in self.able if c.name == method))

    def choose(self, settings: Settings, accuracy: float) -> Choice:
        trials = Trials(self.program, settings)
        of = self.able, self.exact, self.damped, accuracy, self.timed
        asked = Task(trials, *of, lambda: self._precise(trials))
        return replace(choose(asked), compile_seconds=self.seconds)

    def _precise(self, trials: Trials) -> Trials | None:
        """Returns trials in a scalar type wider than double, from the same start; None if no
        compiler supports such a type."""
        quick = numpy.finfo(numpy.longdouble).nmant >= WIDE
        types = ["long double" if quick else "__float128"]
        found = wide.library(self.files, self.name, ("gauss", *self.exact), types)
        return found and Trials(found[0], trials.given())
