"""The data that workers need to integrate members: the model's library, the settings of the run,
the starts of the members, and the quantities to keep.

A Job is made once, on the machine that starts the sweep, and is sent to the workers.
"""

from __future__ import annotations

import argparse
import hashlib
import json
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

from pkgen import limits
from pkgen.api.prepare import Prepared, prepare
from pkgen.compiler import Compilation
from pkgen.equations import Quantity
from pkgen.methods import Own
from pkgen.record import record
from pkgen.run import diagnostics
from pkgen.run import rows as run_rows
from pkgen.run.build import build_library
from pkgen.run.ensemble import Ensemble
from pkgen.run.library import Library, load
from pkgen.run.settings import Settings
from pkgen.scenes import compile_plan as scene_use
from pkgen.system.exits import INTERRUPTED, USAGE, NumericsFailed, UsageError
from pkgen.system.near import near
from pkgen.version import __version__

from . import axes
from .plan import Plan
from .reductions import Kept, NotThere, by_row, kept
from .sampling import Starts

if TYPE_CHECKING:
    import numpy

BATCH = 1 << 16  # Most members of a batch.
BATCH_BYTES = 1 << 25  # Most bytes of the rows of a batch.
PART = 1 << 20  # Approximate rows per file of the data set.
AT_START = "(0)"  # Suffix of the columns of sampled coordinates and rates.
SAMPLE = 64  # The method is chosen from the motions of this many members.


class Batch(NamedTuple):
    """Results of a batch of members: for each member, the status, the last valid time and the kept
    numbers; and the kept rows over time."""

    members: numpy.ndarray
    rows: numpy.ndarray | None  # columns: member, t, ...
    report: dict


@record
class Refine:
    """Settings of a refinement: finer grids near the boundary between classes of members."""

    levels: int
    column: str  # the column of the data set whose values are the classes of members


@record
class Job:
    name: str
    digest: str  # hash of plan, model and version of pkgen
    files: dict[str, str]
    # Integration methods that are compiled with the model, their steps inlined.
    methods: tuple[str, ...]
    # Compiler options, for the shared library and for the program without Python.
    build: dict[str, object]
    settings: Settings
    starts: Starts
    kept: Kept
    time_unit: str
    counts: Quantity  # column with the numbers of the members
    refine: Refine | None
    before: int = 0  # in a refined grid: number of members of all coarser levels

    @cached_property
    def library(self) -> Library:
        """The compiled library of the model, from the cache if possible. Raises BuildError."""
        diagnose = any(what == b"l" for what, _ in self.kept.reduced)
        return load(
            build_library(self.files, self.name, *self.methods, **self.build, diagnose=diagnose)
        )

    def __getstate__(self) -> dict[str, object]:
        return {name: x for name, x in self.__dict__.items() if name != "library"}

    @property
    def members(self) -> int:
        return self.starts.members

    @property
    def rows_each(self) -> int:
        """The approximate number of rows per member."""
        every, until = self.settings.every, self.settings.until
        return max(1, round(until / every) + 1) if every else 1

    @property
    def part(self) -> int:
        """The number of members per file of the data set. The number depends on the plan only, not
        on the engine."""
        return max(1, PART // (self.rows_each if self.kept.rows else 1))

    @property
    def number_bytes(self) -> int:
        """The approximate number of bytes per member on disk."""
        own = 2 + len(self.kept.numbers) + len(self.starts.axes)
        return 8 * (own + self.rows_each * (len(self.kept.rows) + 1) * bool(self.kept.rows))

    def batch(self) -> int:
        wide = self.rows_each * (len(self.settings.show) + 2) if self.kept.rows else 16
        most = max(1, min(BATCH, BATCH_BYTES // (8 * wide)))
        # Members are integrated together in SIMD lanes; a multiple of 64 fills all lanes.
        return most - most % 64 if most > 64 else most

    def run(
        self, first: int, count: int, poll: Callable[[float], bool] | None = None
    ) -> Iterator[Batch]:
        """Integrates `count` members from `first` (from 0), batch by batch. Raises UsageError if
        none can be run, KeyboardInterrupt if `poll` stops it."""
        size = self.batch()
        for begin in range(first, first + count, size):
            of = min(size, first + count - begin)
            done = (begin - first) / count
            part = (lambda x, d=done, n=of: poll(d + x * n / count)) if poll else None
            yield self._batch(begin, of, part)

    def _batch(self, first: int, count: int, poll: Callable[[float], bool] | None) -> Batch:
        number = self.before + first + 1
        numbers = range(number, number + count)
        values = self.starts.values(first, count)
        ensemble = Ensemble("sweep", self.starts.columns, numbers, values)
        more = {"reduced": self.kept.reduced, "no_rows": not self.kept.rows, "lenient": 1}
        library = self.library
        done = library.run(self.settings, poll, ensemble, threads=1, first_member=number, **more)
        if done.code == INTERRUPTED:
            raise KeyboardInterrupt
        found = done.members()
        if done.code == USAGE or len(found) != count:
            raise NumericsFailed(done.messages.strip() or "the members could not be run")
        rows = done.rows() if self.kept.rows else None
        done.close()
        return Batch(found, rows, done.report)


def make(
    plan: Plan,
    options: argparse.Namespace,
    compiled: Callable[..., Compilation],
    chosen: dict[str, object] | None = None,
) -> tuple[Job, Prepared]:
    """Makes the job. When a sweep is resumed, `chosen` is the method that was chosen for the
    scene's accuracy when the sweep began; no other method is then chosen. Raises UsageError,
    ModelError, BuildError or NumericsFailed."""
    options = plan.of_a_run(options)
    try:
        return _make(plan, options, compiled, chosen)
    except NotThere:
        if options.scene is None or options.no_reduce is not None:
            raise
        options.no_reduce = "all"
        return _make(plan, options, compiled, chosen)


def _make(
    plan: Plan,
    options: argparse.Namespace,
    compiled: Callable[..., Compilation],
    chosen: dict[str, object] | None,
) -> tuple[Job, Prepared]:
    options.ensemble = str(plan.source.path)
    found: dict[str, Starts] = {}

    def sample(compilation: Compilation) -> Ensemble:
        """Returns the first members, from which the settings are determined."""
        made = found["starts"] = axes.starts(plan, compilation)
        count = min(SAMPLE, made.members)
        values = made.values(0, count)
        return Ensemble(options.ensemble, made.columns, range(1, count + 1), values)

    def of_keep(options: argparse.Namespace, **how: object) -> Compilation:
        """Compiles the model. If the plan keeps Lyapunov exponents, the model gets the kernels that
        compute them."""
        if "lyapunov" in plan.keep:
            how["kernels"] = diagnostics.kernels(("lyapunov",))
            single = argparse.Namespace(**{**vars(options), "diagnose": "lyapunov"})
            how["use"] = scene_use.of_run(single)
        return compiled(options, **how)

    try:
        prepared = prepare(options, of_keep, sample, chosen)
    except UsageError as error:
        raise UsageError(_of_plan(plan, str(error))) from None
    compilation, settings = prepared.compilation, prepared.settings
    if compilation.declared.noises:
        settings = replace(settings, seed=plan.seed)
    if by_row(plan) and settings.every is None and settings.at is None:
        numbers = len(settings.show) or 1
        settings = replace(
            settings, every=run_rows.interval(settings.until, settings.step, numbers)
        )
    keeping, settings = kept(plan, compilation, settings, prepared.scene)
    own: tuple[Own, ...] = compilation.model.methods
    model = compilation.model
    made_of = (__version__, plan.source.text, model.source.sha256, repr(own), options.size)
    job = Job(
        name=model.name,
        digest=hashlib.sha256(json.dumps(made_of).encode()).hexdigest(),
        files=compilation.files,
        methods=settings.methods,
        build={"ensemble": True, "parts": compilation.blocks, "own": own},
        settings=settings,
        starts=found["starts"],
        kept=keeping,
        time_unit="" if model.dimensionless else "s",
        counts=Quantity("member", "", "number of the member, from 1"),
        refine=_refine(plan, found["starts"], keeping),
    )
    return job, prepared


def _refine(plan: Plan, starts: Starts, keeping: Kept) -> Refine | None:
    if not plan.refine:
        return None
    where, levels = plan.refine["where"], plan.refine["levels"]
    if plan.kind != "grid" or any(x.values or x.points < 2 for x in starts.axes):
        raise plan.wrong(
            "refine", "", "what is refined is a [grid] of ranges, of two points or more"
        )
    kinds = zip(keeping.reduced, keeping.numbers, strict=True)
    classes = ["status", *(c.name for (what, _), c in kinds if what in b"nx")]
    if where not in classes:
        said = near(where, classes, "column")
        help = "a class is status, or of what is kept a count(EVENT) or an expect"
        raise plan.wrong("refine", "where", f"'{where}' has no classes; {said}", help)
    if starts.members > limits.SWARM:
        most = f"{limits.SWARM:,}"
        raise plan.wrong(
            "refine", "", f"a grid that is refined has {most} members at first, at most"
        )
    return Refine(levels, where)


def _of_plan(plan: Plan, said: str) -> str:
    """Rewrites an error about an option of `pkgen run`, so that it refers to the plan."""
    for key in plan.options:
        option = f"--{key.replace('_', '-')} "
        if said.startswith(option):
            inner = said.removeprefix(option)
            return str(plan.wrong("", key, f"{key} {inner}"))
    return said.replace(f"--ensemble {plan.source.path}: ", f"{plan.source.path}: ")
