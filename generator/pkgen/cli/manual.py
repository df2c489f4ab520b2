"""`pkgen manual`: writes man pages, from the parsers of the commands."""

from __future__ import annotations

import argparse
import json
import re
from collections.abc import Iterator
from pathlib import Path

from ..system.files import STANDARD, replace
from ..version import __version__
from . import arguments as shared
from .commands import Command, commands, overview, parser_of

EXAMPLES = """
pkgen manual -o ~/.local/share/man/man1
pkgen manual -o - | man -l -
"""
CODES = """
0    done
1    the model is wrong, or a text is not in its layout
2    the command line is wrong
3    the C compiler failed
4    the numerics failed, or an expectation was missed
130  interrupted
"""
VARIABLES = """
CC, CFLAGS        the C compiler and its flags
PKGEN_CACHE       where compiled runtimes are kept; else $XDG_CACHE_HOME/pkgen or ~/.cache/pkgen
NO_COLOR          no colours
FORCE_COLOR       colours though standard error is no terminal
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    shared.directory(parser, "here; -: all on standard output")


def run(options: argparse.Namespace) -> None:
    """Write man pages: pkgen.1, and one for each command."""
    pages = {"pkgen.1": _of_all()}
    pages |= {f"pkgen-{c.name}.1": _of_command(c) for c in commands().values()}
    directory = Path(options.directory)
    if directory == STANDARD:
        replace({STANDARD: "".join(pages.values())})
        return
    directory.mkdir(parents=True, exist_ok=True)
    replace({directory / name: text for name, text in pages.items()})
    if options.json:
        print(json.dumps({"files": [str(directory / name) for name in pages]}))


def _plain(text: str) -> str:
    """Escapes text for roff."""
    lines = text.replace("\\", "\\e").replace("-", "\\-").split("\n")
    return "\n".join(f"\\&{line}" if line[:1] in (".", "'") else line for line in lines)


def _broken(text: str) -> str:
    """Escapes text for roff, as one line that roff may break after commas."""
    return re.sub(r",(?=\S)", r",\\:", _plain(" ".join(text.split())))


def _page(title: str, name: str, does: str, body: Iterator[str]) -> str:
    head = f'.TH {title.upper()} 1 "" "pkgen {__version__}" "pkgen"'
    return "\n".join(
        [head, ".ad l", ".nh", ".SH NAME", f"{_plain(name)} \\- {_plain(does)}", *body, ""]
    )


def _listed(rows: str) -> Iterator[str]:
    for row in rows.strip().split("\n"):
        what, _, says = row.partition("  ")
        yield from (".TP", f".B {_plain(what)}", _plain(says.strip()))


def _of_all() -> str:
    def body() -> Iterator[str]:
        yield from (".SH SYNOPSIS", ".B pkgen", "COMMAND [options]", ".br", ".B pkgen")
        yield from ("MODEL.lag [options]", ".SH DESCRIPTION", ".nf", _plain(overview()), ".fi")
        yield ".SH COMMANDS"
        for command in commands().values():
            yield from (".TP", f".BR pkgen\\-{command.name} (1)", _plain(command.does))
        yield from (".SH EXIT STATUS", *_listed(CODES), ".SH ENVIRONMENT", *_listed(VARIABLES))

    return _page("pkgen", "pkgen", "a compiler from Lagrangians to C", body())


def _of_command(command: Command) -> str:
    parser = parser_of(command.name)

    def body() -> Iterator[str]:
        yield from (".SH SYNOPSIS", f".B pkgen {command.name}", _plain(f"{command.form} [options]"))
        yield from (".SH DESCRIPTION", _plain(parser.description))
        for group in parser._action_groups:
            shown = [a for a in group._group_actions if a.help is not argparse.SUPPRESS]
            yield from [f".SH {group.title.upper().removeprefix('POSITIONAL ')}"] if shown else []
            for action in shown:
                yield from (".TP", f".B {_plain(_flags(action))}")
                yield _broken((action.help or "").replace("%%", "%")) or "\\&"
        for part in parser.epilog.split("\n\n"):
            title, _, lines = part.partition(":\n")
            yield from (f".SH {title.upper()}", ".nf", _plain(lines), ".fi")
        yield from (".SH SEE ALSO", ".BR pkgen (1)")

    return _page(f"pkgen-{command.name}", f"pkgen-{command.name}", command.does, body())


def _flags(action: argparse.Action) -> str:
    """Returns the text of an option and its value, or the name of a positional argument."""
    named = action.metavar or "|".join(map(str, action.choices or ()))
    takes = "" if action.nargs == 0 else f" {named or action.dest.upper()}"
    return ", ".join(action.option_strings) + takes if action.option_strings else takes.strip()
