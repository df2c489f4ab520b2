"""Expands `body`, `joint` and `gravity` into coordinates, definitions and energies.

These are generated as text of the language, so that later stages see an ordinary model. Messages
about generated text point to the statement of the body or joint. The velocities of a body are in
its own frame and are computed from those of its parent body, so that graph/pushed.py can propagate
second derivatives of the Lagrangian along the tree of bodies.
Reference: R. Featherstone, Rigid Body Dynamics Algorithms, Springer 2008, chapters 4 and 7.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from fractions import Fraction

from ...indices import indexed, parted
from ...source import Span
from ...system.near import meant
from ...tree import Name, Number
from .. import statements as st
from ..joints import CLAUSES, COLUMNS, GROUND, KINDS, SHOWN, TURNING, joint_names
from ..units import ACCELERATION
from .body_joints import BodyJoints
from .names import UNKNOWN, Entry, Members
from .scope import PLACES, Scope
from .shared import Shared
from .vectors import UNIT
from .written import written

_IDENTITY = "rot([0, 0, 1], 0)"
_REST = "[0, 0, 0]"
_LOOP = "what hangs on two bodies closes a loop: keep one joint and add a 'constraint'"


class Bodies(BodyJoints):
    def __init__(self, shared: Shared, run: Callable[[st.Statement], None], file: st.File) -> None:
        super().__init__(shared, run, file)
        self.expressions.columns = self.columns
        # Positions of statements with an error; a family has one position for all its bodies.
        self.wrong: set[Span] = set()
        self.bodies: dict[str, st.Body] = {}
        self.joints: dict[str, st.Joint] = {}  # The keys are names of child bodies.
        self.waiting: list[st.Joint] = []  # Joints whose parent's position is not known yet.
        self.placed: list[str] = []
        self.bad: set[str] = set()  # Names of bodies that have an error or whose ancestor has one.
        self.gravity_at: dict[str, Span] = {}  # prefix of the names of a part -> its `gravity`

    # statements

    def body(self, statement: st.Body) -> None:
        name, before = statement.name, self.report.count
        if statement.left.name == GROUND:
            message = f"'{GROUND}' is what stands still, and no body"
            self.error(message, statement.name_span, "choose another name")
        elif self._declared(statement.left):
            self.bodies[name] = statement
        else:
            return
        if statement.span in self.wrong:
            self.bad.add(name)
            return
        given = self.clauses(statement, CLAUSES["body"], f"the body '{name}'")
        if "mass" not in given:
            message = f"the body '{name}' has no mass"
            help = f"e.g. body {name} mass 1 [kg]; of one that only carries others: mass 0"
            self.error(message, statement.name_span, help)
        else:
            self.mass(name, given["mass"])
        self.place(name, given.get("at"), statement.name_span)
        self.inertia(name, given.get("inertia"))
        if self.report.count > before:
            self.bad.add(name)
            self.wrong.add(statement.span)
        self._advance()

    def _declared(self, left: st.Left) -> bool:
        """Declares a single body or one body of a family; returns False if its name is taken."""
        entry, index = self.names.table.get(left.name), left.index
        members = None if index is None else Members((int(index.value),) * 2)
        if members is None or entry is None or entry.kind != "body" or entry.members is None:
            new = Entry(left.name, "body", UNKNOWN, left.span, members, used=True)
            return self.names.declare(new)
        (own,) = members.intervals
        if entry.members.touch(*own):
            text = st.numbered(left.name, left)
            self.error(f"'{text}' is declared already", left)
            return False
        entry.members.add(*own)
        return True

    def gravity(self, statement: st.Single) -> None:
        part = self.source.piece(statement.span.start).part
        if part in self.gravity_at:
            line = self.names.line_of(self.gravity_at[part])
            self.error(f"there is gravity already, in line {line}", statement)
            return
        self.gravity_at[part] = statement.span
        needs = "gravity is a vector of an acceleration [m/s^2]"
        self.given(f"{part}gravity.field", statement.value, needs, ACCELERATION, place="joint")

    def joint(self, statement: st.Joint) -> None:
        before = self.report.count
        name, (child, child_at) = statement.name[0], statement.child
        if statement.span in self.wrong:
            self._hang(statement, True)
            return
        kind = self.kind_of(statement)
        if child == GROUND:
            help = f"write it first: joint {name}: ground to {statement.parent[0]} …"
            self.error("the ground hangs on no joint", child_at, help)
        elif (other := self.joints.get(child)) is not None:
            where = f"the joint '{other.name[0]}' in line {self.names.line_of(other.span)}"
            self.error(f"'{child}' hangs on {where} already", child_at, _LOOP)
        if kind is not None:
            self.coordinates(statement, kind)
        if kind is not None and name not in self.texts:
            self.parts_of(statement, kind)
        self._hang(statement, self.report.count > before)

    def _hang(self, statement: st.Joint, wrong: bool) -> None:
        child = statement.child[0]
        if wrong:
            self.wrong.add(statement.span)
            # Names in its clauses may be the coordinates of the joint.
            given = (e for word, _, items in statement.clauses if word != "turned" for e in items)
            self._poisoned([statement.left.name, *(e.id for e in given if isinstance(e, Name))])
            self.bad.add(child)
        self.joints.setdefault(child, statement)
        self.waiting.append(statement)
        self._advance()

    # definitions and energies

    def _advance(self) -> None:
        """Computes the position of each body whose parent's position is known."""
        ready = True
        while ready:
            known = {GROUND, *self.placed}
            ready = [j for j in self.waiting if j.parent[0] in known and j.child[0] in self.bodies]
            self.waiting = [j for j in self.waiting if j not in ready]
            for joint in ready:
                self._place(joint)

    def _place(self, joint: st.Joint) -> None:
        child, parent = joint.child[0], joint.parent[0]
        if child in self.placed:
            return
        self.placed.append(child)
        if self.bad & {child, parent}:
            self.bad.add(child)
            self._poisoned(f"{child}.{member}" for member in SHOWN)
            return
        for member, text in self._members(joint, child, parent):
            self._say(f"{child}.{member}", text, joint.span)

    def _members(self, joint: st.Joint, child: str, parent: str) -> Iterator[tuple[str, str]]:
        """Yields (name, text) for each quantity of a joint's child body, such as its rotation R and
        its origin."""
        kind, name = KINDS[joint.kind[0]], joint.name[0]
        axis, turned, e, f = self.texts[name]
        words = dict(a=axis, u=f"{axis}/norm({axis})", e=e, f=f)
        numbers = ["", *(st.numbered(x, joint.left) for x, _ in joint_names(joint))]
        turn, shift, rates, velocity = (
            text.format(*numbers, **words)
            for text in (kind.turn, kind.shift, kind.rates, kind.velocity)
        )
        still = parent == GROUND
        q = "*".join(filter(None, (turned, turn))) or _IDENTITY
        place = f"{name}.at"
        r = f"{place} + {turned}*({shift})" if shift and turned else f"{place} + {shift}"
        r = r if shift else place
        yield "R", q if still else f"{parent}.R*{q}"
        yield "origin", r if still else f"{parent}.origin + {parent}.R*({r})"
        yield "com", f"{child}.origin + {child}.R*{child}.at"
        passed = [] if still else [f"inverse({q})*{parent}.omega"]
        yield "omega", self._sum(*passed, rates)
        carried = [] if still else [f"{parent}.velocity", f"cross({parent}.omega, {r})"]
        moves = self.names.table[parted(place)[0]].facts.moves
        if kind is KINDS["fixed"] and not (still or moves):
            yield from self.held(child, parent, q, place)
        if moves:
            carried.append(f"{place}'")
        passed = [f"inverse({q})*({self._sum(*carried)})"] if carried else []
        yield "velocity", self._sum(*passed, velocity)
        # The speed is the velocity of the child's centre of mass.
        yield "speed", f"{child}.velocity + cross({child}.omega, {child}.at)"

    @staticmethod
    def _sum(*terms: str) -> str:
        return " + ".join(filter(None, terms)) or _REST

    def finish(self) -> None:
        """Reports errors of the tree of bodies, and adds the energies."""
        self._tree()
        if self.gravity_at and not self.bodies:
            first, *_ = self.gravity_at.values()
            self.error("gravity acts on bodies, and there is none", first)
        if self.report.errors:
            return
        parents = {joint.parent[0] for joint in self.joints.values()}
        for name in self.placed:
            joint = self.joints[name]
            alone = name not in parents and joint.parent[0] == GROUND
            slides = alone and bool(KINDS[joint.kind[0]].shift)
            for what, text in self._energies(name, slides):
                self._say(what, text, self.bodies[name].span)

    def _energies(self, name: str, slides: bool) -> Iterator[tuple[str, str]]:
        """Yields the terms of a body's energies, as (keyword, text). `slides` means that the body
        has no child, and that a joint which can translate connects it to the ground. Its speed is
        then written as com', the rate of its centre of mass, which makes its mass matrix
        constant."""
        speed = f"{name}.com'" if slides else f"{name}.speed"
        if name in self.carriers:
            terms = self.held_energy(name, self.carriers[name])
        else:
            moved = [f"{name}.mass/2*dot({speed}, {speed})"] * self.massive(name)
            terms = (*moved, *self.turning_energy(name))
        yield from (("kinetic", text) for text in terms)
        part = self.source.piece(self.bodies[name].span.start).part
        while part and part not in self.gravity_at:  # A part without gravity has its user's.
            part = part[: part.rfind(".", 0, -1) + 1]
        if self.massive(name) and part in self.gravity_at:
            yield "potential", f"-{name}.mass*dot({part}gravity.field, {name}.com)"

    def _say(self, what: str, text: str, span: Span) -> None:
        """Adds a term to an energy, or defines the name `what`."""
        value = written(text, span, pieces=self.source.pieces)
        if what in ("kinetic", "potential"):
            self.run(st.Single(what, value, span))
            return
        name, index = parted(what)
        if index is not None and what.rpartition(".")[2] in TURNING:
            self.keep(what, self.factor(value, Scope(PLACES["let"]))[1], span)
            return
        at = None if index is None else Number(Fraction(index), span)
        self.run(st.Define("let", st.Left(name, at, None, span), value, "", span))
        self.names.table[name].used = True

    def columns(self, name: str) -> tuple[str, ...]:
        """Returns the names of the definitions for the columns of the rotation matrices of a family
        of bodies; adds these definitions if needed."""
        found = tuple(f"{name.rpartition('.')[0]}.{column}" for column in COLUMNS)
        entry = self.names.table[name]
        there = self.names.table.get(found[0])
        for index in sorted(entry.turning):
            if there is None or not there.members.hold(index, index):
                for column, axis in zip(found, UNIT.values(), strict=True):
                    self._say(indexed(column, index), f"{indexed(name, index)}*{axis}", entry.span)
        return found

    def _poisoned(self, names: Iterable[str]) -> None:
        """Declares names that have an error (kind "poisoned")."""
        for name in names:
            own = parted(name)[0]
            entry = self.names.table.setdefault(own, Entry(own, "poisoned", UNKNOWN, Span(0, 0)))
            # If the name has an index, this avoids an error about the index.
            entry.periodic |= own != name

    def _tree(self) -> None:
        names = [*self.bodies]
        broken, told = False, {GROUND, *names}
        for joint in self.joints.values():
            broken |= joint.child[0] == GROUND  # joint() reports this error
            for name, span in (joint.parent, joint.child):
                if name in told:
                    continue
                broken = True
                told.add(name)
                help = meant(name, [*names, GROUND]) or f"declare it: body {name} mass …"
                self.error(f"unknown body '{name}'", span, help)
        for name, body in self.bodies.items():
            if name not in self.joints and not broken:
                message = f"the body '{name}' hangs on no joint"
                help = f"joint NAME: ground to {name} revolute [0, 1, 0] at O; or free, or fixed"
                self.error(message, body.name_span, help)
                broken = True
        if self.waiting and not broken:
            names = [joint.name[0] for joint in self._circle()]
            shown = ", ".join(names[:8]) + ", …" * (len(names) > 8)
            message = f"the joints {shown} go round in a circle, without the ground"
            self.error(message, self.waiting[0], _LOOP)

    def _circle(self) -> list[st.Joint]:
        found: list[st.Joint] = []
        joint = self.waiting[0]
        while joint not in found:
            found.append(joint)
            joint = self.joints[joint.parent[0]]
        return found[found.index(joint) :]
