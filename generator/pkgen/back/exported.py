"""What every host of an export is given, and what a host is: a row of cli/export.py."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Mapping
from typing import Any

from ..methods import Own
from ..record import record
from .runtime import sources


@record
class Exported:
    """A model for a host. `description` is that of docs/describe.md, `files` the generated C, `own`
    the methods that its author brings, `options` those of the command line."""

    name: str
    description: Mapping[str, Any]
    files: Mapping[str, str]
    own: tuple[Own, ...]
    options: argparse.Namespace

    def runtime(self, *texts: str) -> dict[str, str]:
        """The runtime's files that the model and C of these texts need, by their paths there."""
        return sources([*self.files.values(), *texts])

    def json(self) -> str:
        """The description, as `pkgen describe --json` writes it."""
        return json.dumps(self.description, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


@record
class Host:
    """`make` gives the files of an export by their paths, or raises BuildError or UsageError. Of a
    host with a `suffix` it is one file. `options` are its own, as argparse takes them; one that two
    hosts have means the same for both. `how` is how the model is compiled for it."""

    name: str
    doc: str  # one line
    make: Callable[[Exported], Mapping[str, bytes]]
    suffix: str = ""
    options: tuple[tuple[str, Mapping[str, Any]], ...] = ()
    tools: str = ""  # what must be there to make it, for people
    how: Callable[[argparse.Namespace], Mapping[str, Any]] = lambda _: {}
    drawing: bool = False  # whether the C has the numbers of the drawing among its outputs


# Machines that binaries are for; see library.py.
TARGET_OPTION = (
    "--target",
    {"metavar": "LIST", "help": "machines: linux-x86_64,linux-aarch64,windows-x86_64,macos-..."},
)
