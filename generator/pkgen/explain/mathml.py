"""SymPy expressions and the names of a model as MathML, which browsers draw without any script.

theta1' is a theta with a dot and an index, p_x and q[i+1] have subscripts. The elements are
SymPy's, but for its names of symbols. Reference: MathML Core, https://www.w3.org/TR/mathml-core/
"""

from __future__ import annotations

import re
from functools import cache
from html import escape, unescape
from typing import TYPE_CHECKING
from xml.dom.minidom import Element, parseString

from ..front.words import greek

if TYPE_CHECKING:
    import sympy

INVISIBLE_TIMES = "\u2062"
_ENTITY = re.compile(r"&(?!amp;|lt;|gt;)\w+;")  # HTML has them; XML has not, nor need we
_NAME = re.compile(r"([^\W\d]+?)(?:_?(\d+))?(?:_(\w+))?('*)")
_MEMBER = re.compile(r"(\w+)\[(.*)\]('*)")
# What the language spells out, by its letters.
_GREEK = {greek(c): c for c in map(chr, range(ord("Α"), ord("ω") + 1)) if greek(c)}
_DOTS = {1: "˙", 2: "¨"}


def block(content: str) -> str:
    """A line of its own, which can be scrolled where it is too long."""
    return f'<div class="equation"><math display="block">{content}</math></div>'


def inline(content: str) -> str:
    return f"<math>{content}</math>"


def row(*parts: str) -> str:
    return f"<mrow>{''.join(parts)}</mrow>"


def operator(sign: str) -> str:
    return f"<mo>{escape(sign)}</mo>"


def words(text: str) -> str:
    return f"<mtext>{escape(text)}</mtext>"


def equation(left: str, right: str) -> str:
    return row(left, operator("="), right)


def matrix(rows: list[list[str]]) -> str:
    """In brackets that are borders: a font need not have any that stretch."""
    body = "".join(
        f"<mtr>{''.join(f'<mtd>{entry}</mtd>' for entry in entries)}</mtr>" for entries in rows
    )
    return f'<mtable class="matrix">{body}</mtable>'


def total(over: str, body: str) -> str:
    """A sum with its range below the sign."""
    return row(f"<munder>{operator('∑')}{words(over)}</munder>", body)


def plus(parts: list[str]) -> str:
    return row(*(operator("+") + part if k else part for k, part in enumerate(parts)))


def name(text: str) -> str:
    """A name as it stands in a model, with primes, an index, or both."""
    member = _MEMBER.fullmatch(text)
    if member:
        base, index, primes = member.groups()
        return _sub(_dotted(name(base), len(primes)), _list(index))
    plain = _NAME.fullmatch(text)
    if not plain:
        return _identifier(text)
    base, digits, rest, primes = plain.groups()
    lower = "".join([f"<mn>{digits}</mn>" if digits else "", name(rest) if rest else ""])
    letter = _dotted(_identifier(base), len(primes))
    return _sub(letter, row(lower)) if lower else letter


def _list(text: str) -> str:
    """An index: i+1, or two with a comma."""
    return row(*(_index(part) for part in re.split(r"(, |[-+*])", text)))


def _index(part: str) -> str:
    if part in (", ", "+", "-", "*"):
        return operator(part.strip())
    return f"<mn>{part}</mn>" if part.isdigit() else name(part)


def _identifier(text: str) -> str:
    return f"<mi>{_GREEK.get(text, escape(text))}</mi>"


def _sub(base: str, below: str) -> str:
    return f"<msub>{base}{below}</msub>"


def _dotted(letter: str, primes: int) -> str:
    if not primes:
        return letter
    dots = _DOTS.get(primes, "'" * primes)
    return f'<mover>{letter}<mo stretchy="false">{dots}</mo></mover>'


def expression(expr: sympy.Expr) -> str:
    element = _printer()._print(expr)
    text = _with_brackets(element).toxml()
    return _ENTITY.sub(lambda found: unescape(found[0]), text)


def _with_brackets(element: Element) -> Element:
    """Brackets as operators. SymPy 1.11 has them as mfenced, which browsers no longer draw."""
    for child in [*element.childNodes]:
        if child.nodeType == child.ELEMENT_NODE:
            element.replaceChild(_with_brackets(child), child)
    if element.tagName != "mfenced":
        return element
    drawn = Element("mrow")
    sign = parseString("<all><mo>(</mo><mo>,</mo><mo>)</mo></all>").documentElement
    left, comma, right = sign.childNodes
    left.firstChild.data = element.getAttribute("open") or "("
    right.firstChild.data = element.getAttribute("close") or ")"
    inside = [*element.childNodes]
    drawn.appendChild(left)
    for k, child in enumerate(inside):
        if k:
            drawn.appendChild(comma.cloneNode(True))
        drawn.appendChild(child)
    drawn.appendChild(right)
    return drawn


@cache
def _printer():
    import sympy as sp
    from sympy.printing.mathml import MathMLPresentationPrinter

    class Printer(MathMLPresentationPrinter):
        def _print_Symbol(self, symbol, style: str = "plain"):
            return parseString(name(symbol.name)).documentElement

        def _print_Heaviside(self, call):
            return self._print(sp.Function("step")(call.args[0]))

    return Printer({"mul_symbol": INVISIBLE_TIMES})
