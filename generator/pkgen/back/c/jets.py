"""Jets: the Taylor coefficients of a motion, in C.

Each node of M and f is a series in the time since t. Coefficient k of a node
follows from the coefficients up to k of its arguments. This module writes one line of C for each
node; the C preprocessor repeats the lines for each order k. The coefficients of a follow order by
order from M a = f, whose M is factored once. Reference: A. Jorba and M. Zou, Experimental
Mathematics 14 (2005), pages 99-117, section 3.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

from ...equations import Equations
from ...functions import FUNCTIONS
from ...functions import SIDE as SIDE_OF
from ...graph.graph import MINUS_ONE, ZERO, Kind, Node, Op, Symbol
from .ctext import fold, fold_call
from .expressions import Code
from .jet_loops import LONGEST, looped
from .jet_wide import Wide, wide
from .rewrite import SIDE, Workspace

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
    """The lines of C of series. lines() returns two lists: of coefficients 0, of coefficients k."""

    def __init__(
        self, work: Workspace, leaf: Callable[[Node], Code | None], state: dict[Node, str]
    ):
        self.work, self.leaf, self.of = work, leaf, dict(state)
        self._made: list[tuple[str, str, str]] = []  # a series, and its two lines or ""
        self._pairs: dict[tuple[str, str], tuple[str, str]] = {}
        self._products: dict[tuple[str, str], str] = {}
        self._scaled: dict[str, tuple[str, str]] = {}  # series that are a factor times another
        self._weighted: dict[str, str] = {}

    def add(self, roots: Iterable[Node]) -> None:
        """Adds the series of the roots and of all nodes below them."""
        for node in self.work.reachable(roots):
            if not self.work.fixed[node] and node not in self.of and not self._side(node):
                self.of[node] = self._series(node)

    def _side(self, node: Node) -> str:
        """Returns the C text of the side of a switch, which is constant; "" for other nodes."""
        w = self.work
        if w.op[node] is Op.MULTIPLY and w.args[node][0] == MINUS_ONE:
            side = self._side(w.args[node][1])
            return f"-{side}" if side else ""
        return str(self.leaf(node)) if getattr(w.data[node], "kind", "") is SIDE else ""

    def zero(self, node: Node) -> str:
        """Returns the C text of coefficient 0."""
        if node in self.of:
            return f"{self.of[node]}_0"
        plain = self.work.negated(node)  # constants are hoisted without their sign
        return f"({self.leaf(node)})" if plain is None else f"(-{self.leaf(plain)})"

    def at(self, node: Node) -> str:
        """Returns the C text of coefficient k > 0."""
        return f"{self.of[node]}_##pk_k" if node in self.of else "0"

    def lines(self, ends: list[str]) -> tuple[list[str], list[str]]:
        """Returns the lines of the series that others, or `ends`, need. A coefficient of a late
        order may still be unused."""
        needed, size = set(_names(ends)), 0
        while size < len(needed):  # some series need each other
            size = len(needed)
            for name, *lines in reversed(self._made):
                needed.update(_names(lines) if name in needed else ())
        found = [made for made in self._made if made[0] in needed]
        unused = [f" (void){name}_##pk_k;" for name, _, _ in found]
        return [first for _, first, _ in found if first], [
            later + more for (_, _, later), more in zip(found, unused, strict=True) if later
        ]

    def _set(self, name: str, first: str, later: str) -> str:
        first, later = (
            f"const pk_real {name}_0 = {first};",
            f"const pk_real {name}_##pk_k = {later};",
        )
        self._made.append((name, first, later))
        return name

    def _series(self, node: Node) -> str:
        w, x = self.work, f"x{node}"
        op, args = w.op[node], w.args[node]
        function = str(w.data[node]).removeprefix(SIDE_OF)
        if op is Op.CALL and FUNCTIONS[function].kinked:
            sided = function != w.data[node]
            return self.branch(x, function, self._side(args[0]) if sided else "0", args[sided:])
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
            return self._set(x, f"{factor}{moving[0]}_0", f"{factor}{moving[0]}_##pk_k")
        if op is Op.MULTIPLY:
            return self.product(x, *moving)
        a = moving[0]
        if op is Op.POWER:  # rewrite() leaves no other power
            return self.reciprocal(x, a)
        return FUNCTIONS[function].series(self, x, a, *zeros[1:])

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
            self._products[key] = self._set(y, f"{a}_0 * {b}_0", later)
        y = self._products[key]
        if not factor:
            return y
        self._scaled[x] = factor, y
        return self._set(x, f"{factor}{y}_0", f"{factor}{y}_##pk_k")

    def branch(self, x: str, function: str, side: str, args: Sequence[Node]) -> str:
        """Returns the series of a function with a kink: of the branch on a side of its switch, or,
        without a side, of the branch at coefficient 0."""
        row = FUNCTIONS[function]
        named = dict(zip(row.arguments, args, strict=True))
        place = " - ".join(map(self.zero, args))
        place = place if side == "0" else f"({side} ? {side} : {place})"
        above = f"const int {x}above = {place} > 0;"
        self._made.append((f"{x}above", above, ""))
        ends = [(b[:-1] if b[1:] else "", b[-1]) for b in (row.kinked.above, row.kinked.below)]
        zeros = [sign + self.zero(named[b]) if b in named else sign + b for sign, b in ends]
        at = [sign + self.at(named[b]) if b in named else "0" for sign, b in ends]
        return self._set(x, f"{x}above ? {zeros[0]} : {zeros[1]}", f"{x}above ? {at[0]} : {at[1]}")

    def reciprocal(self, x: str, a: str) -> str:
        return self._set(x, f"1 / {a}_0", f"-PK_JET_TAIL(pk_k, {a}, {x}) * {x}_0")

    def weighted(self, a: str) -> str:
        """Returns the series of j a_j."""
        if a not in self._weighted:
            self._weighted[a] = f"{a}d"
            self._made.append((f"{a}d", "", f"const pk_real {a}d_##pk_k = pk_k * {a}_##pk_k;"))
        return self._weighted[a]

    def pair(self, sine: str, cosine: str, sign: str, x: str, a: str) -> tuple[str, str]:
        """Returns the series of sin and cos, or with sign "" of sinh and cosh, of a."""
        if (sine, a) not in self._pairs:
            d, s, c = self.weighted(a), f"{x}s", f"{x}c"
            self._set(s, f"PK_F({sine})({a}_0)", f"PK_JET_PART(pk_k, {d}, {c})")
            self._set(c, f"PK_F({cosine})({a}_0)", f"{sign}PK_JET_PART(pk_k, {d}, {s})")
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
        self._set(square, f"{x}_0 * {x}_0", f"PK_JET_TIMES(pk_k, {x}, {x})")
        return x

    def atan(self, x: str, a: str) -> str:
        by = self._set(f"{x}q", f"1 + {a}_0 * {a}_0", f"PK_JET_TIMES(pk_k, {a}, {a})")
        return self.solved(x, f"PK_F(atan)({a}_0)", a, by)


LETTERS = {Kind.COORDINATE: "q", Kind.RATE: "v"}


def jet(
    e: Equations,
    work: Workspace,
    roots: list[Node],
    leaf: Callable[[Node], Code | None],
    places: Mapping[str, int] | None,
) -> tuple[str, str]:
    """Returns the C functions NAME_jet, and NAME_jet_wide for members in lanes or "". `roots` are
    the nodes of rows(), rewritten; `places` has the index of each member of the params, or is None
    if there are no lanes."""
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
    head = fold_call(signature(name, "PK_RESTRICT "))
    factor, solved = [*solver.factor()], [*solver.later(force)]
    of_first, of_later = series.lines([*factor, *solver.first(force), *solved])
    first += [*of_first, *factor, "(void)p, (void)t, (void)u;"]
    first.append(f"if (order < 1 || order > {ORDER}) return order != 0;")
    start = [*solver.first(force), *ends]
    later = [*of_later, *solved, *ends]
    if sum("PK_JET_" in line for line in later) > LONGEST:
        return looped(head, name, first, start, later), ""
    body = [
        *first,
        f"{name}_JET_0(0, 1)",
        *(f"{name}_JET_K({k}, {k + 1})" for k in range(1, ORDER)),
        "return 0;",
    ]
    text = "".join(
        (
            _sums(),
            _macro(f"{name}_JET_0(pk_k, pk_k1)", start),
            _macro(f"{name}_JET_K(pk_k, pk_k1)", later),
            head + "\n{\n",
            "\n".join(fold(line, 4) for line in body),
            "\n}\n",
        )
    )
    if places is None or any(line.startswith("const int") for line in first):
        return text, ""  # lanes may be on different branches of a function with a kink
    of = Wide(own, places)
    macros = (
        _macro(f"{name}_JET_WIDE{end}(pk_k, pk_k1)", map(of.line, lines))
        for end, lines in (("_0", start), ("", later))
    )
    return text, wide(name, of, first, *macros, ORDER)


def _names(lines: Iterable[str]) -> Iterator[str]:
    """Yields the names in lines of C, without the orders of coefficients."""
    for line in lines:
        yield from re.findall(r"[A-Za-z]\w*?(?=_0\b|_##|\b)", line)


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


def _macro(head: str, lines: Iterable[str]) -> str:
    """Returns a macro of several lines."""
    found = "\n".join(fold(line, 4) for line in lines).split("\n")
    return "\n".join(f"{x:<98} \\" for x in [f"#define {head}", *found[:-1]]) + f"\n{found[-1]}\n"


class _Solver:
    """The lines of C that solve M a = f by M = L D L^T. Only entries of L that may be nonzero are
    written: lIkK in row I, column K. M is factored once, at the start."""

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
                known = [f"g{i}k{j} * l{k}k{j}" for j in row if j in self.below[k]]
                yield f"const pk_real g{i}k{k} = {' - '.join([entry, *known])};"
                yield f"const pk_real l{i}k{k} = g{i}k{k} * inverse{k};"
            diagonal = self.series.zero(self.mass[i * (self.n + 1)])
            known = [f"g{i}k{k} * l{i}k{k}" for k in row]
            yield f"const pk_real d{i} = {' - '.join([diagonal, *known])}, inverse{i} = 1 / d{i};"
            least = f"PK_PIVOT_MIN * {diagonal}" if row else "0"
            yield f"if (!(d{i} > {least})) return PK_FAILED(PK_FAILURE_MASS, {i});"

    def solve(self, right: Callable[[int], str]) -> Iterator[str]:
        """Yields the lines of a_##pk_k, for the right-hand sides of each row of M a = f."""
        for i, row in enumerate(self.below):
            known = [f"l{i}k{k} * y{k}_##pk_k" for k in row]
            yield f"const pk_real y{i}_##pk_k = {' - '.join([right(i), *known])};"
        for i in reversed(range(self.n)):
            known = [f"l{k}k{i} * a{k}_##pk_k" for k in range(i, self.n) if i in self.below[k]]
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
