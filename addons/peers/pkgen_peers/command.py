"""The option --against of `pkgen chart`: selects packages, and checks that they are installed."""

from __future__ import annotations

import argparse
import sys

from pkgen.system.exits import UsageError
from pkgen.system.near import unknown

from .against import Against
from .peers import PEERS


def arguments(parser: argparse.ArgumentParser) -> None:
    known = ",".join(peer.name for peer in PEERS)
    help_ = f"other packages in the same picture, of {known}"
    parser.add_argument("--against", metavar="LIST", help=help_)
    parser.set_defaults(others=chosen)


def chosen(options: argparse.Namespace) -> Against | None:
    """Returns the installed packages of --against; reports the missing ones. Raises UsageError."""
    if options.against is None:
        return None
    known, found, missing = {peer.name: peer for peer in PEERS}, [], []
    for name in dict.fromkeys(n.strip() for n in options.against.split(",") if n.strip()):
        if name not in known:
            raise UsageError(unknown("--against", name, [*known], "package"))
        why = known[name].missing
        (missing if why else found).append(why or known[name])
    if not found:
        raise UsageError("--against: " + ("; ".join(missing) or "name one package at least"))
    if options.error == "energy":
        raise UsageError(
            "--error energy: other packages watch none; --against has final, max, mean, phase"
        )
    for why in missing:
        print(f"pkgen: --against: {why}", file=sys.stderr)
    return Against(tuple(found))
