"""Reads a plan in TOML: options of a run, the sampled quantities, the kept quantities.

Nothing in a plan is executed: numbers and units are read by the parser of the modelling language.
"""

from __future__ import annotations

import argparse
import os
import re
from collections.abc import Mapping
from dataclasses import field
from typing import Any

from pkgen.defaults import ITERATIONS
from pkgen.front.read import ALLOW, read_text, refusal
from pkgen.record import record
from pkgen.source import Diagnostic, Source, Span
from pkgen.system.exits import UsageError
from pkgen.system.near import near

KINDS = ("random", "grid", "list", "sobol", "latin")
SECTIONS = (*KINDS, "refine")
MOST_LEVELS = 30
OWN = ("members", "seed", "keep")
TEXTS = ("until", "method", "every", "step", "rtol", "atol", "max_step", "scene", "record", "at")
LISTS = ("set", "start", "size", "tableau", "composition")
OTHERS = {"iteration": str, "max_steps": int, "portable": bool, "libm": bool, "no_reduce": str}
KEYS = (*OWN, *TEXTS, *LISTS, *OTHERS)

_SECTION = re.compile(r"\s*\[\s*([^\[\]]+?)\s*\]\s*(?:#.*)?$")
_KEY = re.compile(r"""\s*("[^"]*"|'[^']*'|[\w.-]+)\s*=\s*""")


@record
class Plan:
    """The content of a plan; its names are not yet resolved in the model."""

    source: Source
    options: dict[str, object]  # options of `pkgen run`, by name
    kind: str
    axes: dict[str, Any]  # sampled quantities, by name
    members: int | None
    seed: int
    keep: tuple[str, ...]
    # The keys "where" and "levels" of the section [refine]; empty if there is no such section.
    refine: dict[str, Any]
    # Positions of values, by section and key.
    places: dict[tuple[str, str], Span] = field(repr=False)

    def wrong(self, section: str, key: str, message: str, help: str = "") -> UsageError:
        """Returns an error about a key, with the position of its value."""
        span = self.places.get((section, key)) or self.places.get((section, ""), Span(0, 0))
        return UsageError(Diagnostic(message, span, help).text(self.source))

    def wrong_within(self, section: str, key: str, text: str, found: Diagnostic) -> UsageError:
        """Returns an error at a position in `text`, which is part of the value of a key."""
        whole = self.places.get((section, key), Span(0, 0))
        at = self.source.text.find(text, whole.start, whole.end)
        message = f"{key}: {found.message}"
        if at < 0 or not text:
            return self.wrong(section, key, message, found.help)
        start = at + min(found.span.start, len(text) - 1)
        end = max(start + 1, min(at + found.span.end, at + len(text)))
        return UsageError(Diagnostic(message, Span(start, end), found.help).text(self.source))

    def of_a_run(self, options: argparse.Namespace) -> argparse.Namespace:
        """Returns the options of a run: `options`, replaced by the plan's options. Plans are
        untrusted, so error messages do not quote the tableau files that a plan names."""
        more = {"unquoted": self.options.get("tableau", ())}
        return argparse.Namespace(**{**vars(options), **self.options, **more})

    def refuse_foreign(self, model: str) -> None:
        """Raises UsageError if the plan names files outside its own folder and the model's."""
        folders = [os.path.dirname(path) for path in (self.source.path, model)]
        for file in self.options.get("tableau", ()):
            if why := refusal(file, file, *folders):
                raise self.wrong("", "tableau", why, ALLOW)


def read_plan(path: str) -> Plan:
    """Reads a plan from a file. Raises UsageError or ModelError with the position of an error."""
    return of_text(read_text(path, "a plan in TOML"))


def of_text(source: Source) -> Plan:
    try:
        import tomllib
    except ImportError:  # Python 3.10
        try:
            import tomli as tomllib
        except ImportError:
            raise UsageError("plans are read by tomli: pip install tomli") from None
    try:
        said = tomllib.loads(source.text)
    except tomllib.TOMLDecodeError as error:
        said = re.fullmatch(r"(.*) \(at line (\d+), column (\d+)\)", str(error))
        place, why = (f":{said[2]}:{said[3]}", said[1]) if said else ("", str(error))
        raise UsageError(f"{source.path}{place}: not TOML: {why}") from None
    except ValueError:  # Python limits the digits of an integer
        raise UsageError(f"{source.path}: not a plan: a number of thousands of digits") from None
    except RecursionError:
        raise UsageError(f"{source.path}: not a plan: brackets within brackets") from None
    made = Plan(source, {}, "", {}, None, 0, (), {}, _places(source.text))
    said = {key.replace("-", "_"): value for key, value in said.items()}
    _refuse_unknown(made, said)
    kinds = [kind for kind in KINDS if kind in said]
    if len(kinds) != 1:
        two = f"[{kinds[0]}] and [{kinds[1]}]: members are drawn in one way" if kinds else ""
        none = "the plan has no axes: [random], [grid], [list], [sobol] or [latin]"
        raise made.wrong(kinds[1] if two else "", "", two or none)
    kind = kinds[0]
    if not said[kind]:
        raise made.wrong(kind, "", f"[{kind}] has no axes: parameters or starts with their ranges")
    members = _whole(made, said, "members", None, 1)
    seed = _whole(made, said, "seed", 0, 0)
    if seed is not None and seed >= 1 << 64:
        raise made.wrong("", "seed", "a seed is below 2^64")
    keep = said.get("keep", ["final"])
    keep = [keep] if isinstance(keep, str) else keep
    if not isinstance(keep, list) or not keep or not all(isinstance(x, str) for x in keep):
        raise made.wrong("", "keep", 'what is kept is a list, e.g. ["final", "max(x)"]')
    options = {key: _option(made, key, said[key]) for key in said if key in KEYS and key not in OWN}
    refine = _refine(made, said.get("refine", {}))
    return Plan(source, options, kind, said[kind], members, seed, tuple(keep), refine, made.places)


def _refuse_unknown(plan: Plan, said: Mapping[str, object]) -> None:
    for key, value in said.items():
        if key in SECTIONS and isinstance(value, dict):
            continue
        if key in SECTIONS:
            raise plan.wrong("", key, f"{key} is a section: [{key}]")
        if key in KEYS and (not isinstance(value, dict) or key in ("set", "start")):
            continue
        shown = f"[{key}]" if isinstance(value, dict) else f"'{key}'"
        at = (key, "") if isinstance(value, dict) else ("", key)
        said_near = near(key, [*KEYS, *SECTIONS], "option")
        raise plan.wrong(*at, f"a plan has no {shown}", said_near)


def _refine(plan: Plan, said: Mapping[str, object]) -> dict[str, Any]:
    for key in said:
        if key not in ("where", "levels"):
            said_near = near(key, ["where", "levels"], "option")
            raise plan.wrong("refine", key, f"[refine] has no '{key}'", said_near)
    if said and not ("where" in said and isinstance(said["where"], str) and "levels" in said):
        raise plan.wrong("refine", "", '[refine] takes where = "status" and levels = 3')
    levels = said.get("levels", 1)
    if isinstance(levels, bool) or not isinstance(levels, int) or not 1 <= levels <= MOST_LEVELS:
        raise plan.wrong("refine", "levels", f"levels are 1 to {MOST_LEVELS}")
    return dict(said)


def _whole(plan: Plan, said: Mapping[str, object], key: str, usual: int | None, least: int):
    value = said.get(key, usual)
    if isinstance(value, float) and value.is_integer():
        value = int(value)  # in TOML 1e6 is a float
    if value is not None and (not isinstance(value, int) or isinstance(value, bool)):
        raise plan.wrong("", key, f"{key} is a whole number")
    if value is not None and value < least:
        raise plan.wrong("", key, f"{key} must be at least {least}")
    return value


def _option(plan: Plan, key: str, value: object) -> object:
    """Returns the value of an option as argparse would return it."""
    if key in TEXTS:
        if isinstance(value, list) and key == "record":
            value = ",".join(map(str, value))
        if isinstance(value, bool) or not isinstance(value, str | int | float):
            raise plan.wrong("", key, f"{key} is one value, e.g. {key} = 1")
        return value if isinstance(value, str) else repr(value)
    if key in LISTS:
        if isinstance(value, dict):
            return [f"{name}={_text(plan, key, x)}" for name, x in value.items()]
        return [_text(plan, key, x) for x in (value if isinstance(value, list) else [value])]
    if not isinstance(value, OTHERS[key]) or (OTHERS[key] is int and isinstance(value, bool)):
        kinds = {str: "a text", int: "a whole number", bool: "true or false"}
        raise plan.wrong("", key, f"{key} is {kinds[OTHERS[key]]}")
    if key == "iteration" and value not in ITERATIONS:
        raise plan.wrong("", key, "iteration is newton or fixed")
    return value


def _text(plan: Plan, key: str, value: object) -> str:
    if isinstance(value, bool) or not isinstance(value, str | int | float):
        raise plan.wrong("", key, f'{key} is a list of texts, e.g. {key} = ["m=2 [kg]"]')
    return value if isinstance(value, str) else repr(value)


def _places(text: str) -> dict[tuple[str, str], Span]:
    """Returns the positions of values, by section and key, and of section headers (key ""); tomllib
    has no positions."""
    found: dict[tuple[str, str], Span] = {}
    section, at = "", 0
    for line in text.split("\n"):
        head, key = _SECTION.match(line), _KEY.match(line)
        if head:
            section = head[1].strip("\"'")
            found.setdefault((section, ""), Span(at + line.index("["), at + line.index("]") + 1))
        elif key:
            name = key[1].strip("\"'")
            value = line[key.end() :].split(" #")[0].rstrip()
            start = at + key.end() if value else at + line.index(key[1])
            span = Span(start, start + max(1, len(value)))
            found.setdefault((section, name if section else name.replace("-", "_")), span)
        at += len(line) + 1
    return found
