"""Jets: the Taylor coefficients of a motion, in C.

Each node of M and f is a series in the time since t. Coefficient k of a node
follows from the coefficients up to k of its arguments. This module writes one line of C for each
node; the C preprocessor repeats the lines for each order k. The coefficients of a follow order by
order from M a = f, whose M is factored once. Reference: A. Jorba and M. Zou, Experimental
Mathematics 14 (2005), pages 99-117, section 3.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

from ...equations import Equations
from ...graph.graph import MINUS_ONE, ZERO, Kind, Node, Op, Symbol
from .ctext import fold, fold_call
from .expressions import Code
from .rewrite import Workspace

ORDER = 30  # the largest order
# Sums of a_j b_(k-j), where k is a literal and a_0, a_1, ... are variables: of all j, of j >= 1, of
# these over k (where a_j is j times a coefficient), and of 0 < j < k.
_SUMS = """\
#define PK_JET_TIMES(k, a, b) (a##_0 * b##_##k + PK_JET_TAIL(k, a, b))
#define PK_JET_TAIL(k, a, b) (PK_JET_MIDDLE_##k(a, b) + a##_##k * b##_0)
#define PK_JET_PART(k, a, b) (PK_JET_TAIL(k, a, b) * PK_JET_OVER(k))
#define PK_JET_MIDDLE(k, a, b) PK_JET_MIDDLE_##k(a, b)
#define PK_JET_OVER(k) (PK_C(1.0) / (k))
#define PK_JET_MIDDLE_1(a, b) PK_C(0.0)
"""


class Series:
    """The lines of C of series: `first` computes their coefficients 0, `later` coefficients k."""

    def __init__(
        self, work: Workspace, leaf: Callable[[Node], Code | None], state: dict[Node, str]
    ):
        self.work, self.leaf, self.of = work, leaf, dict(state)
        self.first: list[str] = []
        self.later: list[str] = []
        self._pairs: dict[tuple[str, str], tuple[str, str]] = {}
        self._weighted: dict[str, str] = {}

    def add(self, roots: Iterable[Node]) -> None:
        """Adds the series of the roots and of all nodes below them."""
        for node in self.work.reachable(roots):
            if not self.work.fixed[node] and node not in self.of:
                self.of[node] = self._series(node)

    def zero(self, node: Node) -> str:
        """Returns the C text of coefficient 0."""
        if node in self.of:
            return f"{self.of[node]}_0"
        plain = self.work.negated(node)  # constants are hoisted without their sign
        return f"({self.leaf(node)})" if plain is None else f"(-{self.leaf(plain)})"

    def at(self, node: Node) -> str:
        """Returns the C text of coefficient k > 0."""
        return f"{self.of[node]}_##pk_k" if node in self.of else "0"

    def _set(self, name: str, first: str, later: str, beside: bool = False) -> str:
        """Adds a series; one `beside` another may be used up to a lower order, or not at all."""
        self.first.append(f"const pk_real {name}_0 = {first};")
        self.later.append(f"const pk_real {name}_##pk_k = {later};")
        if beside:
            self.first.append(f"(void){name}_0;")
            self.later.append(f"(void){name}_##pk_k;")
        return name

    def _series(self, node: Node) -> str:
        w, x = self.work, f"x{node}"
        op, args = w.op[node], w.args[node]
        zeros = [self.zero(a) for a in args]
        moving = [self.of[a] for a in args if a in self.of]
        if op is Op.SYMBOL:  # t
            return self._set("time", "t", "pk_k == 1")
        if op is Op.ADD:
            return self._set(x, " + ".join(zeros), " + ".join(f"{a}_##pk_k" for a in moving))
        if op is Op.MULTIPLY and len(moving) == 1:
            factor = "-" if args[0] == MINUS_ONE else f"{zeros[args[0] in self.of]} * "
            return self._set(x, f"{factor}{moving[0]}_0", f"{factor}{moving[0]}_##pk_k")
        if op is Op.MULTIPLY:
            return self._set(x, " * ".join(zeros), f"PK_JET_TIMES(pk_k, {', '.join(moving)})")
        a = moving[0]
        if op is Op.POWER:  # rewrite() leaves no other power
            return self.reciprocal(x, a)
        return FUNCTIONS[w.data[node]](self, x, a, *zeros[1:])

    def reciprocal(self, x: str, a: str) -> str:
        return self._set(x, f"1 / {a}_0", f"-PK_JET_TAIL(pk_k, {a}, {x}) * {x}_0")

    def weighted(self, a: str) -> str:
        """Returns the series of j a_j."""
        if a not in self._weighted:
            self._weighted[a] = f"{a}d"
            self.later.append(f"const pk_real {a}d_##pk_k = pk_k * {a}_##pk_k; (void){a}d_##pk_k;")
        return self._weighted[a]

    def pair(self, sine: str, cosine: str, sign: str, x: str, a: str) -> tuple[str, str]:
        """Returns the series of sin and cos, or with sign "" of sinh and cosh, of a."""
        if (sine, a) not in self._pairs:
            d, s, c = self.weighted(a), f"{x}s", f"{x}c"
            self._set(s, f"PK_F({sine})({a}_0)", f"PK_JET_PART(pk_k, {d}, {c})", True)
            self._set(c, f"PK_F({cosine})({a}_0)", f"{sign}PK_JET_PART(pk_k, {d}, {s})", True)
            self._pairs[sine, a] = s, c
        return self._pairs[sine, a]

    def exp(self, x: str, a: str) -> str:
        return self._set(x, f"PK_F(exp)({a}_0)", f"PK_JET_PART(pk_k, {self.weighted(a)}, {x})")

    def solved(self, x: str, first: str, a: str, by: str) -> str:
        """Returns the series of x with x' by = a'."""
        self._set(
            x, first, f"({a}_##pk_k - PK_JET_MIDDLE(pk_k, {x}d, {by}) * PK_JET_OVER(pk_k)) / {by}_0"
        )
        self.weighted(x)
        return x

    def log(self, x: str, a: str) -> str:
        return self.solved(x, f"PK_F(log)({a}_0)", a, a)

    def sqrt(self, x: str, a: str) -> str:
        later = f"({a}_##pk_k - PK_JET_MIDDLE(pk_k, {x}, {x})) / (2 * {x}_0)"
        return self._set(x, f"PK_F(sqrt)({a}_0)", later)

    def pow(self, x: str, a: str, exponent: str) -> str:
        d = self.weighted(a)
        sums = f"({exponent} + 1) * PK_JET_PART(pk_k, {d}, {x}) - PK_JET_TAIL(pk_k, {a}, {x})"
        return self._set(x, f"PK_F(pow)({a}_0, {exponent})", f"({sums}) / {a}_0")

    def tangent(self, function: str, sign: str, x: str, a: str) -> str:
        """Returns the series of tan or tanh, whose rate is (1 + x^2) a' or (1 - x^2) a'."""
        d, square = self.weighted(a), f"{x}q"
        self._set(
            x,
            f"PK_F({function})({a}_0)",
            f"{a}_##pk_k {sign} PK_JET_PART(pk_k, {d}, {square})",
        )
        self._set(square, f"{x}_0 * {x}_0", f"PK_JET_TIMES(pk_k, {x}, {x})", True)
        return x

    def atan(self, x: str, a: str) -> str:
        by = self._set(f"{x}q", f"1 + {a}_0 * {a}_0", f"PK_JET_TIMES(pk_k, {a}, {a})", True)
        return self.solved(x, f"PK_F(atan)({a}_0)", a, by)


FUNCTIONS: dict[str, Callable[..., str]] = {
    "sin": lambda s, x, a: s.pair("sin", "cos", "-", x, a)[0],
    "cos": lambda s, x, a: s.pair("sin", "cos", "-", x, a)[1],
    "sinh": lambda s, x, a: s.pair("sinh", "cosh", "", x, a)[0],
    "cosh": lambda s, x, a: s.pair("sinh", "cosh", "", x, a)[1],
    "reciprocal": Series.reciprocal,
    "exp": Series.exp,
    "log": Series.log,
    "sqrt": Series.sqrt,
    "pow": Series.pow,
    "tan": lambda s, x, a: s.tangent("tan", "+", x, a),
    "tanh": lambda s, x, a: s.tangent("tanh", "-", x, a),
    "atan": Series.atan,
}


LETTERS = {Kind.COORDINATE: "q", Kind.RATE: "v"}


def jet(
    e: Equations, work: Workspace, roots: list[Node], leaf: Callable[[Node], Code | None]
) -> str:
    """Returns the C function NAME_jet. `roots` are the nodes of rows(), rewritten. The functions
    NAME_factor and NAME_solved are needed unless M is diagonal."""
    name, n, own = e.model.name, len(e.force), e.own
    state = {
        node: f"{LETTERS[symbol.kind]}{symbol.index}"
        for node in work.reachable(roots)
        if isinstance(symbol := work.data[node], Symbol) and symbol.kind in LETTERS
    }
    series = Series(work, leaf, state)
    series.add(roots)
    mass, force = roots[: n * n], roots[n * n :]
    x = [*(f"q{i}" for i in range(own)), *(f"v{i}" for i in range(n))]
    ends = [f"const pk_real v{i}_##pk_k1 = a{i}_##pk_k * PK_JET_OVER(pk_k1);" for i in range(n)]
    ends += [f"const pk_real q{i}_##pk_k1 = v{i}_##pk_k * PK_JET_OVER(pk_k1);" for i in range(own)]
    ends += [f"c[{len(x)} * pk_k1 + {i}] = {name}_##pk_k1;" for i, name in enumerate(x)]
    ends.append("if (order == pk_k1) return 0;")
    solves = _solution(name, n, mass, force, series)
    first = [f"const pk_real {z}_0 = {z[0]}[{z[1:]}];" for z in x]
    first += [f"c[{i}] = {z}_0;" for i, z in enumerate(x)]
    body = [
        *first,
        *series.first,
        *_factor(name, n, mass, series),
        "(void)p, (void)t, (void)u;",
        f"if (order < 1 || order > {ORDER}) return order != 0;",
        f"{name}_JET_0(0, 1)",
        *(f"{name}_JET_K({k}, {k + 1})" for k in range(1, ORDER)),
        "return 0;",
    ]
    return "".join(
        (
            _sums(),
            _macro(f"{name}_JET_0(pk_k, pk_k1)", [*solves(0), *ends]),
            _macro(f"{name}_JET_K(pk_k, pk_k1)", [*series.later, *solves(1), *ends]),
            fold_call(signature(name, "PK_RESTRICT ")) + "\n{\n",
            "\n".join(fold(line, 4) for line in body),
            "\n}\n",
        )
    )


def signature(name: str, restrict: str = "") -> str:
    return (
        f"int {name}_jet(const struct {name}_params *p, pk_real t, const pk_real *q, "
        f"const pk_real *v, const pk_real *u, int order, pk_real *{restrict}c)"
    )


def _sums() -> str:
    """Returns the macros of sums. A sum has two parts, which a processor adds up side by side."""
    found = [_SUMS]
    for k in range(2, ORDER):
        terms = [f"a##_{j} * b##_{k - j}" for j in range(1, k)]
        parts = (" + ".join(x) for x in (terms[::2], terms[1::2]) if x)
        found.append(
            _macro(f"PK_JET_MIDDLE_{k}(a, b)", [f"({' + '.join(f'({x})' for x in parts)})"])
        )
    return "".join(found) + "\n"


def _macro(head: str, lines: list[str]) -> str:
    """Returns a macro of several lines."""
    found = "\n".join(fold(line, 4) for line in lines).split("\n")
    return "\n".join(f"{x:<98} \\" for x in [f"#define {head}", *found[:-1]]) + f"\n{found[-1]}\n"


def _factor(name: str, n: int, mass: list[Node], series: Series) -> list[str]:
    """Returns the lines that factor M, or invert a diagonal M."""
    values = ", ".join(series.zero(node) for node in mass)
    if is_diagonal(mass, n):
        failed = "return PK_FAILED(PK_FAILURE_MASS, {});"
        found = [(f"inverse{i}", series.zero(mass[i * n + i])) for i in range(n)]
        lines = [f"const pk_real {x} = 1 / {value};" for x, value in found]
        return lines + [f"if (!({x} > 0)) {failed.format(i)}" for i, (x, _) in enumerate(found)]
    return [
        f"pk_real M[{n * n}] = {{{values}}}, inverse[{n}], a[{n}];",
        f"{name}_factor(M, inverse);",
    ]


def _solution(
    name: str, n: int, mass: list[Node], force: list[Node], series: Series
) -> Callable[[int], Iterator[str]]:
    """Returns a function that yields the lines of a_##pk_k, for k = 0 or (1) for k > 0."""

    def right(i: int, k: int) -> str:
        terms = [series.zero(force[i]) if not k else series.at(force[i])]
        for j in range(n) if k else ():
            if mass[i * n + j] in series.of:
                terms.append(f"PK_JET_TAIL(pk_k, {series.of[mass[i * n + j]]}, a{j})")
        return " - ".join(terms)

    def lines(k: int) -> Iterator[str]:
        if is_diagonal(mass, n):
            for i in range(n):
                yield f"const pk_real a{i}_##pk_k = ({right(i, k)}) * inverse{i};"
            return
        yield f"pk_real f_##pk_k[{n}] = {{{', '.join(right(i, k) for i in range(n))}}};"
        yield f"const int failed_##pk_k = {name}_solved(M, inverse, f_##pk_k, a);"
        yield "if (failed_##pk_k) return failed_##pk_k;"
        for i in range(n):
            yield f"const pk_real a{i}_##pk_k = a[{i}];"

    return lines


def is_diagonal(mass: list[Node], n: int) -> bool:
    return all(node == ZERO for i, node in enumerate(mass) if i % (n + 1))
