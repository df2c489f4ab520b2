"""Analyses a model's text while it is edited: errors, and the meanings of names.

A position in the text is resolved to a token of the lexer. The meaning of a name is from the
checker, even if there are errors elsewhere.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from itertools import pairwise

from lark.lexer import Token

from pkgen.compiler import check_model
from pkgen.front.check.check import Seen, see
from pkgen.front.check.names import KIND_TEXT, Entry
from pkgen.front.check.values import NoValue, evaluate
from pkgen.front.joints import KINDS, joint_names
from pkgen.front.lexed import Lexed
from pkgen.front.lexer import statements
from pkgen.front.parse import parse_all
from pkgen.front.read import from_text, with_parts
from pkgen.front.statements import Joint
from pkgen.front.table import STATEMENTS
from pkgen.front.units import UnitError, described, parse_unit, si_text
from pkgen.indices import made_of, multipliers
from pkgen.methods import known
from pkgen.scenes import check as scene_check
from pkgen.source import Diagnostic, ModelError, Source, Span

from .words import built_in, calls

NAMES = ("NAME", "FUNCTION")


class Text:
    """The text of a model and its analysis, computed when it is needed."""

    def __init__(self, path: str, text: str) -> None:
        self.wrong: tuple[Diagnostic, ...] = ()
        try:
            self.source = self.whole = from_text(path, text)
        except ModelError as error:  # the text has a NUL character
            self.source = self.whole = Source(path, "")
            self.wrong = tuple(error.diagnostics)
        try:
            self.whole = with_parts(self.source)
        except ModelError as error:
            self.wrong = tuple(self._own(d, error.source) for d in error.diagnostics)

    @cached_property
    def lexed(self) -> list[Lexed]:
        own = len(self.source.text)
        return [s for s in statements(self.whole) if s.span.start <= own]

    @cached_property
    def seen(self) -> Seen:
        return see(parse_all(self.whole))

    @cached_property
    def names(self) -> dict[str, Entry]:
        return self.seen.names.table

    def findings(self) -> list[Diagnostic]:
        """Returns the errors and warnings that are found without deriving equations."""
        return list(self.wrong or map(self._own, (*self.seen.errors, *self.seen.warnings)))

    def _own(self, d: Diagnostic, source: Source | None = None) -> Diagnostic:
        """Returns a finding in a part as one at the statement that uses it."""
        source = source or self.whole
        if not source.piece(d.span.start).part:
            return d
        return replace(
            d, message=f"{source.place(d.span)}: {d.message}", span=self._here(d.span, source)
        )

    def _here(self, span: Span, source: Source | None = None) -> Span:
        """Returns a span in this text: of one in a part, the statement that uses it."""
        own, *in_part = (source or self.whole).order(span.start)
        return Span(own, own + len("use")) if in_part else span

    def all_findings(self) -> list[Diagnostic]:
        """Returns all errors and warnings, like `pkgen check`: also those found in equations
        (claims, energies, scenes)."""
        if self.wrong or self.seen.errors:
            return self.findings()
        try:
            model, warnings = check_model(self.whole)
            scenes = [scene_check.wrong(model, {}, scene) for scene in model.scenes if scene.listed]
        except ModelError as error:
            return [*map(self._own, (*error.diagnostics, *self.seen.warnings))]
        found = (*warnings, *(finding for found in scenes for finding in found))
        return [*map(self._own, found)]

    # ---- places

    def statement_at(self, offset: int) -> Lexed | None:
        """Returns the last statement that begins at or before an offset in the text."""
        before = (s for s in self.lexed if s.tokens and s.tokens[0].start_pos <= offset)
        return max(before, key=lambda s: s.tokens[0].start_pos, default=None)

    def token_at(self, offset: int) -> Token | None:
        statement = self.statement_at(offset)
        tokens = statement.tokens if statement else ()
        touching = [t for t in tokens if t.start_pos <= offset <= t.end_pos]
        return max(touching, key=lambda t: (t.type in NAMES, t.start_pos), default=None)

    def text(self, token: Token) -> str:
        return self.source.text[token.start_pos : token.end_pos]

    def all_tokens(self) -> Iterator[tuple[Lexed, Token]]:
        return ((statement, token) for statement in self.lexed for token in statement.tokens)

    def before(self, token: Token) -> Token | None:
        """Returns the previous token in its statement."""
        statement = self.statement_at(token.start_pos)
        tokens = statement.tokens if statement else []
        return next((a for a, b in pairwise(tokens) if b is token), None)

    def is_axis(self, token: Token) -> bool:
        """Whether a token is an axis, not a name, like z in `draw ground z = 0`."""
        before = self.before(token)
        return before is not None and before.type == "SHAPE" and str(before) in ("ground", "plane")

    def _headed(self, token: Token) -> str:
        """Describes the name of a method, a scene or a model by the keyword before it. The checker
        has no table of such names."""
        before = self.before(token)
        word = before.type if before is not None else ""
        method = known(self.seen.parts["methods"]).get(str(token))
        if word == "METHOD" and method is not None:
            of = f"a method of the family {method.family.lower()}"
            return f"{of}, {', '.join(sorted(method.traits))}".rstrip(", ")
        return {"SCENE": "a scene", "MODEL": "the model's name"}.get(word, "")

    # ---- names

    @cached_property
    def made(self) -> dict[str, tuple[str, str]]:
        """Maps derived names, such as p_x, to their declared name and a description."""
        found: dict[str, tuple[str, str]] = {}
        for name, entry in self.names.items():
            if entry.kind in ("coordinate", "rotation"):
                found[made_of("p_{}", name)] = name, f"the momentum of {name}"
            elif entry.kind == "constraint":
                for made in multipliers(name):
                    found[made] = name, f"a multiplier of {name}: the force that keeps it"
        for joint in self.joints:
            own = joint.left.name
            for name, what in joint_names(joint):
                if name != own and name.startswith(own) and not self._is_written(name):
                    found[name] = own, f"the {what} of the joint {own}"
                    found[made_of("p_{}", name)] = own, f"the momentum of {name}"
        return found

    def _is_written(self, name: str) -> bool:
        """Whether a clause `coord` of a joint declares this name."""
        joints = (s.tokens for s in self.lexed if s.keyword == "joint")
        return any(str(t) == name and t.type == "NAME" for tokens in joints for t in tokens)

    @property
    def joints(self) -> list[Joint]:
        known = parse_all(self.whole).statements
        return [s for s in known if isinstance(s, Joint) and s.kind[0] in KINDS]

    def base(self, name: str) -> str:
        """Returns the declared name that a name is derived from; else the name itself."""
        return self.made.get(name, (name, ""))[0]

    def declared_at(self, name: str, statement: Lexed | None) -> Span | None:
        """Returns the span of the declaration of a name. The declaration of a loop variable is in
        the statement that uses the variable."""
        entry = self.names.get(self.base(name))
        if entry is not None and entry.span.end:
            here = self._here(entry.span).start
            return Span(here, here + self._length(here))
        for tokens in (s.tokens for s in self.scope(name, statement)):
            for token, after in pairwise(tokens):
                if token.type == "NAME" and str(token) == name and after.type == "EQUAL":
                    return Span(token.start_pos, token.end_pos)
        return None

    def scope(self, name: str, statement: Lexed | None) -> list[Lexed]:
        """Returns the scope of a loop variable: its own statement, or its swarm's whole scene."""
        if statement is None:
            return []
        scene: list[Lexed] = []
        for other in self.lexed:
            scene = [other] if other.keyword == "scene" else [*scene, other]
            if other.keyword == "end":
                if statement in scene and any(_runs(s, name) for s in scene):
                    return scene
                scene = []
        return [statement]

    def _length(self, start: int) -> int:
        token = self.token_at(start)
        return token.end_pos - token.start_pos if token and token.start_pos == start else 1

    @cached_property
    def parts(self) -> dict[str, object]:
        """Returns the checker's objects for declarations (with units, ranges, ...), by name."""
        found = {}
        for items in self.seen.parts.values():
            for item in items:
                item = item[0] if isinstance(item, tuple) else item  # an input
                name = getattr(item, "name", None)
                if name and hasattr(item, "span"):
                    found.setdefault(name.partition("[")[0], item)
        return found

    def unit(self, name: str) -> str | None:
        """Returns the SI unit of a name as text; None if it is unknown."""
        item = self.parts.get(name) or self.parts.get(f"{name}.x")
        if isinstance(getattr(item, "unit", None), str):
            return item.unit
        entry = self.names.get(name)
        dimension = entry.facts.dimension if entry is not None else None
        return None if dimension is None else si_text(dimension)

    @cached_property
    def values(self) -> dict[str, float]:
        """Returns the numeric values of sizes, constants and parameter defaults, by name."""
        found: dict[str, object] = dict(self.seen.sizes)
        sizes = {n: v for n, v in self.seen.sizes.items() if isinstance(v, int)}
        items = [*self.seen.parts.get("definitions", ()), *self.seen.parts.get("parameters", ())]
        for item in sorted(items, key=lambda item: self.whole.order(item.span.start)):
            value = getattr(item, "default", None) or getattr(item, "value", None)
            if item.name in found or getattr(item, "range", None) is not None:
                continue
            try:
                found[item.name] = evaluate(value, found, sizes)
            except (NoValue, LookupError, TypeError, ArithmeticError):
                continue  # definitions that are not constant are skipped
        return {n: float(v) for n, v in found.items() if isinstance(v, int) or _is_number(v)}

    # ---- descriptions of tokens and units

    def hover(self, offset: int) -> tuple[Span, str] | None:
        """Returns the span of the token at an offset and its description in Markdown, or None."""
        token = self.token_at(offset)
        if token is None:
            return None
        said = self._said(token, str(token))
        return (Span(token.start_pos, token.end_pos), said) if said else None

    def _said(self, token: Token, name: str) -> str:
        if token.type in ("FUNCTION", "SUM") and name in calls():
            return "`{}`: {}".format(*calls()[name])
        if token.type == "UNIT":
            return self._of_unit(name)
        if token.type == name.upper() and name in STATEMENTS:
            return f"```lag\n{STATEMENTS[name].form}\n```"
        if token.type not in NAMES or self.is_axis(token):
            return ""
        if head := self._headed(token):
            return f"**{name}**: {head}"
        if name in self.made:
            unit = self.unit(name)
            return f"**{name}**: {self.made[name][1]}" + (f" [{unit}]" if unit else "")
        if name in self.names and self.names[name].kind != "poisoned":
            return self._of_name(name)
        if name in built_in():
            return f"**{name}**: {built_in()[name]}"
        at = self.declared_at(name, self.statement_at(token.start_pos))
        return f"**{name}**: a loop variable" if at else ""

    def _of_unit(self, text: str) -> str:
        try:
            unit = parse_unit(text)
        except UnitError as error:
            return error.message
        factor = f" = {float(unit.factor) * 3.141592653589793**unit.pi:.10g}"
        plain = si_text(unit.dimension, unit.angle)
        return (
            f"`[{text}]`{'' if unit.is_si else f'{factor} [{plain}]'}: {described(unit.dimension)}"
        )

    def _of_name(self, name: str) -> str:
        entry, item = self.names[name], self.parts.get(name)
        unit = self.unit(name)
        said = [f"**{name}**: {KIND_TEXT[entry.kind]}" + (f" [{unit}]" if unit else "")]
        if name in self.values:
            said.append(f"= {self.values[name]:.10g}")
        if isinstance(getattr(item, "rate_unit", None), str) and item.rate_unit:
            said.append(f"(its rate [{item.rate_unit}])")
        lines = [" ".join(said)]
        if description := getattr(item, "description", ""):
            lines.append(description)
        line = self.whole.line(entry.span.start)
        lines.append(f"```lag\n{line.partition('#')[0].strip()}\n```")
        return "\n\n".join(lines)

    def inlays(self) -> Iterator[tuple[int, str]]:
        """Yields (offset, unit) for each definition whose unit is not written; editors display the
        unit at the offset."""
        for statement in self.lexed:
            if statement.keyword not in ("let", "const", "observe", "conserve", "param"):
                continue
            tokens = statement.tokens
            bounds = (i for i, t in enumerate(tokens) if t.type == "IN")
            last = tokens[next(bounds, len(tokens)) - 1]
            if len(tokens) < 4 or last.type == "UNIT" or statement.errors:
                continue
            unit = self.unit(str(tokens[1]))
            if unit and self.names[str(tokens[1])].facts.known:
                yield last.end_pos, f" [{unit}]"


def _runs(statement: Lexed, name: str) -> bool:
    """Whether the statement is a swarm whose loop variable has this name."""
    return statement.keyword == "swarm" and str(statement.tokens[1]) == name


def _is_number(value: object) -> bool:
    return hasattr(value, "__float__")
