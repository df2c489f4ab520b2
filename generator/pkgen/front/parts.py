"""Joins the statements of a model and of its parts to those of one model.

The names of a part get the name of the part in front: `phi` of the part `left` is `left.phi`. The
statements of a part stand where it is used.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, is_dataclass, replace

from .. import limits
from ..source import Diagnostic, Source, Span
from ..system.near import meant
from ..tree import Expr, names
from . import statements as st
from .declarations import declarations
from .joints import GROUND
from .lexed import Lexed
from .parse_errors import declared_names
from .words import CONSTANTS

# Names that mean the same in a part and in its user, unless the part declares them.
_COMMON = frozenset((*CONSTANTS, "T", "V", "L", "V_eff", "O", GROUND))


def prefixed(source: Source, lexed: list[Lexed]) -> list[Lexed]:
    """Puts the name of its part in front of each name in a part."""
    own: dict[str, set[str]] = {}
    tables: dict[str, set[str]] = {}
    of_parts = [(s, source.piece(s.span.start).part) for s in lexed] if source.parts else []
    for statement, part in of_parts:
        own.setdefault(part, set()).update(declared_names(statement))
        if statement.keyword == "table":
            tables.setdefault(part, set()).update(declared_names(statement))
    for statement, part in of_parts:
        common, types = _COMMON - own[part], [t.type for t in statement.tokens]
        # No names of the model: that of a method, `consistent`, the axis in `draw ground y = 0`.
        ground, alone = types[3:4] == ["EQUAL"], len(types) == 2  # start consistent
        no_names = {"method": 1, "draw": 2 * ground, "start": alone}
        no_name = no_names.get(statement.keyword)
        # The columns of a table, and what follows them, are no names of the model either.
        tokens = statement.tokens[: 2 if statement.keyword == "table" else None]
        for k, token in enumerate(tokens if part else ()):
            if token.type == "FUNCTION" and token in tables.get(part, ()):
                statement.tokens[k] = token.update(value=part + token)
            if token.type == "NAME" and token in common & own.get("", set()):
                message = f"'{token}' is that of the whole model, which declares another '{token}'"
                at = Span(token.start_pos, token.end_pos)
                statement.errors.append(Diagnostic(message, at, "give one of them another name"))
            if token.type == "NAME" and token not in common and k != no_name:
                statement.tokens[k] = token.update(value=part + token)
                if len(part + token) > limits.NAME_LENGTH:
                    message = f"'{part}{token}' is longer than {limits.NAME_LENGTH} characters"
                    statement.errors.append(Diagnostic(message, statement.span))
    return lexed


class Parts:
    """The statements of one model, made of those of all files; `errors` are found on the way."""

    def __init__(self, source: Source, statements: list[st.Statement]) -> None:
        self.source, self.errors = source, []
        self.of: dict[str, list[st.Statement]] = {piece.part: [] for piece in source.pieces}
        self.of[""] = []
        for statement in statements:
            self.of[source.piece(statement.span.start).part].append(statement)
        self.statements = self._ordered(self._driven([*self._spliced("")]))

    def _error(self, message: str, at: object, help: str = "") -> None:
        self.errors.append(Diagnostic(message, getattr(at, "span", at), help))

    def _spliced(self, part: str) -> Iterator[st.Statement]:
        for statement in self.of[part]:
            yield statement
            if isinstance(statement, st.Use):
                yield from self._used(statement, part)

    def _used(self, use: st.Use, user: str) -> list[st.Statement]:
        """Returns the statements of a part, with the values that its user gives."""
        part = f"{use.name}."
        if part not in self.of:
            help = 'write it on one line: use "FILE" as NAME, the name in ASCII'
            self._error("this part cannot be read", use, help)
            return []
        if [s.keyword for s in self.of[part][:1]] != ["model"]:
            message = f"'{use.file}' is no model: its first statement is 'model NAME'"
            self._error(message, use)
        found = [s for s in map(_of_part, self._spliced(part)) if s is not None]
        places = {s.left.name: k for k, s in enumerate(found) if s.keyword in ("param", "size")}
        given: set[str] = set()
        for left, value in use.given:
            own = left.name.removeprefix(user)
            name, shown = part + own, [n.removeprefix(part) for n in places]
            shown = [n for n in shown if "." not in n]  # A part gives those of its own parts.
            if name not in places or name in given or left.index or left.range:
                help = meant(own, shown) or f"it has: {', '.join(shown[:12])}" * bool(shown)
                message = f"'{use.file}' has no parameter or size '{own}'"
                if any(name == other for s in found for other, _ in _inputs(s)):
                    help = f"an input is given by: set {name} = …"
                if name in given:
                    message, help = f"'{own}' is given already", "leave one of them out"
                self._error(message, left, help)
                continue
            given.add(name)
            what = {"given": value} if found[places[name]].keyword == "param" else {"value": value}
            found[places[name]] = replace(found[places[name]], **what)
        return found

    def _driven(self, statements: list[st.Statement]) -> list[st.Statement]:
        """Replaces each `set` outside of scenes by definitions of inputs, which are then declared
        no more."""
        inputs = {name: item for s in statements for name, item in _inputs(s)}
        driven: dict[str, st.Left] = {}
        found: list[st.Statement] = []
        for statement in statements:
            if statement.keyword != "set":
                found.append(statement)
                continue
            for left, value in statement.items:
                name, whole = left.name, left.index is None and left.range is None
                if name in driven:
                    first = self.source.place(driven[name].span)
                    self._error(
                        f"'{name}' is set already, at {first}", left, "leave one of them out"
                    )
                elif name not in inputs or not whole:
                    message = f"'set' outside of scenes gives inputs of parts; '{name}' is none"
                    help = 'a parameter is given by: use "FILE" as NAME with PARAMETER = VALUE'
                    self._error(message, left, help)
                else:
                    driven[name] = left
                    found.append(st.Drive(inputs[name][0], value, inputs[name][1], left.span))
        for k, statement in enumerate(found):
            if driven and statement.keyword == "input":
                own = [item for name, (item, _) in _inputs(statement) if name not in driven]
                found[k] = replace(statement, items=tuple(reversed(own)))
        return [s for s in found if s.keyword != "input" or s.items]

    def _ordered(self, statements: list[st.Statement]) -> list[st.Statement]:
        """Moves statements that use an input behind the `set` that gives it, or reports inputs that
        depend on themselves."""
        waiting, done = [(s, _mentioned(s)) for s in statements], []
        while waiting:
            unknown = {s.input.name for s, _ in waiting if isinstance(s, st.Drive)}
            later = []
            for statement, mentioned in waiting:
                if mentioned & unknown and not isinstance(statement, st.Scene):
                    later.append((statement, mentioned))
                    unknown |= {name for name, *_ in declarations([statement])}
                    continue
                done.append(statement)
                if isinstance(statement, st.Drive):
                    unknown.discard(statement.input.name)
            if len(later) == len(waiting):
                for drive in (s for s, _ in later if isinstance(s, st.Drive)):
                    help = "put a state between, or give one of them as a function of t"
                    self._error(f"the input '{drive.input.name}' depends on itself", drive, help)
                return done
            waiting = later
        return done


def _of_part(statement: st.Statement) -> st.Statement | None:
    """Returns the statement as that of a part. Claims of the part alone are outputs, and what a run
    of it shall look like is left out."""
    if statement.keyword in ("model", "view", "method", "exact"):
        return None
    if statement.keyword == "conserve":
        return replace(statement, keyword="observe")
    if isinstance(statement, st.Scene):
        clauses = tuple(c for c in statement.clauses if c.keyword not in ("expect", "exact"))
        return replace(statement, clauses=clauses) if clauses else None
    return statement


def _inputs(statement: st.Statement) -> Iterator[tuple[str, tuple[st.Declared, str]]]:
    """Yields the name of each input of a statement `input`, its declaration with its own unit, and
    the description."""
    unit = None
    for item in reversed(statement.items if statement.keyword == "input" else ()):
        unit = item.unit or unit
        yield item.name, (replace(item, unit=unit), statement.description)


def _mentioned(part: object) -> frozenset[str]:
    """Returns the names in a statement or in a part of it."""
    if isinstance(part, Expr):
        return names(part)
    inner = part if isinstance(part, tuple) else ()
    if is_dataclass(part):
        inner = [getattr(part, field.name) for field in fields(part)]
    own = frozenset((part.name,)) if isinstance(part, st.Left) else frozenset()
    return own.union(*map(_mentioned, inner))
