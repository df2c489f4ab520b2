"""Characters that are not allowed in a model, and their replacements."""

from __future__ import annotations

import re
import unicodedata

from .foreign import CHARACTERS

_INSTEAD = {
    "−": "-", "–": "-", "—": "-", "·": "*", "×": "*", "⋅": "*", "∗": "*", "÷": "/", "∕": "/",
    "′": "'", "’": "'", "‘": "'", "`": "'", "″": "''", "²": "^2", "³": "^3",
    "⁴": "^4", "½": "1/2", "¼": "1/4", "√": "sqrt( )", "∑": "sum( )", "∞": "inf",
    "°": "[deg]", "…": "..", "\u00a0": "a plain space", "{": "(", "}": ")",
}  # fmt: skip


def stray_character(character: str, where: str) -> tuple[str, str]:
    """Returns a message about a forbidden character, and a hint. `where` says where it is."""
    name = unicodedata.name(character, "a control character")
    instead = _INSTEAD.get(character)
    simple = unicodedata.normalize("NFKC", character)
    if instead is None and simple != character and re.fullmatch(r"[A-Za-z0-9]+", simple):
        instead = simple
    shown = f"'{character}'" if character.isprintable() else "a character"
    if character.isascii() and character.isprintable():
        message = f"{shown} means nothing in a model"
    else:
        message = f"{shown} (U+{ord(character):04X} {name}) cannot be used in {where}"
    help = f"write {instead}" if instead else CHARACTERS.get(character, "")
    if not help and unicodedata.category(character) in ("Lu", "Ll", "Mn"):
        help = "names use ASCII letters, digits, '_' and Greek letters"
    return message, help
