"""Functions of the parameters: their defaults, what follows from them, their bounds, the start."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from .kernel_code import KernelCode, statements, unused
from .program import Interval, Program, Statement
from .tree import Assign, Blank, Call, Comment, Declare, Function, If, Loop, Node, Return, Scope

UNBOUNDED = ("-PK_INFINITY", "PK_INFINITY")


def _assigned(needs: Sequence[Statement], pairs: Iterable[tuple[str, str]]) -> list[Node]:
    """Assignments, in a scope of their own where they need local constants."""
    found: list[Node] = [Assign(target, value) for target, value in pairs]
    return [Scope([*statements(needs), *found])] if needs else found


def _ends(bounds: Interval) -> tuple[str, str]:
    return bounds.lo or UNBOUNDED[0], bounds.hi or UNBOUNDED[1]


def _default(program: Program, index: int) -> list[Node]:
    default = program.defaults[index]
    place = f"p->{program.parameter_names[index]}"
    return _assigned(default.statements, [(place, default.text)])


def functions(program: Program, factor: str) -> Iterator[Function | str]:
    """All of them; `factor` is the function that factors a constant M, as text."""
    model = program.equations.model.name
    type = f"struct {model}_params *p"
    yield Function(f"void {model}_defaults({type})", _defaults(program, model))
    yield Function(f"void {model}_derive({type}, const unsigned char *given)", _derive(program))
    prepare = KernelCode(model, program.prepare)
    yield from prepare.parts()
    if program.factored:
        yield factor
    yield Function(f"int {model}_prepare({type})", [*_prepare(program, prepare)])
    yield Function(f"void {model}_bounds(const {type}, pk_real *lo, pk_real *hi)", _bounds(program))
    starts = [(program.start, "pk_real *q, pk_real *v")]
    if program.equations.quadratures:
        starts.append((program.quadrature_start, "pk_real *z"))
    for kernel, outputs in starts:
        code = KernelCode(model, kernel)
        yield from code.parts()
        yield Function(f"void {code.name}(const {type}, {outputs})", [*code.body()])


def _defaults(program: Program, model: str) -> list[Node]:
    body = [x for index in range(len(program.defaults)) for x in _default(program, index)]
    body += [Assign(f"p->side_[{k}]", "0") for k in range(len(program.equations.switches))]
    return [*body, Call(f"(void){model}_prepare(p)")]


def _derive(program: Program) -> list[Node]:
    """Of defaults that follow others, those that are not given."""
    follow = [k for k, slot in enumerate(program.equations.parameters) if slot.follows]
    body: list[Node] = [If(f"!given || !given[{k}]", _default(program, k)) for k in follow]
    return body or unused(["p", "given"])


def _prepare(program: Program, code: KernelCode) -> Iterator[Node]:
    parameters = program.equations.parameters
    if program.hoisted:
        yield Declare("size_t", "k")
        if program.prepare.work:
            yield Declare("pk_real", f"w[{program.prepare.work}]")
        yield Blank()
    if parameters:
        yield Comment("The comparisons are written so that a NaN fails.")
        for index in range(len(parameters)):
            yield _check(program, index)
        yield Blank()
    if program.hoisted:
        yield from code.body()
        failed = Return("PK_FAILED(PK_FAILURE_DERIVED, 0)")
        yield Blank()
        yield Comment("x - x is 0 unless x is infinite or not a number.")
        bad = If("!(p->c_[k] - p->c_[k] == 0)", [failed])
        yield Loop(f"k = 0; k < {program.hoisted}; k++", [bad])
    else:
        yield Assign("p->c_[0]", "0")
    if program.factored:
        yield Call(f"{code.model}_factor(p)")
    yield Return("0")


def _check(program: Program, index: int) -> Node:
    """That a parameter lies where it may."""
    slot, bounds = program.equations.parameters[index], program.bounds[index]
    (lo, hi), field = _ends(bounds), f"p->{program.parameter_names[index]}"
    above = ">" if slot.lo_open or bounds.lo is None else ">="
    below = "<" if slot.hi_open or bounds.hi is None else "<="
    outside = f"!({field} {above} {lo} && {field} {below} {hi})"
    check = If(outside, [Return(f"PK_FAILED(PK_FAILURE_PARAMETER, {index})")])
    return Scope([*statements(bounds.statements), check]) if bounds.statements else check


def _bounds(program: Program) -> list[Node]:
    body = unused(["p"])
    for index, bounds in enumerate(program.bounds):
        lo, hi = _ends(bounds)
        body += _assigned(bounds.statements, [(f"lo[{index}]", lo), (f"hi[{index}]", hi)])
    return body if program.bounds else [*body, *unused(["lo", "hi"])]
