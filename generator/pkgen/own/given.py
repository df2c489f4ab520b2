"""Integration methods that options define: --tableau FILE, --composition WEIGHTS."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..front.read import UnreadableModel, read_text, unquoted
from ..methods import Own
from ..source import ModelError
from ..system.exits import UsageError
from .made import fit, of_text, of_weights


def given(options: argparse.Namespace) -> tuple[Own, ...]:
    """Returns the methods. Raises ModelError for wrong texts, UsageError for two equal names."""
    found: dict[str, Own] = {}
    for path in getattr(options, "tableau", None) or ():
        try:
            own = of_text(fit(Path(path).stem), read_text(path, "a tableau file"))
        except ModelError as wrong:
            if path not in getattr(options, "unquoted", ()) or isinstance(wrong, UnreadableModel):
                raise
            raise UsageError("{}; {}".format(*unquoted(path, wrong))) from None
        if own.name in found:
            raise UsageError(f"--tableau {path}: there is another method '{own.name}'")
        found[own.name] = own
    for k, text in enumerate(getattr(options, "composition", None) or ()):
        name = f"composition{k + 1 if k else ''}"
        if name in found:
            raise UsageError(f"--composition {text[:60]}: there is another method '{name}'")
        found[name] = of_weights(name, text)
    return tuple(found.values())


def taken(options: argparse.Namespace) -> argparse.Namespace:
    """Returns the options of a run. If they define methods but select none, the first of these is
    selected."""
    own = given(options)
    if not own or options.method is not None:
        return options
    return argparse.Namespace(**{**vars(options), "method": own[0].name})
