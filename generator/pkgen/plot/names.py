"""Names and units as they are printed: theta1' is θ₁′, kg*m/s^2 is kg·m/s²."""

from __future__ import annotations

import re

from ..front.words import greek

_GREEK = {greek(c): c for c in map(chr, range(ord("Α"), ord("ω") + 1)) if greek(c)}
_LOW = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")
_HIGH = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_WORD = re.compile(r"([^\W\d_]+)(\d*)(?=[^\w]|_|$)")


def shown(name: str) -> str:
    """Greek letters for their names, digits behind a letter below the line, primes."""
    name = re.sub(r"(?<![\w])omega(?=\()", "ω", name)
    return _WORD.sub(_letter, name).replace("'", "′")


def _letter(found: re.Match[str]) -> str:
    word, digits = found.groups()
    letter = _GREEK.get(word, word)
    return letter + (digits.translate(_LOW) if len(letter) == 1 else digits)


def unit(text: str) -> str:
    text = re.sub(r"\^(-?\d+)", lambda power: power[1].translate(_HIGH), text)
    return text.replace("*", "·")


def label(name: str, of: str) -> str:
    """Of an axis."""
    return f"{shown(name)} [{unit(of)}]" if of else shown(name)
