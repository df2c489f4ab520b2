"""The architecture on one page: from the text of a model to the text of its C.

    parse    text                 -> File        statements, each with its place in the text
    check    File                 -> Model       names, units, bounds; finds all errors
    derive   Model                -> Equations   M, f, p, h, Jacobians on one expression graph
    analyze  Equations            -> Structure   proved facts about the equations
    reduce   Equations, Structure -> the same, restricted to the needs of a scene, and a report
    lower    Equations, Structure -> Program     straight-line code with common subexpressions
    render   Program              -> {file name: text}

If the families (q[1..N]) of a model stay loops, the stages make FamilyEquations, Structure and
FamilyProgram. If they are unrolled, Equations.unrolled gives the reason.

Each stage imports only earlier stages, does not modify its arguments, and prints nothing.
"""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import wraps
from itertools import islice
from typing import TYPE_CHECKING, Any

from .back.c.constant_range import Beyond, extreme
from .equations import Equations
from .front import parse
from .front.check import check
from .methods import Own, known
from .middle.analyze import analyze
from .middle.analyze.proofs import check_claims
from .middle.derive import derive
from .middle.derive.closed_forms import check_exact
from .middle.derive.first_degree import as_states
from .middle.derive.legendre import in_pairs
from .middle.families.equations import FamilyEquations
from .middle.families.indexed_ir import NotKept
from .middle.quantities import families, too_deep
from .middle.reduce import reduce
from .middle.reduce.reduction import ENOUGH, Needs, State
from .middle.report import Report, ReportLine
from .middle.structure import Structure
from .model import Model
from .plan import CompilePlan, Use
from .record import record
from .source import Diagnostic, ModelError, Source, Span
from .system.progress import trace

if TYPE_CHECKING:
    from .back.c.program import FamilyProgram, Program

STAGES = ("parse", "check", "derive", "analyze", "reduce", "lower", "render")


def _told(stages: Callable[..., Iterator[object]]) -> Callable[..., Iterator[object]]:
    """Wraps the generator stages(): traces each stage, reports a RecursionError as a ModelError."""

    @wraps(stages)
    def told(source: Source, *what: object, **how: object) -> Iterator[object]:
        made = stages(source, *what, **how)
        for name in STAGES:
            try:
                result = next(made)
            except RecursionError:  # it belongs to no statement, so it has no position
                raise ModelError(source, [Diagnostic(*too_deep(Span(0, 0)))]) from None
            trace(name)
            yield result

    return told


@record
class CompiledPart:
    """A block of coordinates that is compiled as a separate system; `coordinates` are its indices
    in the whole model."""

    name: str
    coordinates: tuple[int, ...]
    equations: Equations
    structure: Structure
    program: Program
    plan: CompilePlan


@record
class Compilation:
    """The results of all stages; `declared` is the model before a scene restricts it."""

    declared: Model
    model: Model
    warnings: tuple[Diagnostic, ...]
    equations: Equations | FamilyEquations
    structure: Structure
    report: Report
    program: Program | FamilyProgram
    files: dict[str, str]
    parts: tuple[CompiledPart, ...] = ()  # blocks of coordinates that are integrated separately
    plan: CompilePlan = CompilePlan()

    @property
    def blocks(self) -> list[tuple[str, tuple[int, ...]]]:
        """The names of the parts, and the indices of their coordinates."""
        return [(part.name, part.coordinates) for part in self.parts]


@_told
def stages(
    source: Source,
    sizes: Mapping[str, int],
    kernels: frozenset[str] | None = None,
    self_test: bool = False,
    libm: bool = False,
    unroll: int | None = 0,
    use: Use | None = None,
    symmetric: bool = False,
    canonical: bool = False,
    own: Sequence[Own] = (),
    plain: bool = False,
    jets: bool = False,
) -> Iterator[object]:
    """Yields the result of each of STAGES, in order; a caller may stop after any stage.

    `check` yields (declared model, model restricted by `use`, warnings); `reduce` yields
    (equations, structure, report); `lower` yields (program, parts, plan)."""
    file = parse.parse_all(source)
    yield file
    declared, warnings = check.check(file, sizes)
    methods = {method.name: method for method in (*declared.methods, *own)}
    declared = replace(declared, methods=tuple(methods.values()))
    use = use or Use()
    declared = use.declared(as_states(in_pairs(declared)))
    model, lines = use.model(declared)
    yield declared, model, warnings
    needs = use.needs(model)

    def planned(*made: Any) -> CompilePlan:
        """Returns the plan for (equations, structure); without these, for all possible kernels."""
        plan = use.plan(model, made or None)
        return plan if kernels is None else replace(plan, kernels=kernels)

    called = planned().kernels
    with _no_collection():
        flat = self_test or canonical or (kernels is not None and not plain)
        equations = _equations(model, flat, called, unroll, needs)
        if isinstance(equations, FamilyEquations):
            from .middle.families.proofs import with_proofs

            equations = with_proofs(equations, symmetric)
    check_exact(*use.exact(declared))
    yield equations
    if isinstance(equations, FamilyEquations):
        yield equations.facts
        check_claims(model, equations.facts.claims)
        if needs is not None:
            equations, gone = _of_loops(equations, needs)
            lines = (*lines, *gone)
        yield equations, equations.facts, Report(lines)
        from .back.c import render
        from .back.c.families import lower as families_in_c

        with _in_range(model):
            plan = planned(equations, equations.facts)
            loops = families_in_c.lower_families(equations, libm, plan.kernels, plain)
        yield loops, (), plan
        yield render.render_families(loops)
        return
    structure = analyze.analyze(equations, symmetric, with_claims=True)
    yield structure
    check_claims(equations.model, structure.claims)
    left = State(equations, structure)
    if needs is not None:
        with _no_collection():
            left = reduce.reduce(equations, structure, needs, called)
    report = replace(left.report, lines=(*lines, *left.report.lines))
    from .middle.derive import states

    if canonical:
        from .middle.derive.canonical import with_hamiltonian

        left = replace(left, equations=with_hamiltonian(left.equations, left.structure))
    plan = planned(left.equations, left.structure)
    plans = [planned(part.equations, part.structure) for part in left.parts]
    plans = [replace(one, kernels=reduce.of_a_part(one.kernels)) for one in plans]
    of_whole = reduce.of_the_whole(plan.kernels) if left.parts else plan.kernels
    of_each = [of_whole, *(one.kernels for one in plans)]
    reads = use.reads(model)
    with _no_collection(), _in_range(model):
        systems = zip((left, *left.parts), of_each, strict=True)
        in_c = [states.as_rates(x.equations, x.structure, of) for x, of in systems]
        kept = None
        if reads is not None:
            made = [(e, of) for (e, _), of in zip(in_c, of_each, strict=True)]
            kept = _kept(made, reads | {*report.starts.values()})
            report = report.unread(in_c[0][0].parameters, kept)
    yield left.equations, left.structure, report
    from .back.c import lower, render  # late: `pkgen check` does not need it

    method = known(declared.methods).get(plan.method)
    jets = jets or plan.jets or (method is not None and "jets" in method.traits)
    how = {"libm": libm or plain, "kept": kept, "plain": plain, "jets": jets}
    with _no_collection(), _in_range(model):
        each = [lower.lower(*x, of, **how) for x, of in zip(in_c, of_each, strict=True)]
    program, *of_parts = each
    parts = tuple(
        CompiledPart(x.equations.model.name, x.coordinates, x.equations, x.structure, *more)
        for x, *more in zip(left.parts, of_parts, plans, strict=True)
    )
    yield program, parts, plan
    with _no_collection():
        files = render.render(program, self_test=self_test, report=report)
        for part in parts:
            files |= render.render(part.program)
    yield files


def _of_loops(
    equations: FamilyEquations, needs: Needs
) -> tuple[FamilyEquations, tuple[ReportLine, ...]]:
    """Drops outputs that no column needs, and `conserve` claims, which are judged before a run."""
    model, lines = reduce.outputs_of_loops(equations.model, needs)
    if not lines:
        return equations, ()
    from .middle.families.derive import derive_families

    return replace(derive_families(model), facts=equations.facts), lines


def _kept(
    made: list[tuple[Equations, frozenset[str] | None]], reads: frozenset[str]
) -> frozenset[int]:
    """Returns the indices of the parameters that the kernels or the run (`reads`) read."""
    from .back.c import lower

    slots = made[0][0].parameters
    read = {k for k, x in enumerate(slots) if x.family in reads}
    read |= {k for equations, kernels in made for k in lower.parameters_read(equations, kernels)}
    return lower.with_dependents(made[0][0], frozenset(read))


@contextmanager
def _in_range(model: Model) -> Iterator[None]:
    """Reports a constant that a double cannot hold as an error in the model."""
    try:
        yield
    except Beyond as beyond:
        raise beyond.placed(model) from None


@contextmanager
def _no_collection() -> Iterator[None]:
    """Disables Python's garbage collector while a graph grows: the graph has no reference cycles,
    but the collector would scan all of it repeatedly."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


def check_model(
    source: Source, *, sizes: Mapping[str, int] | None = None, unroll: int | None = 0
) -> tuple[Model, tuple[Diagnostic, ...]]:
    """Returns the model and its warnings; makes no C.

    Raises ModelError as compile_model() does. After `reduce` the only possible error is a constant
    that a double cannot hold; `lower`, which finds it, runs only if one is possible."""
    made = stages(source, sizes or {}, unroll=unroll)
    _, (_, model, warnings), _, _, (equations, *_) = islice(made, STAGES.index("reduce") + 1)
    if extreme(equations.graph):
        next(made)
    return model, warnings + getattr(equations, "left_out", ())


PAIRS = 1.5  # models with sums over pairs are unrolled up to PAIRS * `unroll` coordinates


def _equations(
    model: Model,
    flat: bool,
    called: frozenset[str] | None,
    unroll: int | None,
    needs: Needs | None,
) -> Equations | FamilyEquations:
    """Returns FamilyEquations, or unrolled Equations with the reason in their field `unrolled`."""
    declared = (*model.coordinates, *model.states)
    count = sum(f.count for f in families(model, declared).values())
    if flat:
        reason = "some kernels, a self-test or the canonical form were asked for"
    elif unroll is None:
        reason = "the command names single coordinates"
    elif count <= unroll:
        reason = "so few coordinates are faster as straight-line code"
    else:
        try:
            from .middle.families.derive import derive_families

            made = derive_families(model)
            if not made.has_pairs or unroll == 0 or count > PAIRS * unroll:
                return made
            reason = "so few pairs are faster as straight-line code"
        except NotKept as cannot:
            reason = str(cannot)
    # reduce() needs only the kernels ENOUGH; then it derives the requested kernels.
    now = called if needs is None else ENOUGH
    return replace(derive.derive(model, now, reason), unrolled=reason)


def compile_model(
    source: Source,
    *,
    sizes: Mapping[str, int] | None = None,
    portable: bool = False,
    c: bool = True,
    **how: Any,
) -> Compilation:
    """Compile a model to C; `how` are arguments of stages().

    `sizes` overrides `size` statements; `kernels` names the kernels to emit (None: all);
    `self_test` adds a program that checks the kernels against each other; `libm` C calls sine and
    cosine of the C library instead of inlining them. Families are unrolled in models of up to
    `unroll` coordinates (None: any number), and for `kernels`, `self_test` and `canonical`, even if
    they could be loops. `use` restricts the C to a scene's needs. `symmetric` searches for the
    model's symmetries, which only `explain` and comments in the C show. `canonical` adds H(q, p)
    and its gradients. `portable` C uses no fused multiply-add, so its results do not depend on the
    processor. Without `c` the program is lowered but not rendered, and `files` is empty. `own` adds
    methods to those of the model. `jets` adds the kernel `jet` where `kernels` is None. `plain` C
    is for embedding: it implies `libm` and lacks the kernels that only the runtime calls. Raises
    ModelError with every error found by the stage that failed."""
    made = stages(source, sizes or {}, **how)
    _, (declared, model, warnings), _, _, reduced, (program, parts, plan) = islice(made, 6)
    files = next(made) if c else {}
    equations, structure, report = reduced
    warnings += getattr(equations, "left_out", ())
    if portable and c:
        from .back.c import render

        files = render.portable(files)
    return Compilation(
        declared, model, warnings, equations, structure, report, program, files, parts, plan
    )
