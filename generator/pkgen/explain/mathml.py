"""The elements of MathML, and the names of a model in them: browsers draw these without any script.

theta1' is a theta with a dot and an index, p_x and q[i+1] have subscripts, omega(R).x is the x of
omega. Reference: MathML Core, https://www.w3.org/TR/mathml-core/
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable
from html import escape

from ..front.words import greek

NARROW = 24  # letters that any page holds
MINUS = "\u2212"
_TIMES = "\u2062"  # invisible
_APPLY = "\u2061"  # invisible too: of a function
_THIN = '<mspace width="0.17em"></mspace>'
_NAME = re.compile(r"([^\W\d_]+)_?(\d*)(?:_(\w+))?")
_MEMBER = re.compile(r"(\w+)\[(.*)\]")
_COMPONENT = re.compile(r"(.+)\.([xyzw]{1,2})")
_RATE = re.compile(r"omega\((\w+)\)")
_VISIBLE = re.compile(r"<[^>]*>|[\u2061\u2062]")
# What the language spells out, by its letters.
_GREEK = {greek(c): c for c in map(chr, range(ord("Α"), ord("ω") + 1)) if greek(c)}
_TALL = ("<mfrac>", "<msqrt>", "<mtable>", "<munderover>")
_DOTS = {1: "˙", 2: "¨"}


def formula(chunks: Iterable[str], note: str = "") -> str:
    """A line of its own, which breaks between chunks, with words behind it in HTML. With a chunk
    that a narrow page does not hold it can be scrolled, by the keyboard too."""
    chunks = list(chunks)
    parts = [f'<math displaystyle="true">{row(chunk)}</math>' for chunk in chunks]
    parts += [f'<span class="note">{note}</span>'] if note else []
    scrolled = ' tabindex="0"' if max(map(width, chunks)) > NARROW else ""
    return f'<div class="equation"{scrolled}>{" ".join(parts)}</div>'


def inline(content: str) -> str:
    return f"<math>{row(content)}</math>"


def row(*parts: str) -> str:
    """One element."""
    content = "".join(parts)
    whole = content.startswith("<mrow>") and content.find("</mrow>") == len(content) - len(
        "</mrow>"
    )
    return content if whole else f"<mrow>{content}</mrow>"


def operator(sign: str) -> str:
    return f"<mo>{escape(sign.replace('-', MINUS))}</mo>"


def leading(sign: str) -> str:
    """Before the first term."""
    return f'<mo form="prefix" lspace="0" rspace="0.06em">{escape(sign.replace("-", MINUS))}</mo>'


def binary(sign: str) -> str:
    """Between two terms, also where a line breaks before it."""
    return f'<mo form="infix">{escape(sign.replace("-", MINUS))}</mo>'


def number(text: str) -> str:
    """A decimal; its power of ten, if it has one, is written as such."""
    mantissa, e, exponent = text.partition("e")
    shown = mantissa.lstrip("-")
    digits = f"<mn>{shown}</mn>"
    if e:
        ten = f"<msup><mn>10</mn>{number(str(int(exponent)))}</msup>"
        digits = ten if shown == "1" else row(digits, operator("×"), ten)
    return row(leading("-"), digits) if mantissa.startswith("-") else digits


def words(text: str) -> str:
    return f"<mtext>{escape(text)}</mtext>"


_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def unit_text(unit: str) -> str:
    """m/s^2 as m/s², and 1/s as s⁻¹."""
    if unit.startswith("1/") and "/" not in unit[2:] and "*" not in unit:
        base, _, power = unit[2:].partition("^")
        unit = f"{base}^-{power or 1}"
    raised = re.sub(r"\^([-\d]+)", lambda found: found[1].translate(_RAISED), unit)
    return raised.replace("*", "\u2009")


def unit(text: str) -> str:
    """Behind a number."""
    return f"{_THIN}<mtext>{escape(unit_text(text))}</mtext>" if text else ""


def fraction(above: str, below: str, small: bool = False) -> str:
    made = f"<mfrac>{row(above)}{row(below)}</mfrac>"
    return f'<mstyle displaystyle="false">{made}</mstyle>' if small else made


def fenced(content: str, left: str = "(", right: str = ")") -> str:
    """In brackets, which grow with what is taller than letters with indices and powers."""
    grows = "" if any(tall in content for tall in _TALL) else ' stretchy="false"'
    return row(
        f'<mo form="prefix" lspace="0" rspace="0"{grows}>{left}</mo>',
        content,
        f'<mo form="postfix" lspace="0" rspace="0"{grows}>{right}</mo>',
    )


def bars(content: str, bar: str = "|") -> str:
    return fenced(content, bar, bar)


def applied(function: str, argument: str, bracketed: bool) -> str:
    """A function of something, which stands in brackets or after a space."""
    between = f"<mo>{_APPLY}</mo>" + ("" if bracketed else _THIN)
    return row(function, between, fenced(argument) if bracketed else argument)


def product(factors: Iterable[str]) -> str:
    """Side by side; with a space where words would run together."""
    made = ""
    for factor in factors:
        if made:
            spaced = _is_word(made, -1) or _is_word(factor, 0)
            made += f"<mo>{_TIMES}</mo>" + (_THIN if spaced else "")
        made += factor
    return made


def _is_word(content: str, end: int) -> bool:
    """Whether the first or the last thing that is seen of it is a word."""
    letters = [x for x in re.split(r"<[^>]*>", content) if x]
    return bool(letters) and len(letters[end]) > 1 and letters[end].isalpha()


def sub(base: str, below: str) -> str:
    return f"<msub>{base}{row(below)}</msub>"


def sup(base: str, above: str) -> str:
    """A power; one of what has an index stands over the index."""
    if base.startswith("<msub>") and base.endswith("</msub>"):
        return f"<msubsup>{base[len('<msub>') : -len('</msub>')]}{row(above)}</msubsup>"
    return f"<msup>{row(base)}{row(above)}</msup>"


def sums(over: str, lo: str, hi: str) -> str:
    """The sign of a sum with its range."""
    below = row(over, operator("="), lo)
    return f"<munderover>{operator('∑')}{below}{row(hi)}</munderover>"


def matrix(rows: Iterable[Iterable[str]]) -> str:
    body = "".join(
        f"<mtr>{''.join(f'<mtd>{entry}</mtd>' for entry in entries)}</mtr>" for entries in rows
    )
    return fenced(f"<mtable>{body}</mtable>")


def width(content: str) -> int:
    """Of what is seen, in letters; a fraction counts as its parts side by side."""
    return len(_VISIBLE.sub("", content))


# -- names ------------------------------------------------------------------------------------


def name(text: str, lone: str = "", bold: bool = False) -> str:
    """A name as it stands in a model, with primes, an index, or a component. Of the rotation that
    is `lone` the rates need not say whose they are; vectors are bold."""
    base = text.rstrip("'")
    letter, below = _parts(base, lone, bold)
    letter = dotted(letter, len(text) - len(base))
    return sub(letter, below) if below else letter


def _parts(text: str, lone: str, bold: bool) -> tuple[str, str]:
    """A letter or a word, and what stands below it."""
    if component := _COMPONENT.fullmatch(text):
        letter, below = _parts(component[1], lone, bold)
        axis = row(*map(_identifier, component[2]))
        return letter, row(below, operator(","), axis) if below else axis
    if rate := _RATE.fullmatch(text):
        return _identifier("omega", bold), "" if rate[1] == lone else name(rate[1])
    if member := _MEMBER.fullmatch(text):
        letter, below = _parts(member[1], lone, bold)
        at = index(member[2])
        return letter, row(below, operator(","), at) if below else at
    plain = _NAME.fullmatch(text)
    if not plain or text.endswith("_"):
        return _identifier(text, bold), ""
    base, digits, rest = plain.groups()
    if rest and len(_GREEK.get(base, base)) > 1:  # several words
        return _identifier(text.replace("_", "\u00a0"), bold), ""
    below = [f"<mn>{digits}</mn>"] if digits else []
    below += [_identifier(rest.replace("_", "\u00a0"))] if rest else []
    return _identifier(base, bold), row(*below) if below else ""


def index(text: str) -> str:
    """An index: i+1, or two with a comma."""
    return row(*(_index(part) for part in re.split(r"(, |[-+*])", text)))


def _index(part: str) -> str:
    if part in (", ", "+", "-"):
        return operator(part.strip())
    if part == "*":
        return f"<mo>{_TIMES}</mo>"
    return f"<mn>{part}</mn>" if part.isdigit() else name(part)


def _identifier(text: str, bold: bool = False) -> str:
    letters = _GREEK.get(text, text)
    return f"<mi>{escape(_bold(letters) if bold else letters)}</mi>"


def _bold(letters: str) -> str:
    """In the letters that Unicode has for vectors."""
    found = []
    for c in letters:
        kind = unicodedata.name(c, "").replace("LETTER ", "").replace("LATIN ", "")
        kind = kind.replace("GREEK ", "")
        try:
            found.append(unicodedata.lookup(f"MATHEMATICAL BOLD {kind}"))
        except KeyError:
            found.append(c)
    return "".join(found)


def is_greek(text: str) -> bool:
    return text in _GREEK


def dotted(letter: str, primes: int) -> str:
    if not primes:
        return letter
    dots = _DOTS.get(primes, "′" * primes)
    return f'<mover accent="true">{letter}<mo stretchy="false">{dots}</mo></mover>'
