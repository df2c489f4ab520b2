"""Checks a `joint`: its kind, coordinates, families, position and limits."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from fractions import Fraction
from itertools import pairwise

from ...system.near import meant
from ...tree import Expr, Name, Number
from .. import statements as st
from ..joints import CLAUSES, KINDS, LIMITS, TO, Kind, joint_names
from ..units import LENGTH, NONE
from .body_families import family
from .body_parts import BodyParts
from .names import UNKNOWN, Entry
from .shared import Shared, infinite
from .written import written


class BodyJoints(BodyParts):
    """Checks joints. A joint generates statements, which the function `run` checks."""

    def __init__(self, shared: Shared, run: Callable[[st.Statement], None], file: st.File) -> None:
        super().__init__(shared)
        self.run, self.statements = run, file.statements
        self.families: dict[str, st.Joint] = {}  # name of a family -> its first joint
        # Name of a joint -> the texts of its axis, of its `turned` rotation, and of the unit
        # vectors e and f normal to the axis.
        self.texts: dict[str, list[str]] = {}

    def kind_of(self, statement: st.Joint) -> Kind | None:
        word, span = statement.kind
        kind, axis = KINDS.get(word), statement.axis
        if statement.to[0] != TO:
            message = f"'to' stands between two bodies, not '{statement.to[0]}'"
            parent, child = statement.parent[0], statement.child[0]
            help = f"joint {statement.name[0]}: {parent} to {child} {word}"
            self.error(message, statement.to[1], help)
        if kind is None:
            help = meant(word, KINDS) or f"kinds: {', '.join(KINDS)}"
            self.error(f"there is no joint '{word}'", span, help)
        elif kind.axis and axis is None:
            help = f"e.g. joint {statement.name[0]}: … {word} [0, 1, 0] at O"
            self.error(f"a {word} joint has an axis", span, help)
        elif axis is not None and not kind.axis:
            self.error(f"a {word} joint has no axis", axis, "leave it out")
        else:
            return kind
        return None

    def coordinates(self, statement: st.Joint, kind: Kind) -> None:
        given = [e for word, _, items in statement.clauses if word == "coord" for e in items]
        pairs = joint_names(statement)
        if given and len(given) != len(kind.coordinates):
            wanted = {0: "no coordinate", 1: "one coordinate"}
            many = wanted.get(len(pairs), f"{len(pairs)} coordinates")
            message = f"a {statement.kind[0]} joint has {many}, not {len(given)}"
            self.error(message, given[0])
        for e in given:
            if not isinstance(e, Name):
                text = self.text(e)
                self.error(f"'coord' takes names of coordinates, not {text}", e)
        (_, at), name = statement.name, statement.left.name
        ends = None, None
        if statement.left.index is not None:
            ends = self._family(statement, pairs)
            if ends is None:
                return
        if name not in (coordinate for coordinate, _ in pairs):
            self.names.declare(Entry(name, "joint", UNKNOWN, at, used=True))
        spans = [e.span for e in given] if len(given) == len(pairs) else [at] * len(pairs)
        for (coordinate, what), span in zip(pairs, spans, strict=True):
            text = {"angle": "rad", "length": "m"}.get(what) if self.united else None
            unit = st.UnitText(text, span) if text else None
            item = st.Declared(coordinate, *ends, unit, span, span)
            word = "rotation" if what == "rotation" else "coord"
            said = statement.description or f"of the joint {name}"
            self.run(st.Declare(word, (item,), said, span))

    def _family(self, statement: st.Joint, pairs) -> tuple[Number, Number] | None:
        """Returns the first and last index of a joint's family if this joint is the first of the
        family to be checked, else None. The first joint declares the coordinates of all joints of
        the family."""
        name, at = statement.left.name, statement.left.span
        first = self.families.setdefault(name, statement)
        if first is not statement:
            line = self.names.line_of(first.span)
            if (first.kind[0], joint_names(first)) != (statement.kind[0], pairs):
                message = f"'{statement.name[0]}' is not as '{first.name[0]}' in line {line} is"
                help = "joints of a family are of one kind, with one 'coord': choose another name"
                self.error(message, at, help)
            return None
        numbers = family(self.statements, st.Joint, name)
        for one, other in pairwise(numbers):
            if other != one + 1:
                message = f"there are two joints '{name}[{one}]'"
                if other != one:
                    message = f"there is no joint '{name}[{one + 1}]' between '{name}[{one}]' and "
                    message += f"'{name}[{other}]'"
                self.error(message, at, "a family of joints is numbered one by one")
                break
        lo, hi = (Number(Fraction(k), at) for k in (numbers[0], numbers[-1]))
        return lo, hi

    def parts_of(self, statement: st.Joint, kind: Kind) -> None:
        name = statement.name[0]
        given = self.clauses(statement, CLAUSES["joint"], f"the joint '{name}'")
        self.texts[name] = texts = ["", "", "", ""]
        if statement.axis is not None:
            values = self.axis(name, statement.axis)
            if None in values and len(kind.coordinates) > 1:
                message = "the axis of a planar joint is written in numbers"
                self.error(message, statement.axis, "turn the joint by 'turned'")
            elif len(kind.coordinates) > 1:
                texts[2:] = across(values)
            texts[0] = f"{name}.axis"
        if "turned" in given:
            texts[1] = f"{name}.turn" if self.turning(name, given["turned"]) else ""
        self.place(name, given.get("at"), statement.name[1], "joint")
        if "limits" in given:
            self._limits(statement, kind, given["limits"])

    def _limits(self, statement: st.Joint, kind: Kind, value: Expr) -> None:
        """Adds the events j_lower and j_upper (j_3_lower, j_3_upper for j[3]), which stop a run."""
        name, before = statement.name[0], self.report.count
        if len(kind.coordinates) != 1 or kind.coordinates[0][1] == "rotation":
            message = f"a {statement.kind[0]} joint has no limits"
            help = "a revolute and a prismatic joint have; of others write an 'event'"
            self.error(message, value, help)
            return
        ((own, what),) = joint_names(statement)
        ends = self._ends(value)
        dimension = LENGTH if what == "length" else NONE
        needs = f"a limit of {'a way needs [m]' if what == 'length' else 'an angle is a number'}"
        found = []
        for end, part in zip(LIMITS, ends, strict=bool(ends)):
            if infinite(part) == LIMITS[end][1]:
                continue
            values = self.given(f"{name}.{end}", part, needs, dimension, vector=False)
            found.append(values[0] if values else None)
        if self.report.count > before or None in found:
            found = []
        if len(found) == 2 and not found[0] < found[1]:
            message = f"the lower limit of '{name}' is not below the upper one"
            self.error(message, value)
        if self.report.count > before:
            return
        for end, part in zip(LIMITS, ends, strict=True):
            (toward, sign), at = LIMITS[end], part.span
            if infinite(part) != sign:
                event = "_".join(filter(None, (*re.split(r"[\[\]]", name), end)))
                text = f"{st.numbered(own, statement.left)} - {name}.{end}"
                made = written(text, at, pieces=self.source.pieces)
                said = f"the {end} limit of the joint {name}"
                self.run(st.Event(event, at, made, toward, True, said, at, limit=True))

    def _ends(self, value: Expr) -> tuple[Expr, ...]:
        items = self._elements(value)
        if items is None or len(items) != len(LIMITS):
            help = "e.g. limits [-pi/2, pi/2]; where there is none: [-inf, 2]"
            self.error("limits are two numbers, the lower one first", value, help)
            return ()
        return items


def across(axis: Sequence[float]) -> tuple[str, str]:
    """Returns two orthogonal unit vectors e and f, as text, with e x f along the axis: for z they
    are x, y; for x they are y, z; for y they are z, x."""
    length = math.hypot(*map(float, axis))
    n = [float(part) / length for part in axis]
    k = max(range(3), key=lambda i: abs(n[i]))
    start = [float(i == (k + 1) % 3) for i in range(3)]
    along = sum(a * b for a, b in zip(start, n, strict=True))
    e = [a - along * b for a, b in zip(start, n, strict=True)]
    size = math.hypot(*e)
    e = [part / size for part in e]
    f = [n[i - 2] * e[i - 1] - n[i - 1] * e[i - 2] for i in range(3)]
    return _text(e), _text(f)


def _text(vector: Sequence[float]) -> str:
    return "[" + ", ".join(f"{part + 0.0:.17g}" for part in vector) + "]"
