"""The C text of vectors and totals: loops over chunks of rows, and over pairs.

A chunk's terms are written to the buffer e; then each row is a sum of elements of e.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ....graph.affine import OTHER, Affine, variable
from ....middle.families.indexed_ir import Group
from ..tree import If, Loop, Node, Scope, rendered
from .kernels import Goal, Terms, of_second
from .kicks import drift, kick
from .places import M, Places
from .rows import Rows, unused


class VectorText(Rows):
    """The C text of one vector of a model."""

    @property
    def functions(self) -> str:
        """Returns the functions NAME_ends, of what is added to rows one by one, and those by which
        steps kick and drift."""
        text = self.ends_function() if self.has_ends else ""
        return text + (kick(self) + drift(self) if self.of.kicks else "")

    def body(self, out: Sequence[str], bad: str = "") -> str:
        """Returns the C lines that compute the vector, in a function that has `x`; out[k] is the
        array of output k. A mass that is not positive sets the variable `bad`."""
        of, scalars = self.of, len(self.scalars) * self.of.outputs
        head: list[Node] = []
        if self.values:
            head.append(f"pk_real e[{self.values * self.width}];")
        if scalars:
            head.append(f"pk_real scalars[{scalars}] = {{0}};")
        if self.to_scalars:
            head.append(f"pk_real sums[{scalars}][8] = {{{{0}}}};")
        head += self.added_to("PTRDIFF_MIN", "PTRDIFF_MAX", "scalars" if scalars else "NULL")
        if self.is_direct:
            return "\n".join(rendered(self._direct(out)))
        loop = [*self._chunks(out, bad)]
        if loop:
            names = ["from", "n", *["k"] * bool(of.families), *["known = 0"] * bool(self.halo)]
            loop = [f"ptrdiff_t {', '.join(names)};", "", *loop]
        more: list[Node] = []
        if of.finish == "STORE" and self.has_ends:
            more += self._stored(out)
        for number, g in enumerate(of.scalars):
            more += self._scalar(number, g, out, bad)
        for terms in of.of(4):
            more += self._pairs(terms, out)
        body = [*head, *(loop if not more else [Scope(loop)] if loop else []), *more]
        return "\n".join(rendered([*body, *unused(("x", *out), body)]))

    @property
    def is_direct(self) -> bool:
        """Whether each row is one value of one term, which writes the rows itself."""
        of, goals = self.of, self.of.goals
        cells = {(goal.to[0][0], goal.output) for goal in goals}
        return (
            of.finish == "STORE"
            and not (self.has_ends or of.scalars or of.of(4))
            and len(goals) == len(cells) > 0
            and len(goals) == len(of.families) * of.outputs
            and len(goals) == sum(len(terms.nodes) for terms in of.terms)
            and all(goal.sign > 0 and goal.to[0][1] == M for goal in goals)
            and all(self._is_whole(goal) for goal in goals)
        )

    def _is_whole(self, goal: Goal) -> bool:
        ends = self.ends[goal.to[0][0]]
        return tuple(map(self.index, goal.terms.over)) == (ends.lo, ends.hi)

    def _direct(self, out: Sequence[str]) -> Iterator[Node]:
        """Yields the loops in which terms write rows."""
        yield "ptrdiff_t from, n;"
        yield ""
        groups = {g.name: g for g in self.of.families}
        for terms in self.of.terms:
            goals = sorted(self.of.goals_of(terms), key=lambda x: x.value)
            lo, hi = map(self.index, terms.over)
            to = [f"{out[x.output]} + {self.place(groups[x.to[0][0]], 'from')}" for x in goals]
            body = [
                f"pk_real *const o[] = {{{', '.join(to)}}};",
                f"n = pk_step(from, {lo}, {hi});",
                f"{self.model}_{terms.name}(x, 0, from, n, o);",
            ]
            yield Loop(f"from = {lo}; from <= {hi}; from += n", [Scope(body)])

    def _chunks(self, out: Sequence[str], bad: str) -> Iterator[Node]:
        if not self.of.families and not self.to_scalars:
            return
        first, last = self.range
        known = " + known" if self.halo else ""
        more = f"n + {self.halo} - known" if self.halo else "n"
        body: list[Node] = [f"n = pk_least({self.chunk}, {last} + 1 - from);"]
        body += self.fills(f"from{self.minus}{known}", more, f"e{known}", self.width)
        for number, g in enumerate(self.of.families):
            body += self._family(number, g, out, bad)
        for goal in self.to_scalars:
            start = (self.first[goal.terms.name] + goal.value) * self.width
            number = self.scalars.index(goal.to[0][0]) * self.of.outputs + goal.output
            row = f"e + {start}" if start else "e"
            body.append(f"pk_add_up({row}{known}, {more}, {goal.sign}, sums[{number}]);")
        if self.halo:
            body.append(f"pk_keep(e, {self.values}, {self.width}, n, {self.halo});")
            body.append(f"known = {self.halo};")
        yield Loop(f"from = {first}; from <= {last}; from += n", [Scope(body)])

    def _family(self, number: int, g: Group, out: Sequence[str], bad: str) -> Iterator[Node]:
        values, (low, high) = self.rows(g, self.width), self.clip(g)
        place = self.place(g, "from")
        where = f"[{place} + k]"
        if self.of.finish == "STORE":
            stores = [f"{out[k]}{where} = {value};" for k, value in enumerate(values)]
            yield from self.lane_loop(low, high, stores)
            return
        quotient = self.of.finish == "QUOTIENT"
        mass = values[1] if quotient else values[0]
        force = f"({values[0]})" if quotient else f"{out[0]}{where}"
        slow: list[Node] = []
        if self.has_ends:
            width = str(self.chunk)
            slow = [f"pk_real r[{self.of.outputs * self.chunk}];", ""]
            slow += self.buffered(number, values, low, high, width)
            mass = f"r[{width} + k]" if quotient else "r[k]"
            force = "r[k]" if quotient else force
        lines = [f"const pk_real M = {mass};", *[f"{bad} |= !(M > 0);"] * bool(bad)]
        lines.append(f"{out[0]}{where} = {force} / M;")
        loop = self.lane_loop(low, high, lines)
        yield from [Scope([*slow, *loop])] if slow else loop

    def _stored(self, out: Sequence[str]) -> Iterator[Node]:
        """Yields the lines that add to single rows."""
        for number, g in enumerate(self.of.families):
            arrays = ", ".join(out)
            place = self.place(g, "added[k].i")
            add = f"to[added[k].output][{place}] += added[k].value;"
            yield Scope(
                [
                    f"pk_real *const to[] = {{{arrays}}};",
                    "int k;",
                    "",
                    Loop("k = 0; k < n_added; k++", [If(f"added[k].family == {number}", [add])]),
                ]
            )

    def _scalar(self, number: int, g: Group, out: Sequence[str], bad: str) -> Iterator[Node]:
        first = number * self.of.outputs
        if self.to_scalars:
            for k in range(first, first + self.of.outputs):
                yield f"scalars[{k}] += pk_whole(sums[{k}]);"
        at = f"[{self.index(self.places.first[g.name])}]"
        if self.of.finish == "STORE":
            for k in range(self.of.outputs):
                yield f"{out[k]}{at} = scalars[{first + k}];"
            return
        quotient = self.of.finish == "QUOTIENT"
        mass = f"scalars[{first + quotient}]"
        if bad:
            yield f"{bad} |= !({mass} > 0);"
        yield f"{out[0]}{at} = {f'scalars[{first}]' if quotient else f'{out[0]}{at}'} / {mass};"

    def _pairs(self, terms: Terms, out: Sequence[str]) -> Iterator[Node]:
        lines: list[Node] = []
        added: list[str] = []
        for goal in self.of.goals_of(terms):
            (name, at), sign = goal.to[0], "-" if goal.sign < 0 else "+"
            own = self.places.first[name]
            if of_second(goal.to[0]):
                place = own + at.replaced({OTHER: variable("from")}) - self._lo(name)
                where = f"{out[goal.output]} + {self.index(place)}"
                if terms.added:
                    added.append(f"o[{len(terms.nodes) + len(added)}] = {where};")
                    continue
                text = f"{out[goal.output]}[{self.index(place)} + k] {sign}= o[{goal.value}][k];"
                lines.append(Loop("k = 0; k < n; k++", [text]))
                continue
            place = own if at is None else own + at - self._lo(name)
            lines.append(
                Scope(
                    [
                        "pk_real eight[8] = {0};",
                        f"pk_add_up(o[{goal.value}], n, 1, eight);",
                        f"{out[goal.output]}[{self.index(place)}] {sign}= pk_whole(eight);",
                    ]
                )
            )
        yield Scope([*pair_loop(self.model, self.places, terms, lines, added)])

    def _lo(self, name: str) -> Affine:
        return next(g.lo for g in self.of.families if g.name == name)


def pair_loop(
    model: str, places: Places, terms: Terms, lines: Sequence[Node], added: Sequence[str] = ()
) -> Iterator[Node]:
    """Yields the lines that evaluate terms of pairs, n at a time, and use them by `lines`: value k
    is o[k][0], o[k][1], ... The lines `added` set the arrays to which terms add values."""
    lo, hi, first, last = map(places.index, terms.over)
    count = len(terms.nodes)
    to = ", ".join(f"pairs + {k} * PK_BLOCK" if k else "pairs" for k in range(count))
    room = f"o[{count + len(added)}]" if added else "const o[]"
    yield f"pk_real pairs[{count} * PK_BLOCK], *{room} = {{{to}}};"
    yield f"ptrdiff_t m, from, n{', k' if any(isinstance(x, Loop) for x in lines) else ''};"
    yield ""
    inner = [
        f"n = pk_least(PK_BLOCK, {last} + 1 - from);",
        *added,
        f"{model}_{terms.name}(x, m, from, n, o);",
        *lines,
    ]
    yield Loop(
        f"m = {lo}; m <= {hi}; m++",
        [Loop(f"from = {first}; from <= {last}; from += n", [Scope(inner)])],
    )
