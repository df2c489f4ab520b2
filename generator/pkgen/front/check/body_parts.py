"""Checks the values of `body` and `joint`: masses, inertias, positions, axes. Each value becomes a
hidden definition, so that numbers without units are in SI."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction

from ... import model as m
from ...indices import parted
from ...source import Span
from ...system.near import meant
from ...tree import AXES, Expr, Number, Quantity, Vector
from .. import statements as st
from ..units import INERTIA, LENGTH, MASS, NONE, Dimension, si_text
from .expr import Target
from .names import Entry, Facts, Members, joined
from .scope import PLACES, Scope
from .shared import Checks, Shared
from .vectors import UNIT
from .written import written

Value = Fraction | float | None  # None: the value is not known at compile time.

_INERTIAS = "[Ixx, Iyy, Izz], [Ixx, Iyy, Izz, Ixy, Ixz, Iyz] or three rows of three"


class BodyParts(Checks):
    def __init__(self, shared: Shared) -> None:
        super().__init__(shared)
        self.united = self.time_dimension != NONE
        self.masses: dict[str, Value] = {}
        # Name of a body -> the elements of its inertia tensor.
        self.inertias: dict[str, tuple[Value, ...]] = {}
        # Name of a body with a fixed joint -> name of the body that carries it.
        self.carriers: dict[str, str] = {}

    def clauses(
        self, statement: st.Body | st.Joint, words: tuple[str, ...], what: str
    ) -> dict[str, Expr]:
        """Returns the values of a statement's clauses, by the word of each clause. The value for
        `coord` is its first name."""
        found: dict[str, Expr] = {}
        for word, span, items in statement.clauses:
            if word not in words:
                have = ", ".join(f"'{w}'" for w in words)
                help = meant(word, words) or f"there are {have}"
                self.error(f"{what} has no part '{word}'", span, help)
            elif word in found:
                self.error(f"'{word}' is given twice", span)
            elif len(items) > 1 and word != "coord":
                self.error(f"'{word}' takes one value", items[1])
            found.setdefault(word, items[0])
        return found

    def mass(self, name: str, value: Expr) -> None:
        values = self.given(f"{name}.mass", value, "a mass needs [kg]", MASS, vector=False)
        self.masses[name] = found = values[0] if values else None
        if found is not None and found < 0:
            self.error("a mass is not negative", value)

    def place(self, name: str, value: Expr | None, at: Span, place: str = "body") -> None:
        """Checks the `at` of a joint, or of a body: its centre of mass in the body's frame."""
        value = value or written("[0, 0, 0]", at)
        self.given(f"{name}.at", value, "a place needs [m]", LENGTH, place=place)

    def inertia(self, name: str, value: Expr | None) -> None:
        """Checks the inertia tensor about the centre of mass. Off-diagonal elements have the sign
        of the tensor: Ixy = -sum(m x y) over the mass points m at (x, y, z)."""
        self.inertias[name] = ()
        if value is None:
            return
        items = self._elements(value)
        needs = "an inertia needs [kg*m^2]"
        if items is None:  # The value is the name of a vector.
            self.given(f"{name}.inertia", value, needs, INERTIA)
            self.inertias[name] = (None,) * len(AXES)
            return
        if len(items) not in (3, 6):
            help = f"write {_INERTIAS}"
            self.error(f"an inertia has no {len(items)} elements", value, help)
            return
        values: tuple[Value, ...] = ()
        for member, k in (("inertia", 0), ("products", 3)):
            part = items[k : k + 3]
            if part:
                span = part[0].span.to(part[-1].span)
                values += self.given(f"{name}.{member}", Vector(part, span), needs, INERTIA)
        for item, found in zip(items[:3], values, strict=False):
            if found is not None and found < 0:
                self.error("a moment of inertia is not negative", item)
        self.inertias[name] = values

    def _elements(self, value: Expr) -> tuple[Expr, ...] | None:
        """Returns the elements of a literal vector, or of a matrix of three literal rows. A unit
        after the whole literal is given to each element."""
        if isinstance(value, Quantity):
            inner = self._elements(value.of)
            unit = value.unit, value.unit_span
            return inner and tuple(Quantity(item, *unit, item.span) for item in inner)
        if not isinstance(value, Vector):
            return None
        rows = [self._elements(item) for item in value.items]
        if None in rows or [len(row) for row in rows] != [3, 3, 3]:
            return value.items
        (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = rows
        text = self.text
        for a, b in ((xy, yx), (xz, zx), (yz, zy)):
            if text(a) != text(b):
                message = f"a tensor of inertia is symmetric, and {text(b)} is not {text(a)}"
                self.error(message, b)
        return xx, yy, zz, xy, xz, yz

    def axis(self, name: str, value: Expr) -> tuple[Value, ...]:
        needs = "an axis is a vector of numbers"
        values = self.given(f"{name}.axis", value, needs, NONE)
        if values and all(found == 0 for found in values):
            self.error("the zero vector is no axis", value, "e.g. [0, 1, 0]")
            return ()
        size = max((abs(float(found)) for found in values if found is not None), default=1.0)
        if None not in values and not 1e-100 < size < 1e100:
            message = "no double holds the square of this axis: only its direction counts"
            self.error(message, value, "e.g. [0, 1, 0]")
            return ()
        return values or (None,)

    def turning(self, name: str, value: Expr) -> bool:
        """Checks the clause `turned rot(...)` of a joint and defines the rotation NAME.turn.
        Returns False if the value is no constant rotation."""
        _, facts = self.factor(value, Scope(PLACES["body"]))
        if facts.known and not facts.turns:
            text = self.text(value)
            help = "e.g. turned rot([1, 0, 0], pi/2)"
            self.error(f"{text} is no rotation", value, help)
        if not (facts.known and facts.turns) or not self._stands(facts, value.span):
            return False
        self.keep(f"{name}.turn", facts, value.span)
        return True

    def _stands(self, facts: Facts, span: Span) -> bool:
        if facts.moves:
            help = "it takes numbers, constants and parameters; what moves is a joint of its own"
            self.error("this part of a body or of a joint does not move", span, help)
        return not facts.moves

    def given(
        self,
        name: str,
        value: Expr,
        needs: str,
        dimension: Dimension,
        vector: bool = True,
        place: str = "body",
    ) -> tuple[Value, ...]:
        """Checks a value and adds it as a definition. Returns its components, None for each that is
        not known at compile time; () after an error."""
        dimension = dimension if self.united else NONE
        target, scope = Target(dimension, needs, bare=True), Scope(PLACES[place])
        before = self.report.count
        value = self.origin(value)
        wanted = self.wanted_vector if vector else self.wanted
        found, facts = wanted(value, scope, target)
        if self.report.count == before and place == "body":
            self._stands(facts, value.span)
        self.use_inputs(facts)
        own = replace(facts, dimension=dimension, vector=vector, value=None, bare=False)
        self.keep(name, own, value.span)
        own_name, index = parted(name)
        at = None if index is None else Number(Fraction(index), value.span)
        definition = m.Definition(own_name, at, None, found, si_text(dimension), "", value.span)
        self.parts["definitions"].append(definition)
        if self.report.count > before:
            return ()
        items = value.items if isinstance(value, Vector) else (value,)
        if vector and not isinstance(value, Vector):
            return (None,) * len(AXES)
        return tuple(self.checked(item, scope)[1].value for item in items)

    def keep(self, name: str, facts: Facts, span: Span) -> None:
        """Declares a quantity of a body or a joint, such as the rotation R of a body. `link[3].R`
        is a member of the family `link.R`; the table entry of the family joins the facts of all its
        members."""
        own, index = parted(name)
        entry = self.names.table.get(own)
        if index is None or entry is None:
            members = None if index is None else Members((index, index))
            entry = Entry(own, "definition", facts, span, members, used=True)
            self.names.declare(entry)
            entry.turning = {} if facts.turns and index is not None else None
        elif entry.kind != "poisoned":
            vector = facts.vector or entry.facts.vector
            together = joined(facts.dimension, vector, [entry.facts, facts])
            entry.facts = replace(together, bare=False)
            entry.members.add(index, index)
        if entry.turning is not None:
            entry.turning[index] = facts

    # energies

    def massive(self, name: str) -> bool:
        return self.masses[name] != 0

    def held(self, child: str, parent: str, turn: str, at: str) -> Iterator[tuple[str, str]]:
        """Yields (name, text) for the internal quantities of a body that is fixed to a carrier
        body: the fixed body's rotation and position in the carrier's frame, and the carrier's axes
        in the fixed body's frame."""
        on = parent in self.carriers
        self.carriers[child] = self.carriers.get(parent, parent)
        yield "held", f"{parent}.held*{turn}" if on else turn
        yield "place", f"{parent}.place + {parent}.held*{at}" if on else at
        for member, axis in zip("efg", UNIT.values(), strict=True):
            yield member, f"inverse({child}.held)*{axis}"

    def held_energy(self, name: str, carrier: str) -> Iterator[str]:
        """Yields the terms of the kinetic energy of a body fixed to a carrier body, in terms of the
        carrier's velocities."""
        if self.massive(name):
            at = f"{name}.place + {name}.held*{name}.at"
            speed = f"{carrier}.velocity + cross({carrier}.omega, {at})"
            yield f"{name}.mass/2*dot({speed}, {speed})"
        elements = [(element, *axes) for _, element, axes in self._elements_of(name)]
        for i, a in enumerate("efg" if elements else ""):
            for k, b in enumerate("efg"[i:], i):
                terms = " + ".join(
                    f"{name}.{element}*({name}.{a}.{x}*{name}.{b}.{y}"
                    + (f" + {name}.{a}.{y}*{name}.{b}.{x})" if x != y else ")")
                    for element, x, y in elements
                )
                half = "/2" * (i == k)
                yield f"({terms}){half}*{carrier}.omega.{'xyz'[i]}*{carrier}.omega.{'xyz'[k]}"

    def turning_energy(self, name: str) -> Iterator[str]:
        """Yields the terms of the rotational energy w.I.w/2, with angular velocity w and inertia
        tensor I. Elements of I that are known to be 0 are left out."""
        for half, element, (a, b) in self._elements_of(name):
            yield f"{name}.{element}{half}*{name}.omega.{a}*{name}.omega.{b}"

    def _elements_of(self, name: str) -> Iterator[tuple[str, str, str]]:
        for value, element, axes in zip(
            self.inertias[name],
            ("inertia.x", "inertia.y", "inertia.z", "products.x", "products.y", "products.z"),
            ("xx", "yy", "zz", "xy", "xz", "yz"),
            strict=False,
        ):
            if value != 0:
                yield "/2" * (axes[0] == axes[1]), element, axes
