"""Makes MathML elements, and typesets a model's names; browsers render MathML without scripts.

theta1' becomes a theta with a dot and an index; p_x and q[i+1] have subscripts; omega(R).x is an
omega with subscript x. Reference: MathML Core, https://www.w3.org/TR/mathml-core/
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable
from html import escape

from pkgen.front.words import greek

NARROW = 24  # most letters of a formula that fits in a line of a narrow page
MINUS = "\u2212"
_TIMES = "\u2062"  # MathML's invisible multiplication sign.
_APPLY = "\u2061"  # MathML's invisible sign of a function application.
_THIN = '<mspace width="0.17em"></mspace>'
_NAME = re.compile(r"([^\W\d_]+)_?(\d*)(?:_(\w+))?")
_MEMBER = re.compile(r"(\w+)\[(.*)\]")
_COMPONENT = re.compile(r"(.+)\.([xyzw]{1,2})")
_RATE = re.compile(r"omega\((\w+)\)")
_VISIBLE = re.compile(r"<[^>]*>|[\u2061\u2062]")
# Greek letters by their names in the modelling language.
_GREEK = {greek(c): c for c in map(chr, range(ord("Α"), ord("ω") + 1)) if greek(c)}
_TALL = ("<mfrac>", "<msqrt>", "<mtable>", "<munderover>")
_DOTS = {1: "˙", 2: "¨"}


def formula(chunks: Iterable[str], note: str = "") -> str:
    """Returns a displayed formula followed by a note in HTML. The formula is a sequence of chunks
    of MathML; a line may break between two chunks. If a chunk is too wide for a narrow page, the
    formula can be scrolled by the keyboard."""
    chunks = list(chunks)
    parts = [f'<math displaystyle="true">{row(chunk)}</math>' for chunk in chunks]
    parts += [f'<span class="note">{note}</span>'] if note else []
    scrolled = ' tabindex="0"' if max(map(width, chunks)) > NARROW else ""
    return f'<div class="equation"{scrolled}>{" ".join(parts)}</div>'


def inline(content: str) -> str:
    return f"<math>{row(content)}</math>"


def row(*parts: str) -> str:
    """Returns the parts as one <mrow> element."""
    content = "".join(parts)
    whole = content.startswith("<mrow>") and content.find("</mrow>") == len(content) - len(
        "</mrow>"
    )
    return content if whole else f"<mrow>{content}</mrow>"


def operator(sign: str) -> str:
    return f"<mo>{escape(sign.replace('-', MINUS))}</mo>"


def leading(sign: str) -> str:
    """Returns a sign in front of the first term."""
    return f'<mo form="prefix" lspace="0" rspace="0.06em">{escape(sign.replace("-", MINUS))}</mo>'


def binary(sign: str) -> str:
    """Returns a binary plus or minus, which keeps its spacing at the start of a line."""
    return f'<mo form="infix">{escape(sign.replace("-", MINUS))}</mo>'


def number(text: str) -> str:
    """Returns a decimal number; an exponent is written as a power of ten."""
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
    """Returns a unit with superscript exponents: m/s² for m/s^2, s⁻¹ for 1/s."""
    if unit.startswith("1/") and "/" not in unit[2:] and "*" not in unit:
        base, _, power = unit[2:].partition("^")
        unit = f"{base}^-{power or 1}"
    raised = re.sub(r"\^([-\d]+)", lambda found: found[1].translate(_RAISED), unit)
    return raised.replace("*", "\u2009")


def unit(text: str) -> str:
    """Returns a space and a unit, to follow a number."""
    return f"{_THIN}<mtext>{escape(unit_text(text))}</mtext>" if text else ""


def fraction(above: str, below: str, small: bool = False) -> str:
    made = f"<mfrac>{row(above)}{row(below)}</mfrac>"
    return f'<mstyle displaystyle="false">{made}</mstyle>' if small else made


def fenced(content: str, left: str = "(", right: str = ")") -> str:
    """Returns the content in brackets, which stretch if it has fractions, roots or matrices."""
    grows = "" if any(tall in content for tall in _TALL) else ' stretchy="false"'
    return row(
        f'<mo form="prefix" lspace="0" rspace="0"{grows}>{left}</mo>',
        content,
        f'<mo form="postfix" lspace="0" rspace="0"{grows}>{right}</mo>',
    )


def bars(content: str, bar: str = "|") -> str:
    return fenced(content, bar, bar)


def applied(function: str, argument: str, bracketed: bool) -> str:
    """Returns a function applied to an argument, which is in brackets or follows a space."""
    between = f"<mo>{_APPLY}</mo>" + ("" if bracketed else _THIN)
    return row(function, between, fenced(argument) if bracketed else argument)


def product(factors: Iterable[str]) -> str:
    """Returns the factors one after another, with a space next to names of several letters."""
    made = ""
    for factor in factors:
        if made:
            spaced = _is_word(made, -1) or _is_word(factor, 0)
            made += f"<mo>{_TIMES}</mo>" + (_THIN if spaced else "")
        made += factor
    return made


def _is_word(content: str, end: int) -> bool:
    """Whether the first text in this MathML (`end` = 0) or the last one (`end` = -1) is a word of
    several letters."""
    letters = [x for x in re.split(r"<[^>]*>", content) if x]
    return bool(letters) and len(letters[end]) > 1 and letters[end].isalpha()


def sub(base: str, below: str) -> str:
    return f"<msub>{base}{row(below)}</msub>"


def sup(base: str, above: str) -> str:
    """Returns a power; if the base has an index, the exponent is above the index."""
    if base.startswith("<msub>") and base.endswith("</msub>"):
        return f"<msubsup>{base[len('<msub>') : -len('</msub>')]}{row(above)}</msubsup>"
    return f"<msup>{row(base)}{row(above)}</msup>"


def sums(over: str, lo: str, hi: str) -> str:
    """Returns a summation sign with its range."""
    below = row(over, operator("="), lo)
    return f"<munderover>{operator('∑')}{below}{row(hi)}</munderover>"


def matrix(rows: Iterable[Iterable[str]]) -> str:
    body = "".join(
        f"<mtr>{''.join(f'<mtd>{entry}</mtd>' for entry in entries)}</mtr>" for entries in rows
    )
    return fenced(f"<mtable>{body}</mtable>")


def width(content: str) -> int:
    """Returns the number of visible letters in MathML; a fraction counts the letters of both its
    numerator and its denominator."""
    return len(_VISIBLE.sub("", content))


# -- names ------------------------------------------------------------------------------------


def name(text: str, lone: str = "", bold: bool = False) -> str:
    """Returns a name of the model typeset, with primes, index or component; vectors are bold. If
    the model has only one rotation, `lone` is its name, and its angular velocity is shown without
    this name as subscript."""
    base = text.rstrip("'")
    letter, below = _parts(base, lone, bold)
    letter = dotted(letter, len(text) - len(base))
    return sub(letter, below) if below else letter


def _parts(text: str, lone: str, bold: bool) -> tuple[str, str]:
    """Splits a name into a letter or a word, and its subscript."""
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
    """Returns an index typeset: i+1, or two indices with a comma."""
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
    """Returns the letters in Unicode's mathematical bold."""
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
