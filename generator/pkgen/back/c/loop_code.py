"""The C text of models whose families (arrays of coordinates, such as q[i]) are loops.

A row is the equation of one member of a family; a row function computes a row, and loops call it.
A total is a sum over members; a double loop computes forces between pairs. Templates call the
methods of `LoopCode`, which return C text.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from .kernel_code import statements
from .loops import Block
from .loops_before import Before
from .loops_plan import Rates
from .loops_sets import PairSet, RowSet, TotalSet
from .program import Statement
from .tree import Declare, Function, If, Loop, Node, Scope, Text, rendered

STATE = "p, t, q, v, u"
KICKED = "p, t, q, q, u"  # If forces do not depend on v, any array may be passed as v.
ONE_CELL = "ptrdiff_t m, pk_real *r"


def _pairwise(name: str, texts: Sequence[str]) -> str:
    first, *rest = texts
    return f"{name}({first}, {_pairwise(name, rest)})" if rest else first


def _stated(lines: Sequence[str]) -> list[Node]:
    return [f"{line.removesuffix(';')};" for line in lines]


class LoopCode:
    """The C code of the loops in one model."""

    def __init__(self, name: str, before: Before):
        self.name = name
        self._before = before
        state = "pk_real t, const pk_real *q, const pk_real *v, const pk_real *u"
        self.ARGS = f"const struct {name}_params *p, {state}"
        self.unused = "(void)p, (void)t, (void)q, (void)v, (void)u;"

    # -- text of a few nodes ------------------------------------------------------------------

    def lines(self, found: Sequence[Statement], indent: int = 4) -> str:
        return "\n".join(rendered(statements(found), indent))

    def most(self, texts: Sequence[str], which: str) -> str:
        """Returns a C expression: if `which` is "most" the greatest of the index expressions
        `texts`, if it is "least" the smallest."""
        return _pairwise(f"{self.name}_{which}", [*dict.fromkeys(texts)])

    def edge(self, s: RowSet) -> str:
        return f"{self.name}_{s.name}_{'edge' if s.ghosts else 'part'}"

    @staticmethod
    def scaled(s: RowSet) -> str:
        """Returns the C expression of a row's value in the interior. The row function computes
        r[0], which is multiplied by the common factor of all rows, if there is one."""
        return f"{s.scale.value} * r[0]" if s.scale else "r[0]"

    # -- functions of a row -------------------------------------------------------------------

    def row_functions(self, s: RowSet) -> str:
        """Returns the C functions that compute the row of one member. NAME_inner is for members
        away from the ends. If it returns a nonzero value, an angle was too large for the inline
        sine, and NAME_part must be called, which is for any member. NAME_edge also adds the rows of
        the ghost cells (indices beyond an end) that copy the member. NAME_bond computes the forces
        between two neighbours."""
        stem = f"{self.name}_{s.name}"
        inline = "PK_INLINE static pk_bits"
        found = []
        if s.flux:
            signature = f"{inline} {stem}_bond({self.ARGS}, ptrdiff_t m, pk_real *flux)"
            found.append(Function(signature, self._in_lane(s.flux)))
        flux = ", const pk_real *flux" if s.flux else ""
        signature = f"{inline} {stem}_inner({self.ARGS}{flux}, {ONE_CELL})"
        found.append(Function(signature, self._in_lane(s.inner)))
        found.append(Function(f"static void {stem}_part({self.ARGS}, {ONE_CELL})", self._part(s)))
        if s.ghosts:
            signature = f"static void {stem}_edge({self.ARGS}, {ONE_CELL})"
            found.append(Function(signature, self._edge(s, stem)))
        return "".join(f"{function.text}\n" for function in found)

    def part_function(self, s: RowSet) -> str:
        """Returns only NAME_part of row_functions(), which is half as long, for rows that are
        computed rarely."""
        signature = f"static void {self.name}_{s.name}_part({self.ARGS}, {ONE_CELL})"
        return f"{Function(signature, self._part(s)).text}\n"

    def _in_lane(self, block: Block) -> list[Node]:
        body = [Declare("pk_bits", "far", "0")] if block.trig else []
        body += [self.unused, "(void)m;", *statements(block.statements, "PK_IN_LANE", "far")]
        return [*body, f"return {'far' if block.trig else 0};"]

    def _part(self, s: RowSet) -> list[Node]:
        body = [self.unused, *(f"r[{k}] = 0;" for k in range(s.outputs))]
        body.append("(void)m;")
        for g in s.guarded:
            condition = f"m >= {g.lo} && m <= {g.hi}"
            body.append(If(condition, [Scope([*statements(g.block.statements)])]))
        return body

    def _edge(self, s: RowSet, stem: str) -> list[Node]:
        group, outputs = s.group, s.outputs
        lo, hi = group["lo"], group["hi"]
        end = f"{hi} + {s.above}"
        home = f"{self.name}_home_{group['name']}(p, i)"
        cell = [
            If(f"i == {lo}", [f"i = {hi} + 1;"]),
            If(f"i > {end} || {home} != m", ["continue;"]),
            f"{stem}_part({STATE}, i, g);",
            *(f"r[{k}] += g[{k}];" for k in range(outputs)),
        ]
        return [
            Declare("pk_real", f"g[{outputs}]"),
            Declare("ptrdiff_t", "i"),
            "",
            f"{stem}_part({STATE}, m, r);",
            "/* Ghosts alone: cells beyond an end. */",
            Loop(f"i = {lo} - {s.below}; i <= {end}; i++", cell),
        ]

    # -- loops over rows ----------------------------------------------------------------------

    def _chunks(self, begin: str, end: str, body: Callable[[str], list[Node]]) -> list[Node]:
        """Returns loops over the indices `begin` .. `end` - 1, in chunks of constant length except
        the last. `body` takes the end of a chunk as C text, and returns the loop over the chunk."""
        length = f"{self.name}_CHUNK"
        step = f"chunk = {begin}; chunk + {length} <= {end}; chunk += {length}"
        return [Loop(step, body(f"chunk + {length}")), If(f"chunk < {end}", body(end))]

    def bonds(self, s: RowSet, begin: str, end: str, arguments: str = STATE) -> list[Node]:
        """Returns loops that compute the forces of the bonds (pairs of neighbours) with the indices
        `begin` .. `end` - 1, and store them in the C array flux."""
        return self._chunks(begin, end, lambda last: [self._bonds(s, "chunk", last, arguments)])

    def _bonds(self, s: RowSet, begin: str, end: str, arguments: str) -> Node:
        place = f"flux + (m - base + {self.name}_BOND)"
        call = f"{self.name}_{s.name}_bond({arguments}, m, {place})"
        noted = f"far |= {call};" if s.flux_trig else f"(void){call};"
        return Loop(f"m = {begin}; m < {end}; m++", [noted])

    def rows(
        self,
        s: RowSet,
        begin: str,
        end: str,
        inside: Sequence[str],
        outside: Sequence[str] = (),
        arguments: str = STATE,
        first: Sequence[Node] = (),
        then: Sequence[str] = (),
    ) -> list[Node]:
        """Returns loops over the rows `begin` .. `end` - 1 of the interior, in chunks. Each chunk
        has the declarations `first`, a loop over rows with the statements `inside` after each row,
        and a loop over rows with the statements `then`. If an angle is too large for the inline
        sine, the rows of the chunk are computed again, with the statements `outside` after each
        row."""
        place = f"flux + (m - base + {self.name}_BOND), " if s.flux else ""
        call = f"{self.name}_{s.name}_inner({arguments}, {place}m, r)"
        noted = f"far |= {call};" if s.inner.trig else f"(void){call};"
        row = Declare("pk_real", f"r[{s.outputs}]")

        def chunk(last: str) -> list[Node]:
            each = f"m = chunk; m < {last}; m++"
            nodes = list(first)
            if s.trig:
                nodes.append(Declare("pk_bits", "far", "0"))
            if s.flux_trig:
                nodes.append(self._bonds(s, f"chunk - {s.span}", last, arguments))
            nodes.append(Loop(each, [row, noted, *_stated(inside)]))
            if s.trig:
                again = [row, f"{self.edge(s)}({arguments}, m, r);", *_stated(outside)]
                nodes.append(Loop(f"m = chunk; far && m < {last}; m++", again))
            return [*nodes, Loop(each, _stated(then))] if then else nodes

        return self._chunks(begin, end, chunk)

    def flux(self, s: RowSet) -> list[Node]:
        """Returns the declaration of the array of the bond forces that a block of rows reads; [] if
        the rows have none."""
        length = f"{s.n_flux} * ({self.name}_BLOCK + {self.name}_BOND)"
        return [Declare("pk_real", f"flux[{length}]")] if s.flux else []

    def row_loop(self, s: RowSet, inside: Sequence[str], outside: Sequence[str]) -> str:
        """Returns loops that compute the rows of all members of a family. The statements `outside`
        follow each row near an end, the statements `inside` each row in the interior."""
        row = Declare("pk_real", f"r[{s.outputs}]")
        at_end = [row, f"{self.edge(s)}({STATE}, m, r);", *_stated(outside)]
        block = f"{self.name}_BLOCK"
        stop = f"{self.name}_least(base + {block}, hi + 1)"
        span = [*self.flux(s), Declare("const ptrdiff_t", "stop", stop)]
        if s.bonds:
            span += self.bonds(s, f"base - {s.span}", "stop")
        span += self.rows(s, "base", "stop", inside, outside)
        body = [
            *self._ends(s, f"{s.group['hi']} + 1"),
            Declare("ptrdiff_t", "m, base, chunk"),
            "",
            Loop(f"m = {s.group['lo']}; m < lo && m < end; m++", at_end),
            Loop(f"base = m; base <= hi; base += {block}", span),
            Loop(f"m = {self.most(('m', 'hi + 1'), 'most')}; m < end; m++", at_end),
        ]
        return "\n".join(rendered([Scope(body)])) + "\n"

    def _ends(self, s: RowSet, end: str) -> list[Node]:
        """Returns the declarations of C indices: `end` is one more than the last row, `lo` and `hi`
        are the first and last row of the interior."""
        return [
            Declare("const ptrdiff_t", "end", end),
            Declare("const ptrdiff_t", "lo", self.most(s.lows, "most")),
            Declare("const ptrdiff_t", "hi", self.most(s.highs, "least")),
        ]

    # -- statements before rows ---------------------------------------------------------------

    def before(self, *functions: str) -> str:
        """Returns the C lines that compute the values which rows of the given functions read (see
        loops_before.py)."""
        lines = dict.fromkeys(line for f in functions for line in self._before.lines(f))
        return "".join(f"    {line}\n" for line in lines)

    def rate_function(self, key: str, x: Rates) -> str:
        """Returns a C function that computes the rates of a first-order state. It stores them in an
        array, from which rows of other variables read them."""
        if x.rows:
            found, store = self.row_functions(x.rows), [f"out[{x.group['cell']}] = r[0];"]
            rows: Node = Text(self.row_loop(x.rows, store, store))
        else:
            own = f"{self.name}_total_rate_{key}"
            found = self.total_function(x.total, f"static pk_real {own}({self.ARGS})")
            rows = f"out[{x.group['first']}] = {own}({STATE});"
        body = [
            Declare("pk_real *const", "out", f"{self.name}_rated(p)"),
            "",
            rows,
            *(Text(self.pair_loop(pair, "out")) for pair in x.pairs),
        ]
        says = f"The rates of {x.group['shown']}, which others have in them."
        signature = f"static void {self.name}_rate_{key}({self.ARGS})"
        return found + Function(signature, body, says).text

    # -- totals and pairs ---------------------------------------------------------------------

    def total_function(self, x: TotalSet, signature: str, key: str = "") -> str:
        """Returns a C function that computes a total. Eight partial sums let compilers vectorize
        it, and reduce the rounding error. The function begins with the lines of before(key)."""
        body = [
            Declare("pk_real", "total"),
            "",
            self.unused,
            *_stated([*self._before.lines(key)]),
            *statements(x.constant.statements),
        ]
        if x.rows:
            body.append(self._eight_sums(x.rows))
        for pair in x.pairs:
            one = [Declare("pk_real", "r[1]"), *statements(pair.block.statements)]
            inner = Loop(self._over_j(pair), [*one, "total += r[0];"])
            outer = Loop(self._over_m(pair), [inner])
            body.append(Scope([Declare("ptrdiff_t", "m, j"), outer]))
        functions = self.row_functions(x.rows) if x.rows else ""
        return functions + Function(signature, [*body, "return total;"]).text

    def _eight_sums(self, s: RowSet) -> Scope:
        stem = f"{self.name}_{s.name}"
        part = [f"{stem}_part({STATE}, m, r);", "total += r[0];"]
        eight = "l = 0; l < 8; l++"
        call = f"{stem}_inner({STATE}, m + l, x + l)"
        if s.inner.trig:
            work = [
                Declare("pk_bits", "far", "0"),
                Loop(eight, [f"far |= {call};"]),
                Loop("l = 0; far && l < 8; l++", [f"{stem}_part({STATE}, m + l, x + l);"]),
            ]
        else:
            work = [Loop(eight, [f"(void){call};"])]
        added = Loop(eight, ["s[l] += x[l];"])
        total = "((s[0] + s[1]) + (s[2] + s[3])) + ((s[4] + s[5]) + (s[6] + s[7]))"
        begin = self.most(s.firsts, "least")
        return Scope(
            [
                *self._ends(s, f"{self.most(s.lasts, 'most')} + 1"),
                Declare("pk_real", "s[8] = {0, 0, 0, 0, 0, 0, 0, 0}, r[1]"),
                Declare("ptrdiff_t", "m, l"),
                "",
                Loop(f"m = {begin}; m < lo && m < end; m++", part),
                Loop("; m + 7 <= hi; m += 8", [Declare("pk_real", "x[8]"), *work, added]),
                Loop("; m < end; m++", part),
                f"total += {total};",
            ]
        )

    @staticmethod
    def _over_m(pair: PairSet) -> str:
        return f"m = {pair.lo}; m <= {pair.hi}; m++"

    @staticmethod
    def _over_j(pair: PairSet) -> str:
        return f"j = {pair.first}; j <= {pair.last}; j++"

    def pair_loop(self, x: PairSet, array: str) -> str:
        """Returns a double loop over pairs of members (m, j). The forces on member m are first
        summed in local variables; the force on member j is added to `array` directly."""
        count = len(x.block.targets)
        pair = [Declare("pk_real", f"r[{count}]"), *statements(x.block.statements)]
        pair += [f"own[{k}] += r[{k}];" for k in x.own]
        pair += [f"{array}[{at}] += r[{k}];" for k, at in x.other.items()]
        row = [Declare("pk_real", f"own[{count}]", "{0}")] if x.own else []
        row.append(Loop(self._over_j(x), pair))
        row += [f"{array}[{at}] += own[{k}];" for k, at in x.own.items()]
        body = [Declare("ptrdiff_t", "m, j"), Loop(self._over_m(x), [Scope(row)])]
        return "\n".join(rendered([Scope(body)])) + "\n"

    # -- kicks --------------------------------------------------------------------------------

    def kicks(self, s: RowSet, drift: str = "") -> str:
        """Returns loops of the kick v += h a, with the step h, over the members `from` .. `to` - 1.
        The statement `drift` follows each kick. If rows may be computed twice, because of large
        angles, v is changed only after the rows of the whole chunk are known."""
        v = f"v[{s.group['cell']}]"
        if s.trig:
            own = [Declare("pk_real", f"a[{self.name}_CHUNK]")]
            inside, again = f"a[m - chunk] = {self.scaled(s)};", "a[m - chunk] = r[0] / r[1];"
            then = f"{v} += h * a[m - chunk];"
            nodes = self.rows(s, "from", "to", [inside], [again], KICKED, own, [then])
        else:
            scale = [Declare("const pk_real", "g", f"h * {s.scale.value}")] if s.scale else []
            inside = [f"{v} += {'g' if s.scale else 'h'} * r[0];", *([drift] if drift else [])]
            nodes = [*scale, *self.rows(s, "from", "to", inside, arguments=KICKED)]
        return "\n".join(rendered(nodes)) + "\n"

    def kicked_bonds(self, s: RowSet) -> str:
        """Returns loops that compute the bonds of the rows `begin` .. `stop` - 1. The first loop
        ends at a boundary of a cache line of bonds; the others compute chunks of bonds."""
        first, line = f"begin - {s.span}", f"{self.name}_line(begin - {s.span}, from)"
        nodes = [
            Declare("const ptrdiff_t", "base", "from"),
            Declare("const ptrdiff_t", "whole", self.most(("stop", line), "least")),
            Declare("ptrdiff_t", "m, chunk"),
            self._bonds(s, first, "whole", KICKED),
            *self.bonds(s, "whole", "stop", KICKED),
        ]
        return "\n".join(rendered(nodes, 8)) + "\n"
