"""Series: Taylor coefficients of nodes in the time since t, as lines of C.

Coefficient k of a node follows from the coefficients up to k of its arguments. Reference: A. Jorba
and M. Zou, Experimental Mathematics 14 (2005), pages 99-117, section 3.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence

from ...functions import FUNCTIONS
from ...functions import SIDE as SIDE_OF
from ...graph.graph import MINUS_ONE, Node, Op
from .expressions import Code
from .rewrite import SIDE, Workspace


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


def _names(lines: Iterable[str]) -> Iterator[str]:
    """Yields the names in lines of C, without the orders of coefficients."""
    for line in lines:
        yield from re.findall(r"[A-Za-z]\w*?(?=_0\b|_##|\b)", line)
