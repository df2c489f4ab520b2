"""The table of commands, from which the overview, the usage and the parsers are made.

A row has a command's name, its arguments, and a description. The module of the command, in this
folder, has `arguments()`, which adds its options, `run()`, and EXAMPLES for its help. A command
whose first argument is MODEL.lag also has the options of arguments.of_a_model(). Add-ons define
such rows in COMMANDS of their package (system/addons.py).
"""

from __future__ import annotations

import argparse
import os
import re
from collections.abc import Iterable
from glob import glob
from importlib import import_module
from types import ModuleType

from ..record import record
from ..system import addons
from ..system.exits import UsageError
from ..system.near import near

_TABLE = """
Look at a model
  check       MODEL.lag                    errors and warnings alone
  explain     MODEL.lag                    equations, structure, what scenes leave
  describe    MODEL.lag                    names, units, methods, drawings as data
Make something of it
  compile     MODEL.lag [-o DIR]           C: DIR/NAME.h and DIR/NAME.c
  build       MODEL.lag -o FILE            a program, which needs no Python
  export      MODEL.lag --as HOST          for FMI, C and other programs
Integrate it
  run         MODEL.lag                    rows of the motion, as CSV
  resume      FILE                         go on with a run from its checkpoint
  plot        MODEL.lag|FILE.csv...        pictures, in the terminal or -o FILE.svg
Judge a motion
  equilibria  MODEL.lag                    where it rests or goes on steadily, modes
Judge methods
  methods                                  the methods, what each requires
  chart       MODEL.lag [-o DIR]           accuracy against cost of every method
  stability   MODEL.lag [-o DIR]           where each method fails
Write models
pkgen itself
  help        [COMMAND]                    the options of a command, with examples
  manual      [-o DIR]                     pages for man
  completion  SHELL                        what bash, zsh or fish completes
"""
COMMON = ("-q", "--quiet", "-v", "--verbose", "--json")
OVERVIEW_WIDTH = 80
USUAL = "compile"  # default command, if the command line names none


@record
class Command:
    name: str
    form: str  # the arguments in the usage line
    does: str
    group: str

    @property
    def module(self) -> ModuleType:
        """The module of the command, imported on demand."""
        if self.name in OWN:
            return import_module(f"{__package__}.{self.name}")
        return addons.load("commands", self.name)


def _rows(table: str) -> Iterable[Command]:
    group = ""
    for line in table.strip().split("\n"):
        if line.startswith("  "):
            found = re.fullmatch(r"  (\w+) +((?:\S+ )*\S+)? {2,}(\S.*)", line)
            yield Command(found[1], found[2] or "", found[3], group)
        else:
            group = line


OWN = {command.name: command for command in _rows(_TABLE)}


def commands() -> dict[str, Command]:
    """Returns all installed commands by name; in each group, commands of add-ons come last."""
    found = dict(OWN)
    for name, point in addons.here("commands").items():
        found[name] = _of_addon(name, addons.package(point))
    groups = [line for line in _TABLE.split("\n") if not line.startswith(" ")]
    groups += [command.group for command in found.values()]
    return dict(sorted(found.items(), key=lambda item: groups.index(item[1].group)))


def _of_addon(name: str, package: ModuleType) -> Command:
    return next(command for command in _rows(package.COMMANDS) if command.name == name)


def command_of(name: str) -> Command | None:
    """Returns the command `name`, or None. Raises UsageError if its add-on is not installed."""
    if name in OWN:
        return OWN[name]
    point = addons.points("commands").get(name) if name.isidentifier() else None
    return point and _of_addon(name, addons.package(point))


def overview() -> str:
    """Returns the help text that lists all commands, one per line."""
    lines = ["usage: pkgen COMMAND [options]", "       pkgen MODEL.lag          as pkgen compile"]
    group = ""
    for command in commands().values():
        if command.group != group:
            group = command.group
            lines += ["", f"{group}:"]
        lines.append(f"  {command.name:10} {command.does}")
    lines += [
        "",
        "Each takes --json, -q (quiet) and -v (verbose); a file may be - (the standard",
        "input or output). Its options and examples: pkgen help COMMAND, or --help.",
        "The version: pkgen -V.",
    ]
    return "\n".join(lines)


class _Help(argparse.HelpFormatter):
    """Formats help; keeps the line breaks of a text that has several lines."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        return text if "\n" in text else super()._fill_text(text, width, indent)


class Parser(argparse.ArgumentParser):
    """A parser that raises UsageError, with a hint, for an invalid command line."""

    def error(self, message: str) -> None:
        raise UsageError(f"{message}; see {self.prog.replace(' ', ' help ', 1)}")

    def _check_value(self, action: argparse.Action, value: object) -> None:
        if action.choices is not None and value not in action.choices:
            said = f"{value}: {near(str(value), [*map(str, action.choices)], 'option')}"
            raise argparse.ArgumentError(action, said)


def parser_of(name: str, whole: bool = True) -> Parser:
    """Returns the parser of a command; with `whole`, it includes options that add-ons define."""
    command = command_of(name)
    module = command.module
    parser = Parser(
        prog=f"pkgen {name}",
        usage=f"pkgen {name} {command.form}".rstrip() + " [options]",
        description=" ".join(module.run.__doc__.split()),
        formatter_class=_Help,
        allow_abbrev=False,
    )
    if command.form.split()[:1] == ["MODEL.lag"]:
        from .arguments import of_a_model

        parser.add_argument("model", metavar="MODEL.lag", help="- is the standard input")
        of_a_model(parser)
    module.arguments(parser)
    for point in addons.points("options") if whole else ():
        if point.startswith(f"{name}.") and point in addons.here("options"):
            addons.load("options", point).arguments(parser)
    examples = "\n  ".join(["examples:", *module.EXAMPLES.strip().split("\n")])
    parser.epilog = f"{parser.epilog}\n\n{examples}" if parser.epilog else examples
    of_all = parser.add_argument_group("options of every command")
    of_all.add_argument("--json", action="store_true", help="machine-readable results")
    add = of_all.add_mutually_exclusive_group().add_argument
    add("-q", "--quiet", action="store_true", help="say nothing where all is well")
    add("-v", "--verbose", action="store_true", help="say what is being done, and how long it took")
    return parser


def parsed(words: list[str]) -> tuple[Command, argparse.Namespace]:
    """Parses a command line into a command and its options. Raises UsageError."""
    leading = next((i for i, word in enumerate(words) if word not in COMMON), len(words))
    words = [*words[leading:], *words[:leading]]
    found = command_of(words[0])
    named, command = found is not None, found or OWN[USUAL]
    if not named and words[0].isalpha() and not os.path.exists(model_file(words[0])):
        said = near(words[0], list(commands()), "command")
        raise UsageError(f"there is no command '{words[0]}'; {said}")
    whole = any(word in ("-h", "--help") for word in words)
    parser = parser_of(command.name, whole)
    options, unknown = parser.parse_known_intermixed_args(words[named:])
    if unknown and not whole:
        parser = parser_of(command.name)
        options, unknown = parser.parse_known_intermixed_args(words[named:])
    if unknown:
        flag = unknown[0].partition("=")[0]
        if point := addons.points("options").get(f"{command.name}.{flag.removeprefix('--')}"):
            addons.package(point)  # a missing add-on raises UsageError
        if not flag.startswith("-"):
            raise UsageError(f"one file at a time: what is {flag}?")
        known = [name for name in parser._option_string_actions if name not in ("-h", "--help")]
        raise UsageError(f"there is no option {flag}; {near(flag, known, 'option')}")
    options.words = words[named:]
    if isinstance(getattr(options, "model", None), str):
        options.model = model_file(options.model)
    return command, options


def model_file(name: str) -> str:
    """Returns the path of a model's file. A name such as `heavy_top` means heavy_top.lag in the
    working directory or in models/, unless a file `heavy_top` exists."""
    if not name.isidentifier() or os.path.exists(name):
        return name
    below = (f"models/{name}.lag", *sorted(glob(f"models/*/{name}.lag")))
    return next(filter(os.path.exists, (f"{name}.lag", *below)), name)
