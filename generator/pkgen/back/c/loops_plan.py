"""Determines the rows and totals that each kernel of a model with loops needs."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from ...graph.affine import Affine
from ...middle.loops.indexed_ir import Bound, Group, Part, Row, Slot, Total, Unrolled
from ...middle.loops.jacobians import Slopes, slopes_of
from ...middle.loops.loops import LoopEquations
from ...middle.loops.matrices import Matrix, Unknown
from .loops import Block, M
from .loops_chain import Chain
from .loops_sets import Builder, PairSet, RowSet, TotalSet
from .loops_switches import terms
from .recurrence_rows import made_of

TOTALS = ("energy", "lagrangian", "kinetic", "potential")
# Kernels that write a value for each coordinate: {kernel: {output: field of LoopEquations}}.
VECTORS = {
    "force": {"f": "force"},
    "canonical": {"momenta": "momenta", "pdot": "pdot"},
    "momenta": {"momenta": "momenta"},
    "gradient": {"dLdq": "gradient"},
}
# Kernels with a value for each constraint row.
BOUND: dict[str, Callable[[Bound], Row | Total]] = {
    "constraint": lambda rows: rows.position,
    "constraint_rates": lambda rows: rows.rate,
    "coasting": lambda rows: rows.coasting,
    "position_size": lambda rows: rows.sizes[0],
    "rate_size": lambda rows: rows.sizes[1],
}
OF_POSITIONS = ("constraint", "position_size")
# The output of each kernel that contains forces between pairs.
PAIRED = {"gradient": "gradient", "canonical": "pdot", "force": "force"}


@dataclass
class SlopeKernel:
    """A kernel that writes matrices of derivatives. Each value of a row set in `rows` is added to a
    matrix entry; `stores` has these entries, as (output, row, column) in C. `corner` has the
    entries whose row and column belong to scalar coordinates, as (output, row, column, name of the
    total)."""

    name: str
    outputs: tuple[str, ...]
    rows: list[RowSet] = field(default_factory=list)
    stores: list[list[tuple[str, str, str]]] = field(default_factory=list)  # by row set
    columns: list[str] = field(default_factory=list)  # C functions that return the index of a row
    corner: list[tuple[str, str, str, str]] = field(default_factory=list)


@dataclass
class Rates:
    """The rates of a first-order state, computed before the rows that contain them."""

    group: dict
    rows: RowSet | None  # for a family of states
    total: TotalSet | None  # for a scalar state
    pairs: list[PairSet]

    @property
    def blocks(self) -> list[Block]:
        found = [x for x in (self.rows, self.total) if x is not None]
        return [block for x in found for block in x.blocks] + [pair.block for pair in self.pairs]


@dataclass
class Alongside:
    """Recurrent `let`s in outputs. They are computed in one loop over the indices: `rows` are the
    definitions, `stores` the C variables of the values, `least` and `greatest` the first and last
    index of each definition in C."""

    rows: list[RowSet]
    stores: list[str]
    least: list[str]
    greatest: list[str]

    @property
    def blocks(self) -> list[Block]:
        return [block for x in self.rows for block in x.blocks]


@dataclass
class Plan:
    """All row sets and totals that the kernels of a model need."""

    rows: dict[str, list[RowSet]] = field(default_factory=dict)
    band: list[RowSet] = field(default_factory=list)
    totals: dict[str, TotalSet] = field(default_factory=dict)
    pairs: dict[str, list[PairSet]] = field(default_factory=dict)
    singularities: list[TotalSet] = field(default_factory=list)
    switches: list[TotalSet] = field(default_factory=list)
    chain: Chain | None = None
    made: tuple[Bound, ...] = ()  # recurrences in the form of constraint rows
    jacobian: dict[str, RowSet] = field(default_factory=dict)  # constraint rows of the band
    border: dict[str, RowSet] = field(default_factory=dict)  # derivatives of single constraint rows
    bound: dict[str, dict[str, RowSet | TotalSet]] = field(default_factory=dict)  # by kernel, name
    slopes: list[SlopeKernel] = field(default_factory=list)
    slopes_of: Slopes | None = None
    reach: int = 0  # Half bandwidth of the matrices in `slopes`.
    observed: dict[int, RowSet] = field(default_factory=dict)  # outputs with a value for each index
    pull: list[RowSet] = field(default_factory=list)  # forces of constraints: rows of J^T lambda
    along: dict[int, Alongside] = field(default_factory=dict)  # recurrent `let`s of each pass
    rates: dict[str, Rates] = field(default_factory=dict)  # {name of the state: ...}

    @property
    def blocks(self) -> Iterator[Block]:
        sets = [*(s for found in self.rows.values() for s in found), *self.band]
        sets += [*self.jacobian.values(), *self.border.values()]
        sets += [s for found in self.bound.values() for s in found.values()]
        sets += [*self.observed.values(), *self.pull]
        sets += [s for kernel in self.slopes for s in kernel.rows]
        for found in (*sets, *self.totals.values()):
            yield from found.blocks
        yield from (pair.block for pairs in self.pairs.values() for pair in pairs)
        for found in (*self.rates.values(), *self.along.values()):
            yield from found.blocks
        if self.chain:
            yield from self.chain.blocks


def emitted(e: LoopEquations, wanted: frozenset[str] | None) -> frozenset[str]:
    """Returns the kernels of `wanted` (None: all) that the model has, and the kernels they call."""
    named = {*VECTORS, *(k for k in TOTALS if getattr(e, k) is not None)}
    watched = {"momenta"} if watches_momenta(e) else set()
    if e.carried:
        named |= {"jacobian"}
        watched |= {"canonical"} if wanted is None or "jacobian" in wanted else set()
        return frozenset(named if wanted is None else named & wanted | {"force"} | watched)
    named |= {"mass", "inertia", "jacobian", "advance"}
    if wanted is None:
        return frozenset(named)
    alone = divides(e) and not e.force.pairs  # Each acceleration is one expression.
    solved = set() if alone else {"force"} if divides(e) else {"force", "mass"}
    watched |= {"mass"} if e.pivots else set()  # The kernel `singularity` calls `mass`.
    return frozenset(named & wanted | solved | watched)


def watches_momenta(e: LoopEquations) -> bool:
    """Returns whether an output contains a momentum."""
    return any(slot.kind == "p" for slot in e.slots)


def within(e: LoopEquations) -> dict[str, dict[str, str]]:
    """Returns VECTORS; in models with recurrences the kernel `gradient` has momenta as
    an additional output."""
    return VECTORS | ({"gradient": {"momenta": "momenta", "dLdq": "gradient"}} if e.carried else {})


def divides(e: LoopEquations) -> bool:
    """Returns whether M is diagonal, so that M a = f takes one division per row."""
    return e.mass.is_diagonal and not (e.bound or e.carried)


def planned(e: LoopEquations, make: Builder, kernels: frozenset[str]) -> Plan:
    plan, ids = Plan(), make.places.ids

    def total(key: str, of, **how: Any) -> None:
        plan.totals[key] = make.total(key, of, **how)

    vectors = {kernel: outputs for kernel, outputs in within(e).items() if kernel in kernels}
    for kernel, outputs in vectors.items():
        plan.rows[kernel] = [
            make.rows(
                f"{kernel}_{ids[g.name]}", g, [getattr(e, x).rows[g.name] for x in outputs.values()]
            )
            for g in e.rows
        ]
    # The acceleration kernel calls a function for the force on each scalar coordinate.
    for what in sorted({"force", *(x for outputs in vectors.values() for x in outputs.values())}):
        for g in e.scalars:
            total(f"{what}_{ids[g.name]}", getattr(e, what).totals[g.name])
    if e.carried:
        plan.chain = Chain(e, make.places, make, "jacobian" in kernels)
    elif divides(e):
        plan.rows["mass"] = [make.rows(f"mass_{ids[g.name]}", g, [_own(e, g)]) for g in e.families]
        if not e.force.pairs:
            plan.rows["acceleration"] = [
                make.rows(
                    f"acceleration_{ids[g.name]}", g, [e.force.rows[g.name], _own(e, g)], True
                )
                for g in e.families
            ]
    if e.extended or not (e.carried or divides(e)):
        plan.band = [
            make.rows(
                f"mass_{ids[g.name]}", g, [row for _, row in entries(e, g, ids)], ghosts=False
            )
            for g in e.banded
        ]
    if e.extended:
        _plan_made(e, make, plan)
    _plan_bound(e, make, plan)
    for k, item in enumerate(e.outputs):
        if item.lo is not None:
            group = Group(replace(item.item, name=f"observe_{k}"), item.lo, item.hi)
            row = Row((Part(item.lo, item.hi, item.node, item.node),))
            plan.observed[k] = make.rows(group.name, group, [row], ghosts=False)
    for (a, b), of in e.mass.corner.items():
        total(f"mass_{ids[a]}_{ids[b]}", of)
    for what in TOTALS:
        if what in kernels:
            total(what, getattr(e, what))
    if "jacobian" in kernels:
        _plan_slopes(e, make, plan, total)
    plan.singularities = [
        make.total(f"singularity_{k}", singularity.terms, as_derived=True)
        for k, singularity in enumerate(e.singularities)
    ]
    plan.switches = [
        make.total(f"switch_{k}", of, as_derived=True) for k, of in enumerate(terms(e))
    ]
    for kernel, what in PAIRED.items():
        if kernel in kernels:
            plan.pairs[kernel] = [make.pair(pair) for pair in getattr(e, what).pairs]
    _plan_before(e, make, plan)
    return plan


def _plan_before(e: LoopEquations, make: Builder, plan: Plan) -> None:
    """Plans the values that the planned blocks read: totals, rates of states and `let`s, including
    those that such values read in turn."""
    below, states = make.interior.slots.below, {g.name: g for g in e.states}
    passes = {item.name: k for k, found in enumerate(e.along) for item in found}
    nodes = [node for block in plan.blocks for node in block.nodes]
    nodes += [node for x in plan.singularities for block in x.blocks for node in block.nodes]
    nodes += [*e.observed, *e.conserved, *e.events, *(n for x in e.given.values() for n in x)]
    seen: set[Slot] = set()
    while nodes:
        found = [slot for slot in below(*nodes) if slot not in seen]
        seen.update(found)
        nodes = []
        for slot in found:
            if slot.kind == "sum":
                made = plan.totals[f"sum_{slot.name}"] = make.total(
                    f"sum_{slot.name}", e.sums[int(slot.name)]
                )
            elif slot.kind == "a" and slot.name in states and slot.name not in plan.rates:
                made = plan.rates[slot.name] = _rates(e, make, states[slot.name])
            elif slot.kind == "let" and passes[slot.name] not in plan.along:
                made = plan.along[passes[slot.name]] = _along(e, make, passes[slot.name])
            else:
                continue
            nodes += [node for block in made.blocks for node in block.nodes]


def _along(e: LoopEquations, make: Builder, k: int) -> Alongside:
    places, rows, stores = make.places, [], []
    for n, item in enumerate(e.along[k]):
        group = replace(item.group, declared=replace(item.group.declared, name=f"let_{k}_{n}"))
        parts = tuple(replace(part, inner=part.node) for part in item.parts)
        rows.append(make.rows(f"let_{k}_{n}", group, [Row(parts)], ghosts=False))
        stores.append(places.index(places.let(item.name, M)))
    groups = [item.group for item in e.along[k]]
    ends = [[places.index(getattr(g, x)) for g in groups] for x in ("lo", "hi")]
    return Alongside(rows, stores, *ends)


def _rates(e: LoopEquations, make: Builder, g: Group) -> Rates:
    key = make.places.ids[g.name]
    pairs = [x for x in e.force.pairs if any(name == g.name for name, _ in x.by_row)]
    rows = make.rows(f"rate_{key}", g, [e.force.rows[g.name]]) if g.is_family else None
    total = None if g.is_family else make.total(f"rate_{key}", e.force.totals[g.name])
    return Rates(make.places.group(g), rows, total, [make.pair(pair) for pair in pairs])


def _plan_made(e: LoopEquations, make: Builder, plan: Plan) -> None:
    plan.made = made_of(e, make.places, make.interior.slots)
    for rows in plan.made:
        name = rows.group.name
        plan.jacobian[name] = make.rows(f"jacobian_{name}", rows.group, [*rows.entries.values()])


def _plan_bound(e: LoopEquations, make: Builder, plan: Plan) -> None:
    for rows in e.bound:
        own = rows.group
        if not rows.is_single:
            name = f"jacobian_{own.name}"
            plan.jacobian[own.name] = make.rows(name, own, [*rows.entries.values()])
        for scalar, of in rows.corner.items():
            name = f"jacobian_{own.name}_{make.places.ids[scalar]}"
            plan.totals[name] = make.total(name, of)
    for g in e.banded:
        found = [rows.border[g.name] for rows in singles(e, g)]
        if found:
            plan.border[g.name] = make.rows(
                f"border_{make.places.ids[g.name]}", g, found, ghosts=False
            )
    for kernel, of in BOUND.items() if e.bound else ():
        plan.bound[kernel] = {
            rows.group.name: make.total(f"{kernel}_{rows.group.name}", of(rows), as_derived=True)
            if rows.is_single
            else make.rows(f"{kernel}_{rows.group.name}", rows.group, [of(rows)])
            for rows in e.bound
            if rows.holonomic or kernel not in OF_POSITIONS
        }


def singles(e: LoopEquations, g: Group) -> list[Bound]:
    """Returns the single constraint rows that contain rates of a family."""
    return [rows for rows in e.bound if g.name in rows.border]


def _plan_slopes(e: LoopEquations, make: Builder, plan: Plan, total: Any) -> None:
    """Plans the kernels of M and of the derivatives of p and p', unless the matrices are dense."""
    try:
        slopes = slopes_of(e, make.interior.slots)
    except Unrolled:
        return
    plan.slopes_of = slopes
    if e.carried and not e.extended:
        _plan_made(e, make, plan)
    plan.reach = _reach(slopes)
    families = [unknown for unknown, _ in slopes.families]
    scalar = {unknown: f"places + {k}" for k, unknown in enumerate(slopes.scalars)}
    column = {unknown: f"{e.model.name}_slopes_row_{k}" for k, unknown in enumerate(families)}
    kernels = [SlopeKernel("mass", ("M",)), SlopeKernel("jacobian", ("p_q", "pdot_q", "pdot_v"))]
    kernels[1:1] = [SlopeKernel("closed", ("M",))] if slopes.closed else []
    matrices = iter(slopes.all)
    for kernel in kernels:
        found = [next(matrices) for _ in kernel.outputs]
        for k, (unknown, group) in enumerate(slopes.families):
            rows, stores = [], []
            for output, matrix in zip(kernel.outputs, found, strict=True):
                for row, at, value in _of_row(matrix, unknown, column, scalar):
                    rows.append(value)
                    stores.append((output, row, at))
            if rows:
                name = f"slopes_{kernel.name}_{k}"
                kernel.rows.append(make.rows(name, group, rows, ghosts=False))
                kernel.stores.append(stores)
                kernel.columns.append(column[unknown])
        for output, matrix in zip(kernel.outputs, found, strict=True):
            for (a, b), of in matrix.corner.items():
                key = f"slopes_{kernel.name}_{output}_{len(kernel.corner)}"
                total(key, of)
                kernel.corner.append((output, scalar[a], scalar[b], key))
        plan.slopes.append(kernel)
    for g in e.families if slopes.pull else ():
        plan.pull.append(make.rows(f"pull_{make.places.ids[g.name]}", g, [slopes.pull[g.name]]))
    for g in e.scalars if slopes.pull else ():
        total(f"pull_{make.places.ids[g.name]}", slopes.pull[g.name])


def _reach(slopes: Slopes) -> int:
    """Returns the half bandwidth of the matrices of derivatives."""
    of = dict(slopes.families)
    at = {unknown: k for k, unknown in enumerate(of)}
    found = [0]
    for matrix in slopes.all:
        for a, b, shift in matrix.entries:
            found.append(apart((of[a], at[a]), (of[b], at[b]), shift, len(of)))
    return max(found)


def apart(a: tuple[Group, int], b: tuple[Group, int], shift: int, slots: int) -> int:
    """Returns the largest distance, in rows of the matrix, between the unknowns of member m of the
    family `a` and of member m + shift of the family `b`. Each index has `slots` unknowns, one of
    each family; the number that stands beside a family is its position among them."""
    (own, i), (other, j) = a, b
    distance = abs(shift * slots + j - i)
    # A ghost cell has the unknown of its neighbour, one index away. If both families have the same
    # ends, this shifts both alike.
    alike = (own.lo, own.hi, _free(own)) == (other.lo, other.hi, _free(other))
    return distance + slots * bool((_free(own) or _free(other)) and not alike)


def _free(g: Group) -> tuple[Affine, ...]:
    return tuple(at for at, end in g.ends if end.kind == "free")


def _of_row(
    matrix: Matrix, own: Unknown, column: dict[Unknown, str], scalar: dict[Unknown, str]
) -> Iterator[tuple[str, str, Row]]:
    """Yields the entries of the matrix, in band and border, that the row of one member contributes,
    as (row, column, value)."""
    for (row, other, shift), value in matrix.entries.items():
        if row == own:
            yield "row", f"{column[other]}(p, m + {shift})", value
    for (row, other), value in matrix.right.items():
        if row == own:
            yield "row", scalar[other], value
    for (other, row), value in matrix.bottom.items():
        if row == own:
            yield scalar[other], "row", value


def _own(e: LoopEquations, g: Group) -> Row:
    return e.mass.entries.get((g.name, g.name, 0), Row())


def entries(e: LoopEquations, g: Group, ids: Mapping[str, str]) -> list[tuple[dict[str, Any], Row]]:
    """Returns the entries of the mass matrix in the rows of a family: first those in columns of
    families, then those in columns of scalar coordinates."""
    found = [
        ({"other": ids[other], "shift": shift}, row)
        for (own, other, shift), row in e.mass.entries.items()
        if own == g.name
    ]
    found += [
        ({"scalar": scalar}, row) for (scalar, own), row in e.mass.border.items() if own == g.name
    ]
    return found
