"""The kernel `jet` in C: the Taylor coefficients of a motion.

Coefficients of M and f are made by the lines of jets.Series, which the C preprocessor repeats for
each order k. The coefficients of a follow order by order from M a = f, whose M is factored once.
Straight-line code is fastest as long as it fits into the instruction cache; for higher orders there
is a loop over the orders.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping

from ...equations import Equations
from ...graph.graph import ZERO, Kind, Node, Symbol
from ...record import record
from .ctext import fold, fold_call
from .expressions import Code
from .jet_loops import looped
from .jet_wide import Wide, wide
from .jets import Series
from .rewrite import Workspace

# The number of products in straight-line code that fits into an instruction cache of 32 kB, beside
# the rest of a step; a product takes 17 bytes.
FITS = 1700
LEAST = 4  # the least order for which straight-line code is worth while
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


@record
class Jet:
    """The C functions: of one state, with straight-line code up to the order `fast`; of states in
    lanes, or ""."""

    one: str
    fast: int
    wide: str = ""


LETTERS = {Kind.COORDINATE: "q", Kind.RATE: "v"}


def jet(
    e: Equations,
    work: Workspace,
    roots: list[Node],
    leaf: Callable[[Node], Code | None],
    places: Mapping[str, int] | None,
) -> Jet:
    """Returns the C functions NAME_jet and NAME_jet_wide. `roots` are the nodes of rows(),
    rewritten; `places` has the index of each member of the params, or is None if there are no
    lanes."""
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
    fast = _fast(later)
    if fast < LEAST:
        return Jet(looped(head, name, first, start, later), 0)
    others, body = "", [*first]
    if fast < ORDER:
        of_loops = signature(name, "PK_RESTRICT ").replace("_jet(", "_jet_loops(")
        others = looped(fold_call(f"static {of_loops}"), name, first, start, later) + "\n"
        arguments = "p, t, q, v, u, order, c"
        body.insert(0, f"if (order > {fast}) return {name}_jet_loops({arguments});")
    body += [
        f"{name}_JET_0(0, 1)",
        *(f"{name}_JET_K({k}, {k + 1})" for k in range(1, fast)),
        "return 0;",
    ]
    text = "".join(
        (
            others,
            _sums(fast),
            _macro(f"{name}_JET_0(pk_k, pk_k1)", start),
            _macro(f"{name}_JET_K(pk_k, pk_k1)", later),
            head + "\n{\n",
            "\n".join(fold(line, 4) for line in body),
            "\n}\n",
        )
    )
    if places is None or any(line.startswith("const int") for line in first):
        return Jet(text, fast)  # lanes may be on different branches of a function with a kink
    of = Wide(own, places)
    macros = (
        _macro(f"{name}_JET_WIDE{end}(pk_k, pk_k1)", map(of.line, lines))
        for end, lines in (("_0", start), ("", later))
    )
    return Jet(text, fast, wide(name, of, first, *macros, fast))


def _fast(later: list[str]) -> int:
    """Returns the order up to which straight-line code fits into the instruction cache."""
    sums = re.findall(r"PK_JET_(\w+)\(pk_k,", " ".join(later))
    each = sum(0.5 if x in ("SQUARE", "HALF") else 1 for x in sums)
    return max(k for k in range(ORDER + 1) if each * k * (k + 1) / 2 <= FITS)


def signature(name: str, restrict: str = "") -> str:
    return (
        f"int {name}_jet(const struct {name}_params *p, pk_real t, const pk_real *q, "
        f"const pk_real *v, const pk_real *u, int order, pk_real *{restrict}c)"
    )


def _sums(orders: int) -> str:
    """Returns the macros of sums. A sum has two parts, which a processor adds up side by side."""
    found = [_SUMS]
    for k in range(2, orders):
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
