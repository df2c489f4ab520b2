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
from ...functions import FUNCTIONS
from ...graph.graph import MINUS_ONE, ZERO, Kind, Node, Op, Symbol
from .ctext import fold, fold_call
from .expressions import Code
from .rewrite import Workspace

ORDER = 30  # the largest order
# Sums of a_j b_(k-j), where k is a literal and a_0, a_1, ... are variables: of all j, of j >= 1, of
# these over k (where a_j is j times a coefficient), and of 0 < j < k. The newest coefficients come
# last, so that a processor can add up the rest before they are known.
_SUMS = """\
#ifndef PK_JET_ADD /* a b + c, by one instruction where the processor has it */
#if defined PK_PORTABLE || defined PK_LONG_DOUBLE || defined PK_FLOAT128
#define PK_JET_ADD(a, b, c) ((a) * (b) + (c))
#elif defined PK_FLOAT ? defined FP_FAST_FMAF : defined FP_FAST_FMA
#define PK_JET_ADD(a, b, c) PK_F(fma)(a, b, c)
#else
#define PK_JET_ADD(a, b, c) ((a) * (b) + (c))
#endif
#endif
#define PK_JET_TIMES(k, a, b) PK_JET_ADD(a##_0, b##_##k, PK_JET_TAIL(k, a, b))
#define PK_JET_TAIL(k, a, b) PK_JET_ADD(a##_##k, b##_0, PK_JET_MIDDLE_##k(a, b))
#define PK_JET_SQUARE(k, a) (2 * PK_JET_ADD(a##_0, a##_##k, PK_JET_HALF_##k(a)))
#define PK_JET_PART(k, a, b) (PK_JET_TAIL(k, a, b) * PK_JET_OVER(k))
#define PK_JET_HALF(k, a) PK_JET_HALF_##k(a)
#define PK_JET_MIDDLE(k, a, b) PK_JET_MIDDLE_##k(a, b)
#define PK_JET_OVER(k) (PK_C(1.0) / (k))
#define PK_JET_MIDDLE_1(a, b) PK_C(0.0)
#define PK_JET_HALF_1(a) PK_C(0.0)
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
        self._products: dict[tuple[str, str], str] = {}
        self._scaled: dict[str, tuple[str, str]] = {}  # series that are a factor times another
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
            factor = "- " if args[0] == MINUS_ONE else f"{zeros[args[0] in self.of]} * "
            before, base = self._scaled.get(moving[0], ("", moving[0]))
            self._scaled[x] = factor + before, base
            return self._set(x, f"{factor}{moving[0]}_0", f"{factor}{moving[0]}_##pk_k", True)
        if op is Op.MULTIPLY:
            return self.product(x, *moving)
        a = moving[0]
        if op is Op.POWER:  # rewrite() leaves no other power
            return self.reciprocal(x, a)
        return FUNCTIONS[w.data[node]].series(self, x, a, *zeros[1:])

    def product(self, x: str, a: str, b: str) -> str:
        """Returns the series of a b, x or an earlier one. Constant factors of a and b are taken out
        of it; the squares of cos and sin differ by a sign for k > 0."""
        (factor, a), (other, b) = (self._scaled.get(y, ("", y)) for y in (a, b))
        key, factor = (min(a, b), max(a, b)), factor + other
        if key not in self._products:
            later = f"PK_JET_SQUARE(pk_k, {a})" if a == b else f"PK_JET_TIMES(pk_k, {a}, {b})"
            for (of, _), (sine, cosine) in self._pairs.items():
                square = self._products.get((sine, sine))
                if a == b == cosine and square:
                    later = f"{'-' if of == 'sin' else ''}{square}_##pk_k"
            y = f"{x}b" if factor else x
            self._products[key] = self._set(y, f"{a}_0 * {b}_0", later, a == b)
        y = self._products[key]
        if not factor:
            return y
        self._scaled[x] = factor, y
        return self._set(x, f"{factor}{y}_0", f"{factor}{y}_##pk_k", True)

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
        later = f"(PK_C(0.5) * {a}_##pk_k - PK_JET_HALF(pk_k, {x})) / {x}_0"
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


LETTERS = {Kind.COORDINATE: "q", Kind.RATE: "v"}


def jet(
    e: Equations, work: Workspace, roots: list[Node], leaf: Callable[[Node], Code | None]
) -> str:
    """Returns the C function NAME_jet. `roots` are the nodes of rows(), rewritten."""
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
    solver = _Solver(n, mass, series)
    first = [f"const pk_real {z}_0 = {z[0]}[{z[1:]}];" for z in x]
    first += [f"c[{i}] = {z}_0;" for i, z in enumerate(x)]
    body = [
        *first,
        *series.first,
        *solver.factor(),
        "(void)p, (void)t, (void)u;",
        f"if (order < 1 || order > {ORDER}) return order != 0;",
        f"{name}_JET_0(0, 1)",
        *(f"{name}_JET_K({k}, {k + 1})" for k in range(1, ORDER)),
        "return 0;",
    ]
    return "".join(
        (
            _sums(),
            _macro(f"{name}_JET_0(pk_k, pk_k1)", [*solver.first(force), *ends]),
            _macro(f"{name}_JET_K(pk_k, pk_k1)", [*series.later, *solver.later(force), *ends]),
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
        terms = [(f"a##_{j}", f"b##_{k - j}") for j in range(1, k)]
        half = [(f"a##_{j}", f"a##_{k - j}") for j in range(1, (k + 1) // 2)]
        half += [(f"PK_C(0.5) * a##_{k // 2}", f"a##_{k // 2}")] if k % 2 == 0 else []
        found.append(_macro(f"PK_JET_MIDDLE_{k}(a, b)", [_sum(terms)]))
        found.append(_macro(f"PK_JET_HALF_{k}(a)", [_sum(half)]))
    return "".join(found) + "\n"


def _sum(terms: list[tuple[str, str]]) -> str:
    found = []
    for part in (terms[::2], terms[1::2]):
        text = ""
        for a, b in part:
            text = f"PK_JET_ADD({a}, {b}, {text})" if text else f"{a} * {b}"
        found += [text] if text else []
    return f"({' + '.join(found)})"


def _macro(head: str, lines: list[str]) -> str:
    """Returns a macro of several lines."""
    found = "\n".join(fold(line, 4) for line in lines).split("\n")
    return "\n".join(f"{x:<98} \\" for x in [f"#define {head}", *found[:-1]]) + f"\n{found[-1]}\n"


class _Solver:
    """The lines of C that solve M a = f by M = L D L^T. Only entries of L that may be nonzero are
    written: l_i_k. M is factored once, at the start."""

    def __init__(self, n: int, mass: list[Node], series: Series):
        self.n, self.mass, self.series = n, mass, series
        self.below: list[list[int]] = []  # the columns of L in each row
        for i in range(n):
            row: list[int] = []
            for k in range(i):
                if mass[i * n + k] != ZERO or {*row} & {*self.below[k]}:
                    row.append(k)
            self.below.append(row)

    def factor(self) -> Iterator[str]:
        for i, row in enumerate(self.below):
            for k in row:
                entry = self.series.zero(self.mass[i * self.n + k])
                known = [f"g_{i}_{j} * l_{k}_{j}" for j in row if j in self.below[k]]
                yield f"const pk_real g_{i}_{k} = {' - '.join([entry, *known])};"
                yield f"const pk_real l_{i}_{k} = g_{i}_{k} * inverse{k};"
            diagonal = self.series.zero(self.mass[i * (self.n + 1)])
            known = [f"g_{i}_{k} * l_{i}_{k}" for k in row]
            yield f"const pk_real d{i} = {' - '.join([diagonal, *known])}, inverse{i} = 1 / d{i};"
            least = f"PK_PIVOT_MIN * {diagonal}" if row else "0"
            yield f"if (!(d{i} > {least})) return PK_FAILED(PK_FAILURE_MASS, {i});"

    def solve(self, right: Callable[[int], str]) -> Iterator[str]:
        """Yields the lines of a_##pk_k, for the right-hand sides of each row of M a = f."""
        for i, row in enumerate(self.below):
            known = [f"l_{i}_{k} * y{k}_##pk_k" for k in row]
            yield f"const pk_real y{i}_##pk_k = {' - '.join([right(i), *known])};"
        for i in reversed(range(self.n)):
            known = [f"l_{k}_{i} * a{k}_##pk_k" for k in range(i, self.n) if i in self.below[k]]
            value = " - ".join([f"y{i}_##pk_k * inverse{i}", *known])
            yield f"const pk_real a{i}_##pk_k = {value};"

    def first(self, force: list[Node]) -> Iterator[str]:
        return self.solve(lambda i: self.series.zero(force[i]))

    def later(self, force: list[Node]) -> Iterator[str]:
        def right(i: int) -> str:
            row = enumerate(self.mass[i * self.n : (i + 1) * self.n])
            moving = [(self.series.of[m], j) for j, m in row if m in self.series.of]
            known = [f"PK_JET_TAIL(pk_k, {m}, a{j})" for m, j in moving]
            return " - ".join([self.series.at(force[i]), *known])

        return self.solve(right)
