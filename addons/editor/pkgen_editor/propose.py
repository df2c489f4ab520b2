"""Edits that an editor proposes: completions, quick fixes, renaming."""

from __future__ import annotations

import re
from collections.abc import Iterator

from pkgen.front.joints import CLAUSES, KINDS, SHOWN, TO
from pkgen.front.lexer import statements
from pkgen.front.parse import parse_all
from pkgen.front.shapes import SHAPES, shapes_of
from pkgen.front.table import BOTH, IN_SAMPLE, MODEL, SCENE, STATEMENTS, SYNTAX
from pkgen.front.units import known_units
from pkgen.front.words import CLAUSE_WORDS, TABLEAU, reserved
from pkgen.methods import known
from pkgen.record import record
from pkgen.source import Diagnostic, Source, Span

from .look import NAMES, Text
from .words import built_in, calls

_SOME_NAME = "pk_q"  # Placeholder for the word that is being written.
# \Z matches at the end of the text only; $ would also match before a final newline.
_WORD = re.compile(r"[^\W\d]\w*\Z")
_IN_UNIT = re.compile(r"[\w'\)\]][ \t]+\[[^\[\]\n#]*$|[\)'\d]\[[^\[\]\n#]*$")
_NUMBERED = re.compile(r"[^\W\d]\w*\[[^\[\]\n#]*$")


@record
class Proposal:
    label: str
    kind: str  # one of "statement", "clause", "name", "function", "unit", "method", "member"
    detail: str = ""


class Refused(Exception):
    """A name cannot be renamed; the message says why."""


# ---- words


def proposals(text: Text, offset: int) -> list[Proposal]:
    """Returns completions for the word that ends at an offset in the text."""
    written = text.source.text[:offset]
    written = written[
        : len(written) - len(word.group()) if (word := _WORD.search(written)) else None
    ]
    line = written[written.rfind("\n") + 1 :]
    if "#" in line:
        return []
    if _IN_UNIT.search(line) and not _NUMBERED.search(line):
        return [Proposal(name, "unit") for name in known_units()]
    if line.endswith("."):
        return [Proposal(name, "member") for name in _members(text, line)]
    lexed = statements(Source("", written + _SOME_NAME))[-1]
    at = next((t for t in lexed.tokens if t.end_pos > len(written)), None)
    before = [t for t in lexed.tokens if t.start_pos < len(written)]
    first = before[0].type if before else ""
    if not before:
        return list(_statements(text, offset))
    if first in ("DRAW", "VIEW") and len(before) == 1:
        return [Proposal(n, "clause", s.form) for n, s in shapes_of(first.lower()).items()]
    if at is not None and at.type == "WORD":
        return [Proposal(word, "clause") for word in _parts(before)]
    if first == "METHOD" and len(before) == 1:
        own = text.seen.parts["methods"]
        return [Proposal(name, "method") for name in known(own)]
    clauses = _clauses(first.lower()) if before[-1].type not in ("EQUAL", "COLON") else []
    return [*(Proposal(word, "clause") for word in clauses), *_expressions(text, offset)]


def _statements(text: Text, offset: int) -> Iterator[Proposal]:
    inside = ""
    for statement in text.lexed:
        if statement.tokens and statement.tokens[-1].end_pos < offset:
            starts = statement.keyword if statement.keyword in ("scene", "sample") else inside
            inside = "" if statement.keyword == "end" else starts
    for word, row in STATEMENTS.items():
        here = row.stands_in in (BOTH, SCENE if inside else MODEL)
        if word in (*IN_SAMPLE, "end") if inside == "sample" else here:
            yield Proposal(word, "statement", row.form)


def _parts(before: list) -> list[str]:
    """Returns the keywords that may still be added to a drawing, body or joint statement with
    tokens `before`."""
    written = {str(token) for token in before if token.type == "WORD"}
    if before[0].type in ("BODY", "JOINT"):
        words = list(CLAUSES[before[0].type.lower()])
        if before[0].type == "JOINT":
            words = [*KINDS] if written == {TO} else words if written else [TO]
    else:
        words = list(SHAPES[str(before[1])].parts) if before[1].type == "SHAPE" else []
    return [word for word in words if word not in written]


def _clauses(word: str) -> list[str]:
    """Returns the keywords of the clauses that may follow in a statement with the keyword
    `word`."""
    if word not in STATEMENTS:
        return []
    syntax = SYNTAX[STATEMENTS[word].syntax].lower()
    meant = {"interval": ("in",), "direction": ("rising", "falling", "either")}
    found = [w for rule in re.findall(r"[a-z]+", syntax) for w in meant.get(rule, (rule,))]
    return [w for w in found if w in CLAUSE_WORDS or w == TABLEAU]


def _members(text: Text, line: str) -> tuple[str, ...]:
    found = re.search(r"([^\W\d]\w*)(?:\[[^\[\]]*\])?\.$", line)
    entry = text.names.get(found[1]) if found else None
    return SHOWN if entry is not None and entry.kind == "body" else ("x", "y", "z")


def _expressions(text: Text, offset: int) -> Iterator[Proposal]:
    for name, entry in text.names.items():
        if "." not in name and "[" not in name and entry.kind not in ("model", "scene", "poisoned"):
            unit = text.unit(name)
            item = text.parts.get(name)
            said = (f"[{unit}]" if unit else "", getattr(item, "description", ""))
            yield Proposal(name, "name", " ".join(filter(None, said)))
    for name, (form, what) in calls().items():
        yield Proposal(name, "function", f"{form}: {what}")
    for name, (_, what) in text.made.items():
        yield Proposal(name, "name", what)
    for name, what in built_in().items():
        yield Proposal(name, "name", what)


# ---- repairs

_HINTS = (
    re.compile(r"did you mean ('.+)\?"),
    re.compile(r"did you mean (\S+)\?"),
    re.compile(r"write (\w+)\(…\)$"),
    re.compile(r"square brackets: ([^;]+)"),
    re.compile(r"(?:a unit|, ): ?(\S+ \[[^\]]+\])"),
    re.compile(r"(?:write|(?<!unit is )written) ([^…;]+?)(?:;.*|, .*)?$"),
)

_PROSE = re.compile(r"[a-z]{2,} [a-z]{2,}|[a-z]{2,} \[[a-z], ")


def repairs(text: Text, finding: Diagnostic) -> Iterator[tuple[Span, str]]:
    """Yields quick fixes (span, replacement) from the hint of an error. A fix must remove the error
    and add no errors in other lines."""
    whole, tried = text.source.text, set()
    for hint in _HINTS:
        found = hint.search(finding.help)
        for instead in re.findall(r"'([^']+)'", found[1]) or [found[1]] if found else ():
            span, instead = _placed(whole, finding.span, instead)
            if (span, instead) in tried or _PROSE.search(instead):
                continue
            tried.add((span, instead))
            other = Text(text.source.path, whole[: span.start] + instead + whole[span.end :])
            if _mends(text, finding, other):
                yield span, instead


def _mends(text: Text, finding: Diagnostic, other: Text) -> bool:
    if any((d.message, d.span.start) == _named(finding) for d in other.findings()):
        return False
    syntax, before = (parse_all(one.whole).diagnostics for one in (other, text))
    if len(syntax) > len(before):
        return False
    line = text.source.position(finding.span.start)[0]

    def elsewhere(one: Text) -> int:
        return sum(one.source.position(e.span.start)[0] != line for e in one.seen.errors)

    return elsewhere(other) <= elsewhere(text)


def _named(finding: Diagnostic) -> tuple[str, int]:
    return finding.message, finding.span.start


def _placed(text: str, span: Span, instead: str) -> tuple[Span, str]:
    """Removes from a replacement the prefix that the text already has before the span: if `q[1..3]`
    replaces the `[3]` of `q[3]`, the `q` is removed."""
    for k in range(len(instead), 0, -1):
        if text.endswith(instead[:k], 0, span.start) and not text[span.start :].startswith(instead):
            rest = instead[k:].lstrip() if text[span.start - 1] == " " else instead[k:]
            return span, rest
    return span, instead


# ---- another name


def uses(text: Text, offset: int) -> list[tuple[Span, str]]:
    """Returns all occurrences of the name at an offset, as (span, text). The text is the name
    itself, or a name derived from it."""
    token = text.token_at(offset)
    if token is None or token.type not in NAMES or text.is_axis(token):
        return []
    name = text.base(str(token))
    if name not in text.names:  # loop variables are local to their statement
        statement = text.statement_at(offset)
        if text.declared_at(name, statement) is None:
            return []
        scope = [t for s in text.scope(name, statement) for t in s.tokens]
        mine = [t for t in scope if t.type in NAMES and str(t) == name]
        return [(Span(t.start_pos, t.end_pos), name) for t in mine]
    return [
        (Span(t.start_pos, t.end_pos), str(t))
        for _, t in text.all_tokens()
        if t.type in NAMES and text.base(str(t)) == name and not text.is_axis(t)
    ]


def renamed(text: Text, offset: int, new: str) -> list[tuple[Span, str]]:
    """Returns the edits of a renaming, as (span, new text). Raises Refused."""
    places = uses(text, offset)
    token = text.token_at(offset)
    if not places:
        what = "what stands here" if token is None else f"'{text.text(token)}'"
        raise Refused(f"{what} is no name of this model's own")
    old = text.base(str(token))
    if not re.fullmatch(r"[^\W\d]\w*", new):
        raise Refused(f"'{new}' is no name: letters, digits and '_'")
    if why := reserved(new):
        raise Refused(f"'{new}' {why} and cannot be a name")
    changes = [(span, _other(name, old, new)) for span, name in places]
    taken = {str(t) for _, t in text.all_tokens() if t.type in NAMES}
    for made in sorted({new, *(name for _, name in changes)}):
        if made in taken | text.names.keys() | text.made.keys() | built_in().keys():
            raise Refused(f"'{made}' has a meaning in this model already")
    whole, at, pieces = text.source.text, 0, []
    for span, name in changes:
        pieces += [whole[at : span.start], name]
        at = span.end
    other = Text(text.source.path, "".join([*pieces, whole[at:]]))
    if len(other.seen.errors) > len(text.seen.errors):
        worse = next(e for e in other.seen.errors if e.message not in _messages(text))
        raise Refused(f"with that name: {worse.message}")
    return changes


def _messages(text: Text) -> set[str]:
    return {error.message for error in text.seen.errors}


def _other(name: str, old: str, new: str) -> str:
    """Returns the derived name `name` after the declared name `old` in it is changed to `new`:
    `p_old` becomes `p_new`. Names of a joint's coordinates are changed likewise."""
    head, _, tail = (
        name.rpartition(old) if not name.startswith(old) else ("", old, name[len(old) :])
    )
    return head + new + tail
