"""Builds a Model from a file's statements and reports all semantic errors in one run: names, kinds,
bounds, units.

This file has the order of the checks and the limit of reported errors. The other files of this
folder check the statements, `check/expr.py` expressions, `check/indices.py` indices.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache

from ... import limits
from ... import model as m
from ...record import record
from ...source import Diagnostic, ModelError, Source, Span
from ...tree import names
from .. import statements as st
from ..declarations import declarations
from ..joints import loose
from ..parse import parse_all
from ..table import STATEMENTS
from ..units import NONE, over, parsed, si_text
from ..words import CONSTANTS
from .bodies import Bodies
from .body_families import indices, written_out
from .constraints import Constraints
from .contacts import Contacts
from .coordinates import Coordinates
from .definitions import Definitions
from .drawings import Drawings
from .dynamics import Dynamics
from .expr import Expressions
from .forces import Forces
from .methods import Methods
from .names import UNKNOWN, Entry, Names, Report
from .params import check_bounds
from .required import Required
from .rotation_statements import coordinates_of, identity, states_of
from .samples import Samples, check_times
from .scene_values import check_scene_values
from .scenes import Scenes
from .shared import Checks, Shared
from .states import States
from .tables import Tables

_INERTIA = ("kinetic", "potential", "lagrangian")


def check_text(
    source: Source, sizes: Mapping[str, int] = {}
) -> tuple[m.Model, tuple[Diagnostic, ...]]:
    """Returns the model and the warnings of a text; raises one ModelError with all errors."""
    return check(parse_all(source), sizes)


def check(file: st.File, sizes: Mapping[str, int] = {}) -> tuple[m.Model, tuple[Diagnostic, ...]]:
    """Returns the model and its warnings; `sizes` are set on the command line. A model that reads a
    file is not cached, since the file may change."""
    given = tuple(sorted(sizes.items()))
    every = (x for s in file.statements for x in (s, *getattr(s, "clauses", ())))
    brings = any(isinstance(x, st.Method | st.Table) and x.file for x in every)
    return (_checked.__wrapped__ if brings else _checked)(file, given)


@record(eq=False)
class Seen:
    """The result of checking a file; `model` is None after an error."""

    model: m.Model | None
    names: Names
    parts: Mapping[str, list]  # Results of the checks, by name of a field of Model.
    sizes: Mapping[str, int]
    errors: tuple[Diagnostic, ...]  # Sorted by position in the file, without duplicates.
    warnings: tuple[Diagnostic, ...]


def see(file: st.File, sizes: Mapping[str, int] = {}) -> Seen:
    checker = _Checker(file, dict(sizes))
    model = checker.run()
    found = [*file.diagnostics, *checker.report.errors]
    known = checker.names, checker.parts, checker.sizes
    findings = (_distinct(file.source, x) for x in (found, checker.report.warnings))
    return Seen(model, *known, *findings)


def _distinct(source: Source, found: list[Diagnostic]) -> tuple[Diagnostic, ...]:
    """Returns the findings by position, without duplicates. In a file that is used as several parts
    only the findings of the first part count."""
    unique: dict[object, Diagnostic] = {}
    for d in sorted(found, key=lambda d: d.span.start):
        part, at, message = source.piece(d.span.start).part, d.span.start, d.message
        key = (source.place(d.span), message.replace(part, "")) if part else (at, message)
        unique.setdefault((*key, d.span.end - at), d)
    return tuple(unique.values())


@lru_cache(maxsize=4)  # A command may compile a file once for each of its scenes.
def _checked(file: st.File, sizes: tuple) -> tuple[m.Model, tuple[Diagnostic, ...]]:
    seen = see(file, dict(sizes))
    if seen.errors:
        shown = [*seen.errors[: limits.DIAGNOSTICS]]
        raise ModelError(file.source, shown, more=len(seen.errors) - len(shown))
    return seen.model, seen.warnings


class _Checker(Checks):
    def __init__(self, file: st.File, given: Mapping[str, int]) -> None:
        report = Report()
        counted = (expr for s in file.statements for expr in indices(s))
        # Names that occur in indices of bodies or joints.
        self.counting = frozenset().union(*map(names, counted))
        taken = {*(name for name, *_ in declarations(file.statements)), *CONSTANTS}
        self.file = file = written_out(file, given, taken, report.error)
        self.broken = {b.keyword for b in file.broken}
        units = map(parsed, file.units)
        self.dimensionless = all(unit and unit.dimension == NONE for unit in units)
        known = Names(report, self._line, [*declarations(file.statements)])
        for name in (n for b in file.broken for n in b.names):
            known.table[name] = Entry(name, "poisoned", UNKNOWN, Span(0, 0))
        known.parts = file.source.parts
        known.hamiltonian = any(s.keyword == "hamiltonian" for s in file.statements)
        bodies = [s.name for s in file.statements if isinstance(s, st.Body)]
        known.loose = loose(bodies, [s for s in file.statements if isinstance(s, st.Joint)])
        expressions = Expressions(file.source, report, known, {}, dimensionless=self.dimensionless)
        super().__init__(Shared(expressions, dict(given)))
        self.states, self.dynamics = States(self.shared), Dynamics(self.shared)
        self.bodies = Bodies(self.shared, self._check, file)
        self.methods, self.tables = Methods(self.shared), Tables(self.shared)
        self.scenes = Scenes(self.shared, self.dynamics, self.methods)
        self.checks = {
            "definitions": Definitions(self.shared),
            "states": self.states,
            "coordinates": Coordinates(self.shared, self.states, self.dynamics.rotations),
            "dynamics": self.dynamics,
            "forces": Forces(self.shared, self.dynamics.rotations),
            "constraints": Constraints(self.shared),
            "contacts": Contacts(self.shared),
            "bodies": self.bodies,
            "drawings": Drawings(self.shared),
            "methods": self.methods,
            "tables": self.tables,
            "exacts": self.scenes.exacts_of,
            "samples": Samples(self.shared),
            "scenes": self.scenes,
        }

    def _line(self, span: Span) -> int | str:
        source = self.file.source
        line, piece = source.position(span.start)[0], source.piece(span.start)
        return f"{line} of {piece.path}" if piece.part else line

    def run(self) -> m.Model:
        self._clashes()
        for statement in self.file.statements:
            if not isinstance(statement, st.Scene):
                self._check(statement)
        if not self.broken & {"", "body", "joint"}:
            self.bodies.finish()
        for statement in self.file.statements:
            if isinstance(statement, st.Scene):  # Scenes are checked last: all names are known.
                self._check(statement)
        self.indices.finish()
        self.tables.finish(self.broken)
        if "rate" not in self.broken:
            self.states.finish()
        if not self.broken:
            self.checks["contacts"].finish()
        required = Required(self.file, self.shared, self.broken)
        required.check()
        parts = self.parts
        both = parts["parameters"], parts["definitions"]
        sound = ([x for x in items if x.span in self.sound] for items in both)
        check_bounds(*sound, self.sizes, self.report, self.file.source.order)
        if not self.broken & {"", "let", "coord", "body", "joint", *_INERTIA}:
            required.inertia()
        misfits = self._misfits()
        if not self.report.errors and not self.file.diagnostics:
            self._unused()
        model = self._model()
        if model is None:
            return None
        for scene in model.scenes:
            if scene.listed:  # One of a part is checked when it is chosen.
                check_scene_values(model, scene, self.report)
        check_times(model, self.report)
        for name, errors in self._misfits().items():
            misfits.setdefault(name, []).extend(errors)
        scenes = (replace(s, misfits=tuple(misfits.get(s.name, ()))) for s in model.scenes)
        return replace(model, scenes=tuple(scenes))

    def _misfits(self) -> dict[str, list[Diagnostic]]:
        """Removes the errors of scenes of parts from the report and, if the command line sets
        sizes, those of all scenes. Returns them by name of scene: a scene may be wrong with these
        sizes or this user alone. The errors of a scene are reported if the scene is run."""
        found: dict[str, list[Diagnostic]] = {}
        scenes = [s for s in self.file.statements if isinstance(s, st.Scene)]
        for scene in scenes:
            if not (self.given_sizes or self.file.source.piece(scene.span.start).part):
                continue
            start, end = scene.span.start, scene.span.end
            mine = [e for e in self.report.errors if start <= e.span.start < end]
            if mine:
                found[scene.name] = mine
                self.report.errors = [e for e in self.report.errors if e not in mine]
        return found

    def _clashes(self) -> None:
        """Reports names that are the same in C as those of parts, such as left_x and left.x."""
        parts, found = self.file.source.parts, {}
        for name, span, _ in declarations(self.file.statements) if parts else ():
            part = name.rpartition(".")[0]
            found.setdefault(name.replace(".", "_"), {}).setdefault(name, (part in parts, span))
        for same in found.values():
            if len(same) > 1 and any(of_part for of_part, _ in same.values()):
                name, other, *_ = sorted(same, key=lambda name: name.count("."))
                message = f"'{name}' and '{other}' have the same name in C"
                self.error(message, same[name][1], "rename one of them")

    def _check(self, statement: st.Statement) -> None:
        if isinstance(statement, st.Accumulate):
            self.states.accumulate(statement)
            return
        group, _, method = STATEMENTS[statement.keyword].check.partition(".")
        getattr(self.checks[group], method)(statement)

    def _unused(self) -> None:
        for entry in self.names.table.values():
            of_part = self.file.source.piece(entry.span.start).part  # Its file alone is told of.
            used = entry.used or entry.name in self.counting or of_part
            if not used and entry.kind in _UNUSED:
                self.warn(f"the {entry.kind} '{entry.name}' is never used", entry)

    def _model(self) -> m.Model | None:
        if self.report.errors or self.file.diagnostics:
            return None
        parts = {field: tuple(found) for field, found in self.parts.items() if field}
        (head,) = parts.pop("name")
        rotations = parts["rotations"]
        parts["coordinates"] += tuple(c for r in rotations for c in coordinates_of(r))
        parts["states"] = (*(s for r in rotations for s in states_of(r)), *parts["states"])
        parts["starts"] = (*map(identity, rotations), *parts["starts"])
        parts["inputs"] = self._inputs(parts["inputs"])
        said = {"name": head.name, "description": head.description, "span": head.span}
        source, dimensionless = self.file.source, self.dimensionless
        parts["consistent"] = self.dynamics.consistent
        return m.Model(source=source, dimensionless=dimensionless, **said, **parts)

    def _inputs(self, declared) -> tuple[m.Input, ...]:
        found = [x if isinstance(x, m.Input) else self._input(*x) for x in declared]
        inputs = {x.name: replace(x, by=self.sampled.get(x.name, "")) for x in found}
        return *inputs.values(), *(replace(inputs[of], name=name) for of, name in self.queues)

    def _input(self, item: st.Declared, unit, description: str) -> m.Input:
        order = self.inputs.get(item.name, 0)
        dimension, texts = unit.dimension, []
        for _ in range(order + 1):
            texts.append(si_text(dimension, unit.angle) if texts else unit.shown)
            dimension = over(dimension, self.time_dimension)
        return m.Input(item.name, order, tuple(texts), description, item.span)


_UNUSED = ("table", "parameter", "constant", "size", "input", "definition")
