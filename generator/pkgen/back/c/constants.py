"""Gives each hoisted constant a name and a comment, both made from its expression."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping

from ...graph.graph import Node, Op
from ...record import record
from .expressions import Code, Form, added, atom, called, code, constant, inverted, multiplied
from .expressions import negated as minus
from .names import Names
from .rewrite import Workspace

_LONGEST_NAME = 24
_LONGEST_COMMENT = 60
_SCALED = {"2": "twice", "PK_C(0.5)": "half"}


@record
class Constant:
    """A hoisted constant: `c_name` is its member of struct NAME_params; `says` is its expression as
    text, "" if the text is too long."""

    c_name: str
    says: str


def constants(
    work: Workspace,
    nodes: list[Node],
    leaf: Callable[[Node], Code | None],
    names: Names,
    hints: Mapping[Node, str],
) -> list[Constant]:
    """Returns the hoisted constants whose values are `nodes`, in the same order. `leaf` returns the
    C text of a leaf of the graph. `hints` gives names, such as M_0_0, for nodes whose expression
    yields no short name."""
    forms: dict[Node, Form | None] = {}
    made: dict[Node, Constant] = {}
    wanted = set(nodes)
    for node in work.reachable(nodes):
        form = forms[node] = _form(work, node, leaf, forms)
        if node not in wanted:
            continue
        wish = (form and _name(form)) or hints.get(node, "")
        good = wish and len(wish) <= _LONGEST_NAME and names.is_free(wish)
        name = names.take(wish) if good else names.number("c")
        text = code(form) if form else ""
        made[node] = Constant(name, text if len(text) <= _LONGEST_COMMENT else "")
        forms[node] = atom(Code(name, (name,)))
    return [made[node] for node in nodes]


def _form(
    work: Workspace,
    node: Node,
    leaf: Callable[[Node], Code | None],
    forms: Mapping[Node, Form | None],
) -> Form | None:
    """Returns the expression of a node, or None if it is too long for a comment."""
    op, args = work.op[node], work.args[node]
    if work.is_leaf(node):
        text = leaf(node)
        assert text is not None
        text = text.replace("p->", "")
        return constant(text) if op is Op.NUMBER else atom(Code(text, (text,)))
    parts = [forms[a] for a in args]
    if any(part is None for part in parts) or sum(p.length for p in parts) > _LONGEST_COMMENT:
        return None
    if (core := work.negated(node)) is not None:
        return minus(forms[core])
    if op is Op.CALL:
        return called(str(work.data[node]), parts, "")
    return {Op.ADD: added, Op.MULTIPLY: multiplied, Op.POWER: inverted}[op](*parts)


def _name(form: Form) -> str:
    """Returns a short name for the value of the expression, such as m2_l1_l2, l1_sq, g_per_l,
    half_M_0_0 or I1_minus_I3; "" if there is none."""
    if form.is_sum:
        if len(form.terms) != 2 or not all(_is_name(x) for _, x in form.terms):
            return ""
        (sign, a), (other, b) = sorted(form.terms, key=lambda term: -term[0])
        return f"{a}_{'plus' if other > 0 else 'minus'}_{b}" if sign > 0 else ""
    above = list(form.above)
    scale = [_SCALED[x] for x in above if x in _SCALED][:1]
    top = _product(x for x in above if x not in _SCALED)
    below = _product(form.below)
    if top is None or below is None or len(above) - len(scale) > 4 or ("half" in scale and below):
        return ""
    if above == ["1"]:
        return f"inv_{below}"
    return "_".join([*scale, *([top] if top else []), *(["per", below] if below else [])])


def _product(factors: Iterable[Code]) -> str | None:
    counts = Counter(x for x in factors if x != "1")
    if not all(map(_is_name, counts)) or any(n > 2 for n in counts.values()):
        return None
    return "_".join(x if n == 1 else f"{x}_sq" for x, n in counts.items())


def _is_name(x: Code) -> bool:
    return x.isidentifier() and not x.startswith("PK_")
