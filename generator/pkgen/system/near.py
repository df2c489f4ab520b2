"""Hints for unknown names."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

# Kinds of names that are defined by pkgen and not by a model.
_OF_PKGEN = frozenset(("method", "kernel", "diagnostic", "option", "package", "host", "command"))


def meant(name: str, known: Iterable[str], most: int = 1) -> str:
    """Returns a hint with at most `most` known names similar to `name`, or ""."""
    found = difflib.get_close_matches(name, sorted(known), most, 0.6)
    *others, last = (f"'{one}'" for one in found or ("",))
    return f"did you mean {', '.join(others)}{' or ' if others else ''}{last}?" if found else ""


def near(name: str, known: list[str], kind: str) -> str:
    """Returns a hint with known names similar to `name`, or else with all known names."""
    they = "there are" if kind in _OF_PKGEN else "it has"
    if not known:
        return f"{they} none"
    return (
        meant(name, known, 3)
        or f"{they}: {', '.join(known[:12])}{', ...' if len(known) > 12 else ''}"
    )


def unknown(option: str, name: str, known: Iterable[str], kind: str) -> str:
    """Returns the message about an unknown name in an option, with a hint."""
    who = "there is" if kind in _OF_PKGEN else "the model has"
    return f"{option} {name}: {who} no such {kind}; {near(name, list(known), kind)}"
