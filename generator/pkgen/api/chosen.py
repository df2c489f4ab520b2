"""The method and settings chosen for a promised accuracy, as plain data for checkpoints: a resumed
run does not choose again."""

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


def settled(settings: Settings, said: Any) -> Settings:
    """Returns the settings with the choice in `said`, from data(). Raises UsageError if invalid."""
    try:
        found = {name: _is(said[name], str) for name in TEXTS}
        found |= {name: _number(said[name]) for name in NUMBERS}
        parts = [
            PartSettings(_is(one["method"], str), **{name: _number(one[name]) for name in OF_PART})
            for one in _is(said["parts"], list)
        ]
        compiled_for = tuple(_is(x, str) for x in _is(said["compiled_for"], list))
    except (KeyError, TypeError):
        raise UsageError("what is kept of the choice of method is none") from None
    return replace(settings, **found, compiled_for=compiled_for, parts=tuple(parts))


def _is(x: Any, *types: type) -> Any:
    if isinstance(x, bool) or not isinstance(x, types):
        raise TypeError
    return x


def _number(x: object) -> Any:
    return _is(x, int, float, type(None))
