"""C functions of the acceleration: of one state, and of W states in SIMD lanes.

In the functions `lanes` all W states have the same parameters; in the functions `members`, for
ensembles, each state has its own.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from ...record import record
from ..targets import CHECK, LOAD, LOCAL, TRIG
from .kernel_code import KernelCode, grouped, unused
from .program import Kernel, Program, Statement
from .tree import Declare, Function, If, Loop, Node

SIDE_BY_SIDE = (
    "W <= 64 states side by side in loops without branches, which a compiler makes vector code "
    "of. What a lane cannot do, be it a failure or an angle of unusual size, is only noted there. "
    "Sines and cosines have a loop of their own, and checks of parameters come after both: before "
    "them they would make gcc 12 keep what it loaded, in a way that it has no vector code for."
)
LANE_ARGUMENTS = (
    "const pk_real *t, const pk_real *q, const pk_real *v, const pk_real *u, pk_real *a"
)
EACH_LANE = "size_t l = 0; l < W; l++"


class LaneCode:
    """The C functions of one model's acceleration."""

    def __init__(self, program: Program, code: KernelCode):
        self.program, self.code = program, code
        self.model, self.stem = code.model, code.name
        self.n = len(program.equations.coordinates)
        self.n_inputs = len(program.equations.inputs)
        self.angles, self.algebra, self.pairs = lane_parts(code.kernel)
        checks = (s for s in self.algebra.statements if s.kind == CHECK)
        self.uniform = [s.text for s in checks if _read([s]) <= {"p"}]  # they read only parameters
        # Whether the kernel is one function without loops, which a loop over lanes can inline.
        self.plain = not (code.kernel.solves or code.free) and len(code.kernel.blocks) == 1
        self.sc = ", sc" if self.pairs else ""
        self.arguments = {
            "lanes": f"const struct {self.model}_params *p, {LANE_ARGUMENTS}",
            "members": f"const pk_real *P, {LANE_ARGUMENTS}",
        }

    def functions(self, dense: str) -> Iterator[Function]:
        if self.plain:
            yield from self._one()
        else:
            yield from self.code.parts()
            yield self.code.definition(dense)
            body = [f"return {self.stem}(p, t, q, v, u, a);"]
            yield self._inline(body)
        if self.program.lanes:
            yield self._apart()
        if "members" in self.program.lanes:
            yield self._members_apart()
        for form in self.program.lanes:
            yield from self._side_by_side(form)

    def _inline(self, body: list[Node]) -> Function:
        signature = f"static int {self.stem}_inline({self.code.arguments('PK_RESTRICT ')})"
        return Function(signature, body, before="PK_INLINE")

    # -- functions for one state -----------------------------------------------------------------

    def _one(self) -> Iterator[Function]:
        model, pairs = self.model, self.pairs
        inputs = f"const struct {model}_params *p, pk_real t, const pk_real *q, const pk_real *v"
        inputs += ", const pk_real *u"
        if pairs:
            body = ["pk_bits bad = 0;", *unused(self.angles.unused), ""]
            body += grouped(self.angles.statements, "pass", self.uniform)
            body += [f"sc[{i}] = {name};" for i, name in enumerate(pairs)]
            yield Function(
                f"static pk_bits {self.stem}_angles(enum pk_pass pass, {inputs}, "
                "pk_real *PK_RESTRICT sc)",
                [*body, "return bad;"],
                f"Sine and cosine of angles that need no others: {', '.join(pairs)}.",
                "PK_INLINE",
            )
        yield self._pass(inputs)
        call = f"{self.stem}_pass(PK_CAREFULLY, p, t, q, v, u{self.sc}, a)"
        carefully = [*self._with_angles("PK_CAREFULLY", "(void)"), f"return (int){call};"]
        signature = f"static int {self.stem}_carefully({self.code.arguments()})"
        yield Function(signature, carefully, before="PK_RARELY")
        once = f"{self.stem}_pass(PK_ONCE, p, t, q, v, u{self.sc}, a)" + " | far" * bool(pairs)
        again = f"return {self.stem}_carefully(p, t, q, v, u, a);"
        body = self._with_angles("PK_ONCE", "const pk_bits far = ")
        yield self._inline([*body, If(once, [again]), "return 0;"])
        body = [f"return {self.stem}_inline(p, t, q, v, u, a);"]
        yield Function(self.code.declaration("PK_RESTRICT "), body)

    def _pass(self, inputs: str) -> Function:
        algebra, pairs = self.algebra, self.pairs
        body: list[Node] = ["pk_bits bad = 0;", *unused(algebra.unused)]
        if not any(s.kind in (CHECK, TRIG) for s in algebra.statements):
            body += unused(["pass"])
        body += [""] if pairs else []
        body += [f"const pk_real {name} = sc[{i}];" for i, name in enumerate(pairs)]
        body += ["", *grouped(algebra.statements, "pass", self.uniform), "return bad;"]
        sc = ", const pk_real *sc" if pairs else ""
        signature = f"{self.stem}_pass(enum pk_pass pass, {inputs}{sc}, pk_real *PK_RESTRICT a)"
        return Function(f"static pk_bits {signature}", body, self.code.says, "PK_INLINE")

    def _with_angles(self, how: str, before: str) -> list[Node]:
        if not self.pairs:
            return []
        call = f"{before}{self.stem}_angles({how}, p, t, q, v, u, sc)"
        gap = [""] if before == "(void)" else []
        rest = [] if gap else [""]
        return [f"pk_real sc[{len(self.pairs)}];", *gap, f"{call};", *rest]

    # -- functions that compute lanes one by one -------------------------------------------------

    def _apart(self) -> Function:
        n, n_u = self.n, self.n_inputs
        unused = "" if n_u else "(void)u;\n"
        inputs = f"for (i = 0; i < {n_u}; i++)\n        u_[i] = u[i * W + l];"
        body = f"""\
unsigned long long failed = 0;
size_t i, l;

{unused}for (l = 0; l < W; l++) {{
    pk_real q_[{n}], v_[{n}], u_[{n_u or 1}], a_[{n}];

    if (bad && !bad[l])
        continue;
    for (i = 0; i < {n}; i++) {{
        q_[i] = q[i * W + l];
        v_[i] = v[i * W + l];
    }}
    {inputs if n_u else "u_[0] = 0;"}
    if ({self.stem}(p, t[l], q_, v_, u_, a_) != 0) {{
        failed |= 1ull << l;
        continue;
    }}
    for (i = 0; i < {n}; i++)
        a[i * W + l] = a_[i];
}}
return failed;"""
        says = "Lanes one by one: those that are bad, or all if that is NULL. Returns which fail."
        return self._one_by_one("lanes", body, says)

    def _members_apart(self) -> Function:
        body = f"""\
unsigned long long failed = 0;
pk_bits only[64] = {{0}};
struct {self.model}_params p;
size_t k, l;

for (l = 0; l < W; l++) {{
    if (bad && !bad[l])
        continue;
    for (k = 0; k < sizeof p / sizeof(pk_real); k++)
        ((pk_real *)&p)[k] = P[k * W + l];
    only[l] = 1;
    failed |= {self.model}_lanes_apart(W, only, &p, t, q, v, u, a);
    only[l] = 0;
}}
return failed;"""
        return self._one_by_one("members", body)

    def _one_by_one(self, form: str, body: str, says: str = "") -> Function:
        signature = f"{self.model}_{form}_apart(size_t W, const pk_bits *bad"
        signature = f"static unsigned long long {signature}, {self.arguments[form]})"
        return Function(signature, [body], says)

    # -- functions that compute all lanes together -----------------------------------------------

    def _side_by_side(self, form: str) -> Iterator[Function]:
        of = "p" if form == "lanes" else "P"
        name = f"{self.model}_{form}"
        restrict = self.arguments[form].replace("pk_real *a", "pk_real *PK_RESTRICT a")
        apart = f"{name}_apart(W, NULL, {of}, t, q, v, u, a)"
        body = [*self._loops(form, of)] if self.plain else [f"return {apart};"]
        yield Function(
            f"static unsigned long long {name}_inline(size_t W, {restrict})",
            body,
            SIDE_BY_SIDE if form == self.program.lanes[0] else "",
            "PK_INLINE",
        )
        signature = f"unsigned long long {name}({self.arguments[form]})"
        yield Function(signature, [f"return {name}_inline(PK_LANES, {of}, t, q, v, u, a);"])

    def _loops(self, form: str, of: str) -> Iterator[Node]:
        count, n = len(self.pairs), self.n
        yield "pk_bits bad[64], any = 0;"
        if self.pairs:
            yield f"pk_real sc[{count} * 64];"
        yield ""
        if self.pairs:
            call = f"{self.stem}_angles({self._lane(self.angles, form)}, sc_)"
            lane = [*self._own_state(self.angles, form), f"pk_real sc_[{count}];"]
            lane.append(f"bad[l] = {call};")
            lane += [f"sc[{i} * W + l] = sc_[{i}];" for i in range(count)]
            yield from ("PK_LANE_LOOP", Loop(EACH_LANE, lane))
        lane = self._own_state(self.algebra, form)
        if self.pairs:
            lane.append(Declare("const pk_real", f"sc_[{count}]", _places("sc", count)))
        sc = ", sc_" if self.pairs else ""
        call = f"{self.stem}_pass({self._lane(self.algebra, form)}{sc}, a_)"
        lane.append(f"pk_real a_[{n}];")
        lane.append(f"bad[l] {'|=' if self.pairs else '='} {call};")
        lane.append("any |= bad[l];")
        lane += [f"a[{i} * W + l] = a_[{i}];" for i in range(n)]
        yield from ("PK_LANE_LOOP", Loop(EACH_LANE, lane))
        if form == "lanes" and self.uniform:
            all_apart = f"return {self.model}_lanes_apart(W, NULL, p, t, q, v, u, a);"
            yield If(f"!({' && '.join(self.uniform)})", [all_apart])
        yield f"return any ? {self.model}_{form}_apart(W, bad, {of}, t, q, v, u, a) : 0;"

    def _own_state(self, part: LanePart, form: str) -> list[Node]:
        """Returns the statements that load the elements of a lane's state, and those parameters of
        the lane, that the loop `part` uses."""
        sizes = {"q": self.n, "v": self.n, "u": self.n_inputs}
        found: list[Node] = [
            f"const pk_real {x}_[{size}] = {_places(x, size)};"
            for x, size in sizes.items()
            if x in part.uses
        ]
        fields = used_fields(self.program, part)
        if form == "members" and fields:
            found.append(f"struct {self.model}_params p;")
            found += [f"p.{field} = P[{k} * W + l];" for field, k in fields]
        return found

    def _lane(self, part: LanePart, form: str) -> str:
        """Returns the arguments of a call for one lane: an enum pk_pass, the parameters, t, and the
        state of the lane."""
        state = ", ".join(x + "_" * (x in part.uses) for x in ("q", "v", "u"))
        if form == "lanes":
            return f"PK_IN_LANE, p, t[l], {state}"
        return f"PK_IN_MEMBER, {'&p' if used_fields(self.program, part) else 'NULL'}, t[l], {state}"


def _places(array: str, count: int) -> str:
    """Returns the C initializer of lane l's copy of an array: {q[0 * W + l], q[1 * W + l], ...}."""
    return "{" + ", ".join(f"{array}[{i} * W + l]" for i in range(count)) + "}"


@record
class LanePart:
    """The statements of one loop over lanes; the arguments of the function are divided into those
    that the statements use, and `unused` ones."""

    statements: tuple[Statement, ...]
    uses: tuple[str, ...]
    unused: tuple[str, ...]

    @staticmethod
    def of(statements: Iterable[Statement]) -> LanePart:
        """Returns the part with these statements, without loads of values that no other statement
        of the part reads."""
        body = list(statements)
        words = _read(s for s in body if s.kind != LOAD)
        body = [s for s in body if s.kind != LOAD or s.target in words]
        words = _read(body)
        arguments = ("p", "t", "q", "v", "u")
        return LanePart(
            tuple(body),
            tuple(a for a in arguments if a in words),
            tuple(a for a in arguments if a not in words),
        )


def lane_parts(kernel: Kernel) -> tuple[LanePart, LanePart, tuple[str, ...]]:
    """Returns the first loop over lanes (sines and cosines), the second loop, and the names of the
    variables that the first loop computes for the second. Two short loop bodies let a processor
    overlap several iterations."""
    made = {x for s in kernel.statements if s.kind in (LOCAL, TRIG) for x in s.defines}
    leading = [s for s in kernel.statements if s.kind == TRIG and not made & _read([s])]
    loads = [s for s in kernel.statements if s.kind == LOAD]
    rest = [s for s in kernel.statements if s not in leading]
    pairs = tuple(name for s in leading for name in s.defines)
    return LanePart.of([*loads, *leading] if leading else []), LanePart.of(rest), pairs


def _read(statements: Iterable[Statement]) -> set[str]:
    return {name for s in statements for value in s.values for name in value.names}


def used_fields(program: Program, part: LanePart) -> list[tuple[str, int]]:
    """Returns the members of struct NAME_params that a part reads: C text, and the index of the
    number in the struct."""
    places = {name: k for k, name in enumerate(program.parameter_names)}
    places |= {x.c_name: len(places) + k for k, x in enumerate(program.constants)}
    n, end = len(program.equations.coordinates), len(program.parameter_names)
    end += len(program.constants) + (n * n + n if program.factored else 0)
    places |= {f"side_[{k}]": end + k for k in range(len(program.equations.switches))}
    used = {read for s in part.statements for read in s.reads}
    return [(name, k) for name, k in places.items() if f"p->{name}" in used]
