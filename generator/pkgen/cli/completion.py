"""`pkgen completion`: writes completion scripts for shells."""

from __future__ import annotations

import argparse

from ..methods import METHODS
from ..system.exits import UsageError
from .commands import commands, overview, parser_of

SHELLS = ("bash", "zsh", "fish")
EXAMPLES = """
pkgen completion bash > ~/.local/share/bash-completion/completions/pkgen
pkgen completion fish > ~/.config/fish/completions/pkgen.fish
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("shell", choices=SHELLS, metavar="SHELL", help=", ".join(SHELLS))


def run(options: argparse.Namespace) -> None:
    """Write a script by which a shell completes commands, options, methods and files."""
    try:
        import shtab
    except ImportError:
        raise UsageError("completion needs shtab: pip install shtab") from None
    if options.shell not in shtab.SUPPORTED_SHELLS:
        raise UsageError(
            f"completion: this shtab is too old for {options.shell}: pip install -U shtab"
        )
    print(shtab.complete(_whole(shtab), shell=options.shell, root_prefix="pkgen"))


def _whole(shtab) -> argparse.ArgumentParser:
    """Returns a parser of all commands, in which arguments that are files are marked."""
    parser = argparse.ArgumentParser(prog="pkgen", description=overview(), add_help=False)
    parser.add_argument("-h", "--help", action="store_true", help="all commands, a line each")
    parser.add_argument("-V", "--version", action="store_true", help="the version")
    subparsers = parser.add_subparsers()
    for command in commands().values():
        of = parser_of(command.name)
        for action in of._actions:
            named = action.metavar if isinstance(action.metavar, str) else ""
            if named.startswith("DIR"):
                action.complete = shtab.DIRECTORY
            elif any(word in named for word in ("FILE", ".lag", "PATH", "ROBOT")):
                action.complete = shtab.FILE
            elif "--method" in action.option_strings:
                action.choices = sorted(METHODS)
            elif action.dest == "command":
                action.choices = list(commands())
            action.help = action.help or ""
        more = {"parents": [of], "add_help": False, "description": command.does}
        subparsers.add_parser(command.name, help=command.does, **more)
    return parser
