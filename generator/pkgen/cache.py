"""Where pkgen keeps what it need not make again: compiled runtimes and programs, parser tables."""

from __future__ import annotations

import os
from pathlib import Path


def cache_directory() -> Path:
    """`PKGEN_CACHE`, else `$XDG_CACHE_HOME/pkgen`, else `~/.cache/pkgen`; it may not exist."""
    named = os.environ.get("PKGEN_CACHE")
    if named:
        return Path(named)
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "pkgen"
