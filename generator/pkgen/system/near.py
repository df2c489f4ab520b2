"""Hints for unknown names."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

# Kinds of names that are defined by pkgen and not by a model.
_OF_PKGEN = frozenset(("method", "kernel", "diagnostic", "option", "package", "host", "command"))


def near(name: str, known: list[str], kind: str) -> str:
    """Returns a hint with known names similar to `name`, or else with all known names."""
    they = "there are" if kind in _OF_PKGEN else "it has"
    meant = difflib.get_close_matches(name, known, n=3)
    if meant:
        *most, last = (f"'{one}'" for one in meant)
        return f"did you mean {', '.join(most)}{' or ' if most else ''}{last}?"
    if not known:
        return f"{they} none"
    return f"{they}: {', '.join(known[:12])}{', ...' if len(known) > 12 else ''}"


def unknown(option: str, name: str, known: Iterable[str], kind: str) -> str:
    """Returns the message about an unknown name in an option, with a hint."""
    who = "there is" if kind in _OF_PKGEN else "the model has"
    return f"{option} {name}: {who} no such {kind}; {near(name, list(known), kind)}"
