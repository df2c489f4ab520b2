"""`pkgen help`: prints the list of commands, or the options of a command."""

from __future__ import annotations

import argparse
import json

from ..system.exits import UsageError
from ..system.near import near
from .commands import command_of, commands, overview, parser_of

EXAMPLES = """
pkgen help
pkgen help run
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("command", nargs="?", metavar="COMMAND", help="default: all, a line each")


def run(options: argparse.Namespace) -> None:
    """Show all commands, or the options of one, with examples."""
    if options.command is not None and command_of(options.command) is None:
        said = near(options.command, list(commands()), "command")
        raise UsageError(f"there is no command '{options.command}'; {said}")
    if options.json:
        print(json.dumps({c.name: {"form": c.form, "does": c.does} for c in commands().values()}))
    elif options.command is None:
        print(overview())
    else:
        parser_of(options.command).print_help()
