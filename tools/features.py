"""Prints what pkgen offers, a word a line: `python tools/features.py > tests/features.txt`."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

import pkgen
from pkgen.cli.commands import commands, parser_of
from pkgen.cli.export import hosts
from pkgen.front.shapes import FORMS, SHAPES
from pkgen.front.table import STATEMENTS
from pkgen.functions import FUNCTIONS, VECTOR_FUNCTIONS, WRITTEN_OUT
from pkgen.methods import METHODS
from pkgen.run import diagnostics
from pkgen.system import addons


def features() -> list[str]:
    """Returns what pkgen and its add-ons offer, without what packages of others bring."""
    return sorted({*_commands(), *_language(), *_python(), *_words()})


def _commands() -> Iterator[str]:
    for name in filter(_own, commands()):
        yield f"command {name}"
        for action in parser_of(name)._actions:
            if action.help == argparse.SUPPRESS:
                continue
            for flag in action.option_strings:
                yield f"option {name} {flag}"
                yield from (f"option {name} {flag} {choice}" for choice in action.choices or ())


def _own(name: str) -> bool:
    found = (addons.points(kind).get(name) for kind in addons.KINDS)
    return all(point is None or point.dist.name == "pkgen-lag" for point in found)


def _language() -> Iterator[str]:
    for word, statement in STATEMENTS.items():
        yield f"statement {word} of {statement.stands_in}"
    yield from (f"shape {name}" for name in (*SHAPES, *FORMS))
    yield from (f"function {name}" for name in (*FUNCTIONS, *VECTOR_FUNCTIONS, *WRITTEN_OUT, "rot"))


def _words() -> Iterator[str]:
    yield from (f"method {name}" for name in METHODS)
    yield from (f"export {name}" for name in filter(_own, hosts()))
    yield from (f"diagnostic {name}" for name in (*diagnostics.NAMES, *diagnostics.OF_MEMBERS))


def _python() -> Iterator[str]:
    for name in pkgen.__all__:
        yield f"python {name}"
        of = getattr(pkgen, name)
        bases = of.__mro__ if isinstance(of, type) else ()
        members = {m for c in bases if c.__module__.startswith("pkgen") for m in vars(c)}
        yield from (f"python {name}.{member}" for member in members if member[0] != "_")


if __name__ == "__main__":
    print("\n".join(features()))
