"""Prepares a run from options: compiles the model, computes settings, chooses a method."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

from ..compiler import Compilation
from ..middle.refused import refuse_statements
from ..model import Scene
from ..own.given import taken
from ..record import record
from ..run import diagnostics, rows
from ..run.ensemble import Ensemble
from ..run.simulate import Runnable, build
from ..scenes import check as scene_check
from ..scenes import compile_plan as scene_use
from ..scenes import lengths, scene
from ..scenes import run as scene_run
from ..scenes import run_settings as parsing
from ..scenes.judge import Verdict
from . import chosen as already


@record
class Prepared(Runnable):
    """A prepared run, and its scene or None."""

    scene: Scene | None = None
    notes: tuple[str, ...] = ()  # messages to print before the run
    chosen: dict[str, Any] | None = None  # method and settings chosen for the scene's accuracy

    @property
    def spaced(self) -> bool:
        """Whether an option or the scene sets the time between rows."""
        record = self.scene and self.scene.record
        given = self.compilation.plan.numbers.every
        return given is not None or bool(record and record.every)

    def verdicts(self, report: dict) -> list[Verdict]:
        """Returns the verdicts on the scene's expectations, from the report of the run."""
        if self.scene is None or not report:
            return []
        made = self.compilation, self.scene, self.settings
        return scene_run.verdicts(*made, report, self.ensemble)

    def built(self) -> Prepared:
        """Builds the model's library; returns the run with it. Raises BuildError."""
        return replace(self, library=build(self.compilation, self.settings, self.ensemble))


def prepare(
    options: argparse.Namespace,
    compiled: Callable[..., Compilation],
    table: Callable[[Compilation], Ensemble] | None = None,
    kept: dict[str, Any] | None = None,
) -> Prepared:
    """Prepares a run. `compiled(options, **how)` compiles the model; `table` returns an
    ensemble that is not in a file; `kept` is Prepared.chosen of a run that is resumed. Raises
    UsageError, ModelError, BuildError or NumericsFailed."""
    options = taken(options)
    swarm = scene_run.is_swarm(options)
    several = swarm or options.ensemble is not None
    asked = diagnostics.asked(options.diagnose, options.ensemble)
    compilation = compiled(
        options,
        libm=options.libm,
        portable=options.portable,
        unroll=lengths.unroll(options, several),
        kernels=diagnostics.kernels(asked),
        use=scene_use.of_run(options),
    )
    diagnostics.refuse(asked, compilation, several)
    chosen = scene.of(options, compilation.declared)
    if chosen is not None:
        scene_check.refuse(options, compilation, chosen)
    threads = parsing.threads(options, several)
    ensemble, count = None, None
    if chosen is not None and swarm:
        scene_run.refuse_swarm(options, compilation.declared, chosen)
        count = scene_run.count(compilation.declared, chosen)
    elif options.ensemble is not None:
        from ..run import members_file  # imports NumPy

        read = table or partial(members_file.read, options.ensemble)
        ensemble = read(compilation)
        count = len(ensemble.lines)
    settings = parsing.settings(options, compilation, count, chosen)
    if chosen is not None:
        if swarm:
            ensemble = scene_run.members(options, compilation, chosen, settings)
        expected = scene_run.watched(compilation, chosen, settings, several)
        settings = replace(settings, watched=expected)
    if several:
        settings = replace(settings, watch=scene_run.watch(compilation, chosen, settings))
    notes = []
    if chosen is not None and chosen.accuracy is not None and settings.accuracy is None:
        notes.append(f"pkgen: {scene_check.NOT_PROMISED}")
    if settings.accuracy is not None and kept is not None:
        settings = already.settled(settings, kept.get("settings"))
    elif settings.accuracy is not None:
        from ..analysis import choose

        refuse_statements(compilation.declared, "accuracy")
        choices = choose.chosen(compilation, settings, ensemble)
        settings = choose.with_choices(settings, choices)
        time = "" if compilation.model.dimensionless else "s"
        for choice in choices:
            notes += choose.lines(choice, time, options.json)
        said = [choose.record(choice) for choice in choices]
        kept = {"settings": already.data(settings), "said": said}
    if note := rows.note(settings, compilation):
        notes.append(f"pkgen: {note}")
    if names := ", ".join(parsing.unread(options, compilation)):
        why = f"no effect: nothing that scene '{options.scene}' needs reads it"
        notes.append(f"pkgen: --set {names}: {why}")
    made = compilation, settings, ensemble, threads
    more = {"scene": chosen, "notes": tuple(notes), "chosen": kept}
    if {"modes", "all"}.intersection(settings.diagnose):
        from ..analysis.linear.normal import complete

        more["complete"] = complete
    return Prepared(*made, **more)
