"""What every host of an export is given, and what a host is, which add-ons bring."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Mapping
from typing import Any

from ..methods import Own
from ..own import in_c
from ..record import record
from ..system.exits import UsageError
from .runtime import alone, sources


@record
class Exported:
    """A model for a host. `description` is that of docs/dev/describe.md, `files` the generated C,
    `separable` whether M is constant and forces have no rates, `own` the methods that its author
    brings, `options` those of the command line."""

    name: str
    description: Mapping[str, Any]
    files: Mapping[str, str]
    separable: bool
    own: tuple[Own, ...]
    options: argparse.Namespace

    def runtime(self, *texts: str) -> dict[str, str]:
        """The runtime's files that the model and C of these texts need, by their paths there."""
        return sources([*self.files.values(), *texts])

    def with_runtime(self, wrapper: Mapping[str, str]) -> dict[str, str]:
        """C that compiles alone: the model, the wrapper, what both need of the runtime, and the
        tables of own methods."""
        clash = [name for name in self.files if name in wrapper]
        if clash:
            raise UsageError(f"{clash[0]} is a file of the export itself: rename the model")
        files = {**self.files, **wrapper, **self.runtime(*wrapper.values())}
        if self.own:
            files[in_c.FILE] = in_c.tables(self.own)
        return alone(files, in_c.FILE if self.own else "")

    def methods(self) -> list[Mapping[str, Any]]:
        """Those that a user may choose."""
        return [m for m in self.description["methods"] if m["applies"] and not m["gsl"]]

    def method(self) -> str:
        """What integrates it by default. Raises UsageError where that is none of these."""
        name = self.description["run"]["method"]
        (found,) = (m for m in self.description["methods"] if m["name"] == name)
        if found["gsl"]:
            raise UsageError(f"method {name}: nothing that is exported has GSL; give --method")
        if not found["applies"]:
            raise UsageError(f"method {name}: {found['why']}")
        return name

    def json(self) -> str:
        """The description, as `pkgen describe --json` writes it."""
        return json.dumps(self.description, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


@record
class Host:
    """`make` gives the files of an export by their paths, or raises BuildError or UsageError. Of a
    host with a `suffix` it is one file. `options` are its own, as argparse takes them; one that two
    hosts have means the same for both. `how` is how the model is compiled for it, `warnings`
    are of what pkgen run does and it does not."""

    name: str
    doc: str  # one line
    make: Callable[[Exported], Mapping[str, bytes]]
    suffix: str = ""
    options: tuple[tuple[str, Mapping[str, Any]], ...] = ()
    tools: str = ""  # what must be there to make it, for people
    how: Callable[[argparse.Namespace], Mapping[str, Any]] = lambda _: {}
    warnings: Callable[[Exported], list[str]] = lambda _: []
    drawing: bool = False  # whether the C has the numbers of the drawing among its outputs


# Machines that binaries are for; see library.py.
TARGET_OPTION = (
    "--target",
    {"metavar": "LIST", "help": "machines: linux-x86_64,linux-aarch64,windows-x86_64,macos-..."},
)
