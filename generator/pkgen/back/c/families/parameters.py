"""C functions of the parameters of a model with loops.

For a family of parameters they loop over its members.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from ....middle.families.indexed_ir import Group
from ...targets import STORE
from ..kernel_code import statements
from ..parameter_code import (
    BOUNDS,
    DERIVE,
    PREPARE,
    ParameterCode,
    checked,
    checks,
    derived,
    ends,
    given,
    hoisted,
    scoped,
)
from ..program import Interval, Statement
from ..tables import Fields, pointers
from ..tree import Declare, Function, If, Loop, Node, Scope
from .blocks import Block
from .places import M, Places


@dataclass
class Summing:
    """A sum that is computed once and stored: `place` is its C variable, `ranges` are the loop
    variables with first and last index, `block` is its term, `inside` are sums in the term."""

    place: str
    ranges: list[tuple[str, str, str]]
    block: Block
    inside: list[Summing]

    @property
    def blocks(self) -> list[Block]:
        return [self.block, *(block for x in self.inside for block in x.blocks)]


@dataclass
class Assignment:
    """An assignment to the members lo..hi of a family, or to a scalar if lo is "". The sums
    `before` are computed once, the sums `each` again for every member."""

    lo: str
    hi: str
    before: list[Summing]
    each: list[Summing]
    block: Block

    @property
    def blocks(self) -> list[Block]:
        return [self.block, *(block for x in (*self.before, *self.each) for block in x.blocks)]


def each(lo: str, hi: str, nodes: list[Node]) -> list[Node]:
    """Returns the statements `nodes` in a C loop over the indices lo..hi; if lo is "", the
    statements without a loop."""
    if lo:
        return [Loop(f"m = {lo}; m <= {hi}; m++", [Scope(nodes)])]
    return [Scope(nodes)] if len(nodes) > 1 else nodes


def assigned(x: Assignment, count: int) -> list[Node]:
    """Returns the statements of an assignment. `count` is the length of the local array that stores
    the sums in the assigned value."""
    own = [*summed(x.each), *statements(x.block.statements)]
    if not (x.before or x.each):
        return each(x.lo, x.hi, own)
    room = Declare("pk_real", f"once[{count}]")
    return [Scope([room, *summed(x.before), *each(x.lo, x.hi, own)])]


def summed(found: Sequence[Summing]) -> Iterator[Node]:
    for x in found:
        inner: list[Node] = [*summed(x.inside), *statements(x.block.statements)]
        for name, lo, hi in reversed(x.ranges):
            inner = [Loop(f"{name} = {lo}; {name} <= {hi}; {name}++", [Scope(inner)])]
        names = ", ".join(name for name, _, _ in x.ranges)
        yield f"{x.place} = 0;"
        yield Scope([Declare("ptrdiff_t", names), "", *inner])


def code(
    group: Group, places: Places, block: Block, default: Assignment, k: int, count: int
) -> ParameterCode:
    """Returns the C code of parameter k: the assignment of its default value, the check of its
    bounds, and the stores of its bounds."""
    given = group.declared.bounds
    kept = {s.target: s.text for s in block.statements if s.kind == STORE}
    needs = tuple(s for s in block.statements if s.kind != STORE)
    bounds = Interval(needs, kept.get("lo"), kept.get("hi"))
    lo, hi = (places.index(x) if group.is_family else "" for x in (group.lo, group.hi))
    field = places.member(group.name, M if group.is_family else None)
    first = [Declare("const ptrdiff_t", "m", lo)] if "m" in block.words else []
    return ParameterCode(
        assigned(default, count),
        group.declared.follows,
        each(lo, hi, checked(field, k, bounds, given.lo_open, given.hi_open)),
        scoped([*first, *needs], [*first, *ends(k, bounds)]),
    )


def _index(nodes: Iterable[Node]) -> list[Node]:
    """Returns a declaration of the loop variable m if the statements contain a loop."""
    inside = [part for node in nodes for part in (node.body if isinstance(node, Scope) else [node])]
    needed = any(isinstance(node, Loop) for node in inside)
    return [Declare("ptrdiff_t", "m"), ""] if needed else []


def functions(
    model: str,
    rows: list[ParameterCode],
    starts: list[Assignment],
    count: int,
    prepare: Sequence[Statement],
    factored: bool,
    block: bool,
    bound: bool = False,
    fixed: Sequence[str] = (),
    tables: Fields = (),
    summed: int = 0,
    plain: bool = False,
) -> str:
    """Returns the C functions of the parameters. The C function `prepare` computes the `count`
    hoisted constants and the totals `fixed`, and factors the mass matrix if `factored`. `block`:
    the model needs allocated memory. `summed`: the number of sums in initial values and parameters
    that are computed once. `tables`: the tables of data. `plain`: NAME_derive() is left out if no
    default follows from other parameters."""
    params = f"struct {model}_params *p"
    defaults = [node for row in rows for node in row.default]
    follow = [node for row in rows if row.follows for node in row.default]
    bounds = [node for row in rows for node in row.bounds]
    start = [node for x in starts for node in assigned(x, summed)]
    none = Loop(f"m = 0; m < (ptrdiff_t){model}_count(p); m++", ["q[m] = v[m] = 0;"])

    def prepared() -> Iterator[Node]:
        if count > 1:
            yield Declare("size_t", "k")
        yield from _index(node for row in rows for node in row.check) or [""] * (count > 1)
        unfit = f"!{model}_fits(p)" + " || !p->work_" * block
        yield If(unfit, ["return PK_FAILED(PK_FAILURE_SIZE, 0);"])
        yield from checks(rows)
        yield from given(tables)
        yield from hoisted(count, statements(prepare))
        for k in fixed:
            value = f"{model}_total_sum_{k}(p, 0, NULL, NULL, NULL)"
            yield f"{model}_sums(p)[{k}] = {value};"
        if factored:
            alone = ", 0, NULL, NULL" if bound else ""
            yield f"p->failed_ = {model}_factored(p, 0, NULL, NULL, NULL{alone});"
        yield "return 0;"

    body = [*_index(follow), "(void)p, (void)given;", *derived(rows)]
    derive = Function(DERIVE.format(model), body)
    found = [
        Function(
            f"void {model}_defaults({params})",
            [
                *_index(defaults),
                If(f"!{model}_fits(p)", ["return;"]),
                *pointers(model, tables),
                *defaults,
                f"(void){model}_prepare(p);",
            ],
        ),
        *([] if plain and not follow else [derive]),
        Function(PREPARE.format(model), [*prepared()]),
        Function(BOUNDS.format(model), ["(void)p, (void)lo, (void)hi;", *bounds]),
        Function(
            f"void {model}_start(const {params}, pk_real *q, pk_real *v)",
            [Declare("ptrdiff_t", "m"), none, *start],
        ),
    ]
    return "\n".join(function.text for function in found)
