"""C functions of the parameters: default values, prepare, bounds, initial values."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from ...record import record
from . import tables
from .kernel_code import KernelCode, statements, unused
from .program import Interval, Program, Statement
from .tree import Function, If, Loop, Node, Scope

PREPARE = "int {0}_prepare(struct {0}_params *p)"
BOUNDS = "void {0}_bounds(const struct {0}_params *p, pk_real *lo, pk_real *hi)"
DERIVE = "void {0}_derive(struct {0}_params *p, const unsigned char *given)"


FINITE = "0 times x is 0 unless x is infinite or not a number."
NOT_FINITE = "return PK_FAILED(PK_FAILURE_DERIVED, 0);"


@record
class ParameterCode:
    """The code of a parameter or a family of parameters: the assignment of its default value
    (`follows`: the default depends on other parameters), the check of its bounds, and the stores of
    its bounds."""

    default: Sequence[Node]
    follows: bool
    check: Sequence[Node]
    bounds: Sequence[Node]


def checked(field: str, index: int, bounds: Interval, lo_open: bool, hi_open: bool) -> list[Node]:
    """Returns the check that a parameter is within its bounds."""
    above = ">" if lo_open or bounds.lo is None else ">="
    below = "<" if hi_open or bounds.hi is None else "<="
    lo, hi = bounds.ends
    outside = f"!({field} {above} {lo} && {field} {below} {hi})"
    failed = f"return PK_FAILED(PK_FAILURE_PARAMETER, {index});"
    return [*statements(bounds.statements), If(outside, [failed])]


def ends(index: int, bounds: Interval) -> list[Node]:
    """Returns the stores of a parameter's bounds."""
    lo, hi = bounds.ends
    stores = f"lo[{index}] = {lo};", f"hi[{index}] = {hi};"
    return [*statements(bounds.statements), *stores]


def derived(rows: Iterable[ParameterCode]) -> list[Node]:
    """Returns the assignments of those defaults that depend on other parameters. The C code skips
    parameters whose values are given."""
    return [If(f"!given || !given[{k}]", row.default) for k, row in enumerate(rows) if row.follows]


def checks(rows: Iterable[ParameterCode]) -> Iterator[Node]:
    yield "/* The comparisons are written so that a NaN fails. */"
    for row in rows:
        yield from row.check


def given(found: tables.Fields) -> Iterator[Node]:
    """Yields the check that tables which have no data of their own in C are set."""
    for field, table in found:
        if table.long:
            yield If(f"!p->{field}", [NOT_FINITE])


def hoisted(count: int, code: Iterable[Node]) -> Iterator[Node]:
    """Yields code that computes the array of `count` constants and checks that they are finite."""
    if not count:
        yield "p->c_[0] = 0;"
        return
    yield from code
    yield from ("", f"/* {FINITE} */")
    if count == 1:
        yield If("!(0 * p->c_[0] == 0)", [NOT_FINITE])
        return
    yield Loop(f"k = 0; k < {count}; k++", [If("!(0 * p->c_[k] == 0)", [NOT_FINITE])])


# -- models without loops --------------------------------------------------------------------------


def scoped(needs: Sequence[Statement], nodes: list[Node]) -> list[Node]:
    """Returns the nodes; if the statements `needs` are not empty, in a C scope of their own."""
    return [Scope(nodes)] if needs else nodes


def _rows(program: Program) -> Iterator[ParameterCode]:
    slots = program.equations.parameters
    for k, (slot, default, bounds) in enumerate(
        zip(slots, program.defaults, program.bounds, strict=True)
    ):
        field, needs = f"p->{program.parameter_names[k]}", bounds.statements
        check = checked(field, k, bounds, slot.lo_open, slot.hi_open)
        yield ParameterCode(
            scoped(default[1:], [*statements(default)]),
            slot.follows,
            scoped(needs, check),
            scoped(needs, ends(k, bounds)),
        )


def functions(program: Program) -> Iterator[Function]:
    model, rows = program.equations.model.name, list(_rows(program))
    type = f"struct {model}_params *p"
    defaults = tables.pointers(model, program.tables)
    defaults += [node for row in rows for node in row.default]
    switches = () if program.plain else program.equations.switches
    sides = [f"p->side_[{k}] = 0;" for k in range(len(switches))]
    prepared = f"(void){model}_prepare(p);"
    yield Function(f"void {model}_defaults({type})", [*defaults, *sides, prepared])
    if not program.plain or any(row.follows for row in rows):
        yield Function(DERIVE.format(model), derived(rows) or unused(["p", "given"]))
    prepare = KernelCode(model, program.prepare)
    yield from prepare.parts()
    yield Function(PREPARE.format(model), [*_prepare(program, rows, prepare)])
    bounds = [node for row in rows for node in row.bounds]
    yield Function(BOUNDS.format(model), [*unused(["p"]), *(bounds or unused(["lo", "hi"]))])
    start = KernelCode(model, program.start)
    yield from start.parts()
    yield Function(f"void {start.name}(const {type}, pk_real *q, pk_real *v)", [*start.body()])


def _prepare(program: Program, rows: list[ParameterCode], code: KernelCode) -> Iterator[Node]:
    if program.prepare.work:
        yield from (f"pk_real w[{program.prepare.work}];", "")
    if rows:
        yield from (*checks(rows), "")
    else:
        yield from unused(["p"])
    yield from given(program.tables)
    if program.constants:
        yield from (*code.body(), "", f"/* {FINITE} */")
        zero = " + ".join(f"0 * p->{x.c_name}" for x in program.constants)
        yield If(f"!({zero} == 0)", [NOT_FINITE])
    if program.factored:
        yield f"{code.model}_mass(p, 0, NULL, NULL, NULL, p->factors_);"
        yield f"{code.model}_factor(p->factors_, p->inverse_);"
    yield "return 0;"
