"""The HTML page with a model's animation."""

from __future__ import annotations

import html
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

from ..system.exits import UsageError
from . import arguments


class Page:
    """An HTML file for a browser; a notebook shows it."""

    def __init__(self, path: Path):
        self.path = path

    def __repr__(self) -> str:
        return f"Page({str(self.path)!r})"

    def _repr_html_(self) -> str:
        text = html.escape(self.path.read_text(encoding="utf-8"))
        return f'<iframe srcdoc="{text}" width="100%" height="640" style="border: 0"></iframe>'


def shown(model: Any, target: Path) -> Page:
    """Writes a model's page to `target` by `pkgen show`. Raises UsageError."""
    if model.tables._set:
        raise UsageError("a page of arrays: give its tables files, by pkgen show --table NAME=FILE")
    command = [sys.executable, "-m", "pkgen", "show", os.fspath(model.path), "-o", str(target)]
    command += ["--scene", model.scene] if model.scene else []
    command += [f"--size={name}={length}" for name, length in model._sizes.items()]
    command += [f"--set={name}={x!r}" for name, x in model.params._set.items()]
    command += [f"--allow-path={folder}" for folder in model._allowed]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise UsageError(arguments.worded(done.stderr.strip()))
    return Page(target)
