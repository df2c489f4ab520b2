"""The interface of `pkgen export`: the exported model, and hosts (targets) from add-ons."""

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
    """A model to export. `description` is what `pkgen describe` tells (docs/dev/describe.md).
    `files` are the generated C files. `separable`: the mass matrix is constant and forces do not
    depend on rates. `own` are integration methods that the model's author defines. `options` are
    the options of the command line. `program` is the Program or FamilyProgram that the files are
    rendered from."""

    name: str
    description: Mapping[str, Any]
    files: Mapping[str, str]
    separable: bool
    own: tuple[Own, ...]
    options: argparse.Namespace
    program: Any

    def runtime(self, *texts: str) -> dict[str, str]:
        """Returns the runtime's files that the model and the C sources `texts` need, by their paths
        in the runtime."""
        return sources([*self.files.values(), *texts])

    def with_runtime(self, wrapper: Mapping[str, str]) -> dict[str, str]:
        """Returns C files that compile on their own: the model, the wrapper, the runtime's files
        for both, and the tables of the author's methods. Raises UsageError if two files have one
        name."""
        clash = [name for name in self.files if name in wrapper]
        if clash:
            raise UsageError(f"{clash[0]} is a file of the export itself: rename the model")
        files = {**self.files, **wrapper, **self.runtime(*wrapper.values())}
        if self.own:
            files[in_c.FILE] = in_c.tables(self.own)
        return alone(files, in_c.FILE if self.own else "")

    def methods(self) -> list[Mapping[str, Any]]:
        """Returns the descriptions of the methods that a user may choose."""
        return [m for m in self.description["methods"] if m["applies"] and not m["gsl"]]

    def method(self) -> str:
        """Returns the name of the run's method. Raises UsageError if it is not one of methods()."""
        name = self.description["run"]["method"]
        (found,) = (m for m in self.description["methods"] if m["name"] == name)
        if found["gsl"]:
            raise UsageError(f"method {name}: nothing that is exported has GSL; give --method")
        if not found["applies"]:
            raise UsageError(f"method {name}: {found['why']}")
        return name

    def json(self) -> str:
        """Returns the description in the format of `pkgen describe --json`."""
        return json.dumps(self.description, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


@record
class Host:
    """A target of `pkgen export`, such as a wheel. `make` returns the exported files by their
    paths, or raises BuildError or UsageError. If `suffix` is not empty, the export is one file.
    `options` are command-line options in argparse's form; if two hosts have the same option, it
    means the same for both. `how` returns keyword arguments for compiling the model. `warnings`
    returns the features of `pkgen run` that the host lacks."""

    name: str
    doc: str  # one line
    make: Callable[[Exported], Mapping[str, bytes]]
    suffix: str = ""
    options: tuple[tuple[str, Mapping[str, Any]], ...] = ()
    tools: str = ""  # The programs that an export needs, as text.
    how: Callable[[argparse.Namespace], Mapping[str, Any]] = lambda _: {}
    warnings: Callable[[Exported], list[str]] = lambda _: []
    drawing: bool = False  # whether the C must compute the drawing's numbers


# The option that lists the machines for which an export contains binaries; see library.py.
TARGET_OPTION = (
    "--target",
    {"metavar": "LIST", "help": "machines: linux-x86_64,linux-aarch64,windows-x86_64,macos-..."},
)
