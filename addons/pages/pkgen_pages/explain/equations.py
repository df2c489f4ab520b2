"""The sections of a page that show a model and its equations, one equation per coordinate."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from html import escape
from itertools import groupby
from typing import TYPE_CHECKING

from pkgen.equations import Quantity
from pkgen.explain.contents import Contents
from pkgen.explain.flat import canonical_rows, constraint_rows, rates_title
from pkgen.front.statements import Interval
from pkgen.graph.graph import ZERO, Node
from pkgen.indices import in_parts
from pkgen.middle.quantities import single_rotations
from pkgen.model import Event
from pkgen.tree import Expr, names

from . import mathml
from .mathml import operator, row
from .prose import Prose
from .shown import Chunks, Shown
from .tables import heading, lead, named, table, where
from .written import Line, Written

if TYPE_CHECKING:
    import sympy

# If there are more equations of motion than this, only the first three and the last are shown.
ROWS = 24
MEMBERS = 6  # If a table row has more names than this, only the first two and the last are shown.
_OF_MULTIPLIERS = (
    "The multipliers; J has the slopes of these rows by the rates, "
    "γ is their rate of change where nothing accelerates"
)
_DIRECTIONS = {1: "rising", -1: "falling", 0: "either way"}


def quantity_rows(quantities: Iterable[Quantity], prose: Prose) -> Iterator[tuple[str, str, str]]:
    """Yields rows (names, unit, description); adjacent names of equal unit and description share
    one."""
    for (unit, says), group in groupby(quantities, key=lambda q: (q.unit, q.description)):
        names = [members(q.name, prose) for q in group]
        if len(names) > MEMBERS:
            names = [*names[:2], "…", names[-1]]
        yield ", ".join(names), prose.unit(unit), escape(says)


def members(name: str, prose: Prose) -> str:
    """Returns a name typeset; for a family q[1..N], its first and its last member."""
    family, _, index = name.rstrip("]").partition("[")
    ends = [f"{family}[{end}]" for end in index.split("..")] if ".." in index else [name]
    shown = [mathml.inline(prose.written.name(x)) for x in ends]
    return ", …, ".join(shown)


def lines(shown: Iterable[Line]) -> list[str]:
    return [mathml.formula(chunks, escape(note)) for chunks, note in shown]


def lets(found: Sequence[Line]) -> list[str]:
    return named([chunks for chunks, _ in found], [note for _, note in found])


def parameter_table(c: Contents, prose: Prose) -> Iterator[str]:
    """Yields the table of the compiled parameters: SI units; defaults and bounds as in the
    source."""
    units = {x.quantity.name.partition("[")[0]: x.quantity.unit for x in c.parameters}
    rows, written = [], prose.written
    for s in written.parameters():
        name = s.left.name
        if name in units:
            unit = prose.unit(units[name])
            cells = mathml.inline(written(s.value)), unit, _range(written, s.interval)
            rows.append((mathml.inline(written.left(s.left)), *cells, escape(s.description)))
    if rows:
        yield heading("Parameters")
        yield table(("symbol", "default", "unit", "range", "meaning"), rows)


def _range(written: Written, interval: Interval | None) -> str:
    if interval is None:
        return ""
    lo, hi = (None if _infinite(x) else written(x) for x in (interval.lo, interval.hi))
    if lo is None and hi is None:
        return ""
    if hi is None:
        return mathml.inline(mathml.leading(">" if interval.lo_open else "≥") + lo)
    if lo is None:
        return mathml.inline(mathml.leading("<" if interval.hi_open else "≤") + hi)
    left, right = "(" if interval.lo_open else "[", ")" if interval.hi_open else "]"
    return mathml.inline(mathml.fenced(lo + operator(",") + hi, left, right))


def _infinite(end: Expr) -> bool:
    return "inf" in names(end)


def of_lagrangian(written: Written) -> tuple[list[Line], list[Line]]:
    """Returns formulas of energies and forces, and of the `let` definitions that they use."""
    kinds = ("kinetic", "potential", "lagrangian", "hamiltonian", "dissipation", "force", "torque")
    return [*written.energies(), *written.forces()], written.lets_of(kinds)


class EquationSections:
    def __init__(self, shown: Shown, written: Written, prose: Prose):
        self.e, self.shown, self.written, self.prose = shown.e, shown, written, prose

    def all(self) -> Iterator[str]:
        e = self.e
        if e.coordinates:
            yield from self._lagrangian()
            yield from self._motion()
        yield from self._constraints()
        yield from self._rates()
        yield from self._canonical()
        yield from self._outputs()

    # -- the Lagrangian and the equations of motion --------------------------------------------

    def _lagrangian(self) -> Iterator[str]:
        e, written = self.e, self.written
        said, lets_there = of_lagrangian(written)
        yield heading("Lagrangian")
        yield from (*lines(said), *lets(lets_there))
        rows = [("L", e.lagrangian)]
        if e.kinetic is not None and e.potential is not None:
            rows = [("T", e.kinetic), ("V", e.potential)]
        rows = [(mathml.name(name), node) for name, node in rows if node != ZERO]
        made = self.shown.where(rows)
        if lets_there and {*map("".join, made.formulas)} - {"".join(chunks) for chunks, _ in said}:
            yield lead("In the coordinates")
            yield from where(made)

    def _motion(self) -> Iterator[str]:
        """Yields Lagrange's equations, one per row, with the terms in accelerations on the left."""
        e, n = self.e, len(self.e.mass)
        bound = e.constraints
        force = e.force if bound is None else bound.free_force
        rows = [i for i in range(n) if n <= ROWS or i < 3 or i == n - 1]
        yield heading("Equations of motion")
        if bound is not None:
            yield lead("With the multipliers of the constraints, their forces on the right")
        left = [[j for j in range(n) if e.mass[i][j] != ZERO] for i in rows]
        right = [
            [k for k, r in enumerate(bound.rows if bound else ()) if r[i] != ZERO] for i in rows
        ]
        nodes: list[Node] = []
        for i, columns, multipliers in zip(rows, left, right, strict=True):
            nodes += [e.mass[i][j] for j in columns]
            nodes += [force[i], *(bound.rows[k][i] for k in multipliers)]

        def made(values: list[sympy.Expr]) -> list[Chunks]:
            taken = iter(values)
            return [
                self._row(taken, columns, multipliers)
                for columns, multipliers in zip(left, right, strict=True)
            ]

        yield from where(self.shown.made_of(nodes, made))
        if len(rows) < n:
            yield f"<p>and so on: {n} equations.</p>"

    def _row(
        self, values: Iterator[sympy.Expr], columns: Sequence[int], multipliers: Sequence[int]
    ) -> Chunks:
        import sympy as sp

        shown, e = self.shown, self.e
        accelerations = [sp.Symbol(f"{e.rates[j].name}'") for j in columns]
        inertia = sp.Add(*(shown.formula(next(values)) * a for a in accelerations))
        force = shown.formula(next(values))
        for k in multipliers:
            force += shown.formula(next(values)) * sp.Symbol(e.constraints.names[k].name)
        first, *others = shown.typeset.terms(force)
        return [*shown.typeset.terms(inertia), mathml.binary("=") + first, *others]

    def _constraints(self) -> Iterator[str]:
        bound = self.e.constraints
        if bound is None:
            return
        yield heading("Constraints")
        yield from lines(self.written.constraints())
        yield from lets(self.written.lets_of(("constraint", "rolling")))
        rows = list(constraint_rows(self.e))
        rows = rows[: len(rows) - len(bound.names)]
        yield lead("By components")
        yield from self._zeros(rows, [_of_constraint(name) for name, _ in rows])
        yield lead(_OF_MULTIPLIERS)
        yield mathml.formula([_MULTIPLIERS])
        names = [
            (self.shown.name(q.name), node)
            for q, node in zip(bound.names, bound.multipliers, strict=True)
        ]
        explicit = self.shown.where(names)
        if not explicit.operations:
            yield from where(explicit)

    def _rates(self) -> Iterator[str]:
        e = self.e
        if not e.states:
            return
        yield heading(rates_title(e))
        for rotation in single_rotations(e.model):
            if e.quaternions:
                yield from self._matrix(rotation.name, rotation.quaternion)
        rows = [
            (self.shown.name(f"{q.name}'"), node)
            for q, node in zip(e.states, e.state_rates, strict=True)
        ]
        yield from where(self.shown.where(rows))

    def _matrix(self, name: str, quaternion: tuple[str, ...]) -> Iterator[str]:
        import sympy as sp

        w, x, y, z = map(sp.Symbol, quaternion)
        entries = (
            (w**2 + x**2 - y**2 - z**2, 2 * (x * y - w * z), 2 * (x * z + w * y)),
            (2 * (x * y + w * z), w**2 - x**2 + y**2 - z**2, 2 * (y * z - w * x)),
            (2 * (x * z - w * y), 2 * (y * z + w * x), w**2 - x**2 - y**2 + z**2),
        )
        shown = [[self.shown.typeset(entry) for entry in line] for line in entries]
        turn = mathml.name(name)
        yield mathml.formula([row(turn, operator("="), mathml.matrix(shown))], "body to space")

    # -- canonical form, outputs, events --------------------------------------------------------

    def _canonical(self) -> Iterator[str]:
        rows = canonical_rows(self.e)
        if not rows:
            return
        h, *slopes = rows
        yield heading("Canonical form")
        names = [*(q.name for q in self.e.coordinates), *(q.name for q in self.e.momenta_names)]
        left = [mathml.name("H"), *(self._slope(name) for name in names)]
        nodes = [node for _, node in (h, *slopes)]
        yield from where(self.shown.where(list(zip(left, nodes, strict=True))))

    def _slope(self, name: str) -> str:
        partial = operator("∂")
        return mathml.fraction(partial + mathml.name("H"), partial + self.shown.name(name))

    def _outputs(self) -> Iterator[str]:
        e = self.e
        named_nodes = [
            *zip(e.observed_names, e.observed, strict=True),
            *zip(e.conserved_names, e.conserved, strict=True),
        ]
        if named_nodes:
            yield heading("Outputs")
            rows = [(self.shown.name(q.name), node) for q, node in named_nodes]
            yield from where(self.shown.where(rows))
        events = list(zip(e.event_names, e.model.events, e.events, strict=True))
        if events:
            yield heading("Events")
            yield from self._events(events)

    def _events(self, events: Sequence[tuple[Quantity, Event, Node]]) -> Iterator[str]:
        notes = []
        for q, event, _ in events:
            stops = ", stops the run" if event.stop else ""
            notes.append(f"{escape(q.name)}: {_DIRECTIONS[event.direction]}{stops}")
        yield from self._zeros([(q.name, node) for q, _, node in events], notes)

    def _zeros(self, rows: Sequence[tuple[str, Node]], notes: Sequence[str]) -> Iterator[str]:
        """Yields formulas 0 = EXPRESSION, each with a note."""
        shown = self.shown.where([(mathml.number("0"), node) for _, node in rows])
        if shown.operations:
            yield from where(shown)
            return
        for chunks, note in zip(shown.formulas, notes, strict=True):
            yield mathml.formula(chunks, note)
        yield from named(shown.named)


def _of_constraint(name: str) -> str:
    """Returns the label of a constraint for a reader. The constraint joint.z gets "joint z"; the
    constraint joint' gets "rate of joint"."""
    own, axis = in_parts(name.rstrip("'"))
    shown = f"{escape(own)} {mathml.inline(mathml.name(axis))}" if axis else escape(own)
    return f"rate of {shown}" if name.endswith("'") else shown


def _multipliers() -> str:
    j, m, f, rest = (mathml.name(x) for x in ("J", "M", "f", "gamma"))
    inverse = mathml.number("-1")
    across = '<mi mathvariant="normal">T</mi>'
    inner = row(j, mathml.sup(m, inverse), mathml.sup(j, across))
    outer = row(j, mathml.sup(m, inverse), f, operator("+"), rest)
    return row(
        mathml.name("lambda"),
        operator("="),
        operator("-"),
        mathml.sup(mathml.fenced(inner), inverse),
        mathml.fenced(outer),
    )


_MULTIPLIERS = _multipliers()
