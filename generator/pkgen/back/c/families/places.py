"""The C names and array indices of the quantities of models with families."""

from __future__ import annotations

from ....graph.affine import COUNTERS, Affine
from ....middle.families.equations import Assigned, FamilyEquations
from ....middle.families.indexed_ir import Group, Slot
from ....middle.families.indices import unlike_loops
from ....middle.families.slots import M
from ..names import FIELD_RESERVED, Names


class Places:
    """The C names and array indices of a model's quantities: sizes, members of families, ranges."""

    def __init__(self, e: FamilyEquations):
        self.equations = e
        fields = Names(FIELD_RESERVED, (), e.model.name + "_")
        self.sizes = {s.name: fields.take(s.name) for s in e.model.sizes}
        self.fields = {g.name: fields.take(g.name) for g in e.parameters}
        self.scalar_fields = {self.fields[g.name] for g in e.parameters if not g.is_family}
        self.tables = {table.name: fields.take(table.name) for table in e.model.tables}
        self.size_texts = {
            unlike_loops(name): f"p->{c_name}" for name, c_name in self.sizes.items()
        } | {name: f"at_{name[1:]}" for name in COUNTERS}
        for k in range(len(e.switches)):  # each switch's first and last index
            self.size_texts |= {f"least{k}'": f"p->side_lo_[{k}]", f"most{k}'": f"p->side_hi_[{k}]"}
        names = Names(frozenset())
        own = (*e.coordinates, *e.carried_groups)
        self.ids = {g.name: names.take(g.name) for g in own}  # name -> its part in C names
        # The name of the constraint row that expresses each recurrence.
        self.made = {g.name: names.take(f"of_{g.name}") for g in e.carried_groups}
        self.first: dict[str, Affine] = {}  # name -> array index of the first member
        total = Affine()
        for group in (*e.coordinates, *e.carried_groups):
            self.first[group.name] = total
            total = total + group.count
        self.whole = total  # length of the array q, which includes recurrence values
        total = Affine()
        self.lets: dict[str, tuple[Affine, Affine]] = {}  # name -> (offset, least index)
        for item in (item for found in e.along for item in found):
            self.lets[item.name] = total, item.group.lo
            total = total + item.group.count
        self.n_lets = total
        total = Affine()
        self.observed: list[Affine] = []  # Offset of each output, then the total length.
        for item in e.outputs:
            self.observed.append(total)
            total = total + item.count
        self.observed.append(total)
        total = Affine()
        for rows in e.bound:  # offsets in lambda
            self.first[rows.group.name] = total
            total = total + rows.group.count

    def index(self, at: Affine) -> str:
        """Returns an index expression as C."""
        return at.text(self.size_texts)

    def let(self, name: str, at: Affine) -> Affine:
        """Returns the place of member `at` of a recurrent `let`, which its previous member defines,
        in the array that stores the values of all recurrent `let`s."""
        first, lo = self.lets[name]
        return first + at - lo

    def names_in(self, at: Affine) -> tuple[str, ...]:
        return tuple(self.size_texts.get(name, name) for name, _ in at.terms)

    def flat(self, name: str, at: Affine | None) -> Affine:
        """Returns the index in the arrays q, v, ...: of the member `at` of a family, or of a scalar
        coordinate if `at` is None."""
        return self.first[name] if at is None else self.first[name] + at - self._lo(name)

    def given(self, x: Assigned) -> Affine:
        """Returns the index of a value after an event in the array of all q, then all v and u."""
        e, inputs = self.equations, [u.name for u in self.equations.inputs]
        if x.name in inputs:
            return e.count.times(2) - e.first_order + inputs.index(x.name)
        return self.flat(x.name, x.lo) + (e.count - e.first_order if x.order else 0)

    def _lo(self, name: str) -> Affine:
        e = self.equations
        rows = (bound.group for bound in e.bound)
        groups = (*e.coordinates, *e.parameters, *e.carried_groups, *rows)
        return next(g.lo for g in groups if g.name == name)

    def carried(self, kind: str, name: str, at: Affine) -> tuple[str, Affine]:
        """Returns the array and the index at which C stores a recurrence value, its rate or its
        acceleration. The array q has further sections behind the values and the rates: for the
        kinds "w", "d", "hung_p", "hung_f" (see Slot), in this order."""
        place, own = self.flat(name, at), self.equations.count
        behind = {"w": self.whole.times(2), "d": self.whole.times(3) - own}
        behind["hung_p"] = self.whole.times(4) - own.times(2)
        behind["hung_f"] = self.whole.times(5) - own.times(3)
        return ("q", place - own + behind[kind]) if kind in behind else (kind, place)

    def stored(self, slot: Slot) -> tuple[str, Affine]:
        """Returns the array, in C, and the index of a member of a family or of a scalar."""
        e, name, kind = self.equations, slot.name, slot.kind
        if kind == "let":
            return f"{e.model.name}_lets(p)", self.let(name, slot.at)
        if name in {g.name for g in e.carried_groups}:
            return self.carried(kind, name, slot.at)
        if kind in ("a", "acc"):
            memory = "rated" if name in {g.name for g in e.states} else "accelerated"
        else:
            memory = {"p": "momentum", "lambda": "lambda"}.get(kind, "")
        array = f"{e.model.name}_{memory}(p)" if memory else "q" if kind == "q" else "v"
        return array, self.flat(name, slot.at)

    def member(self, name: str, at: Affine | None) -> str:
        """Returns the C expression of a parameter, or of the member `at` of a family of
        parameters."""
        place = "" if at is None else f"[{self.index(at - self._lo(name))}]"
        return f"p->{self.fields[name]}{place}"

    def group(self, g: Group) -> dict[str, str | bool]:
        """Returns the template variables of a declaration: a coordinate, a parameter, or a family
        of these."""
        declared, family = g.declared, g.is_family
        unseen = "a body rate, in v" if g.is_turn else "a state, in v" if g.is_state else ""
        first = self.first.get(g.name, Affine())
        unit = f"[{declared.unit}]" if declared.unit else ""
        says = [x for x in (declared.description, unit) if x]
        return {
            "name": self.ids.get(g.name, g.name),
            "shown": g.shown,
            "is_family": family,
            "first": self.index(first),
            "lo": self.index(g.lo) if family else "0",
            "hi": self.index(g.hi) if family else "0",
            "count": self.index(g.count),
            "cell": self.index(first + M - g.lo if family else first),
            "says": ", ".join(x for x in (" ".join(says), unseen) if x),
            "lo_text": g.lo.text() if family else "",
            "hi_text": g.hi.text() if family else "",
            "first_text": first.text(),
        }
