"""What a promise of accuracy was kept by, as plain data: who goes on measures nothing again."""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import Any

from ..run.settings import PartSettings, Settings
from ..system.exits import UsageError

TEXTS = ("method", "rows")
NUMBERS = ("step", "rtol", "atol", "max_step")
OF_PART = ("step", "rtol", "max_step")


def data(settings: Settings) -> dict[str, Any]:
    found: dict[str, Any] = {name: getattr(settings, name) for name in (*TEXTS, *NUMBERS)}
    parts = [asdict(part) for part in settings.parts]
    return {**found, "compiled_for": list(settings.compiled_for), "parts": parts}


def settled(settings: Settings, said: object) -> Settings:
    """The settings that `said` is of. Raises UsageError where it is nothing of the kind."""
    try:
        found = {name: _text(said[name]) for name in TEXTS}
        found |= {name: _number(said[name]) for name in NUMBERS}
        parts = [
            PartSettings(_text(one["method"]), **{name: _number(one[name]) for name in OF_PART})
            for one in _list(said["parts"])
        ]
        compiled_for = tuple(map(_text, _list(said["compiled_for"])))
    except (KeyError, TypeError):
        raise UsageError("what is kept of the choice of method is none") from None
    return replace(settings, **found, compiled_for=compiled_for, parts=tuple(parts))


def _list(x: object) -> list:
    if not isinstance(x, list):
        raise TypeError
    return x


def _text(x: object) -> str:
    if not isinstance(x, str):
        raise TypeError
    return x


def _number(x: object) -> float | None:
    if x is not None and (isinstance(x, bool) or not isinstance(x, int | float)):
        raise TypeError
    return x
