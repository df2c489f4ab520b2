"""Converts the method and settings that were chosen for a scene's accuracy to data for checkpoints.
A resumed run reads them and does not choose again."""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import Any

from ..run.settings import PartSettings, Settings
from ..system.exits import UsageError

TYPES = {"method": str, "rows": str, "parts": list, "compiled_for": list}
NUMBERS = ("step", "rtol", "atol", "max_step")
NAMES = (*TYPES, *NUMBERS)


def data(settings: Settings) -> dict[str, Any]:
    found = asdict(settings)
    return {name: found[name] for name in NAMES}


def settled(settings: Settings, said: Any) -> Settings:
    """Returns `settings` with the method and setting in `said`, which data() made when the run
    began. Raises UsageError."""
    try:
        found = _checked(said, NAMES)
        parts = [PartSettings(**_checked(part, tuple(part))) for part in found["parts"]]
        methods = tuple(
            _checked({"method": x}, ("method",))["method"] for x in found["compiled_for"]
        )
    except (KeyError, TypeError):
        raise UsageError("what is kept of the choice of method is none") from None
    return replace(settings, **{**found, "compiled_for": methods, "parts": tuple(parts)})


def _checked(said: Any, names: tuple[str, ...]) -> dict[str, Any]:
    """Returns the values of `names` in `said`. Raises KeyError, or TypeError for a wrong type."""
    found = {name: said[name] for name in names}
    for name, x in found.items():
        types = TYPES.get(name, (int, float, type(None)))
        if isinstance(x, bool) or not isinstance(x, types):
            raise TypeError
    return found
