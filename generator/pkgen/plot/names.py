"""Formats names and units for pictures: theta1' as θ₁′, kg*m/s^2 as kg·m/s²."""

from __future__ import annotations

import re

from ..front.words import greek

_GREEK = {greek(c): c for c in map(chr, range(ord("Α"), ord("ω") + 1)) if greek(c)}
_LOW = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")
_HIGH = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_WORD = re.compile(r"([^\W\d_]+)(\d*)(?=[^\w]|_|$)")


def shown(name: str) -> str:
    """Returns a name with Greek letters, primes, and digits after a letter as subscripts."""
    name = re.sub(r"(?<![\w])omega(?=\()", "ω", name)
    return _WORD.sub(_letter, name).replace("'", "′")


def _letter(found: re.Match[str]) -> str:
    word, digits = found.groups()
    letter = _GREEK.get(word, word)
    return letter + (digits.translate(_LOW) if len(letter) == 1 else digits)


def unit(text: str) -> str:
    text = re.sub(r"\^(-?\d+)", lambda power: power[1].translate(_HIGH), text)
    return text.replace("*", "·")


def number(x: float) -> str:
    """Returns a number with up to three digits: 0.256, 6.31·10⁻⁶, 10⁻³."""
    digits, power = f"{x:.2e}".split("e")
    digits = digits.rstrip("0").rstrip(".")
    if (-3 if digits == "1" else -5) < int(power) < 4:
        return f"{float(f'{x:.3g}'):g}"
    power = "10" + str(int(power)).translate(_HIGH)
    return power if digits == "1" else f"{digits}·{power}"


def amount(x: str, of: str) -> str:
    """Returns a number and its unit, separated by a no-break space."""
    return f"{x}\u00a0{unit(of)}" if of else x


def label(name: str, of: str) -> str:
    """Returns the label of an axis: name and unit."""
    return f"{shown(name)} [{unit(of)}]" if of else shown(name)
