"""Formats the text of a model: the same tokens and comments, with normalised spaces.

Line breaks are kept. There are no spaces around the operators of products; there is one on each
side of the operators of sums and relations. Lines within a bracket are indented to the content of
the bracket; what a scene or a sample block contains is indented. In a block of lines, comments are
aligned; in a scene, the texts after the leading keywords of lines are aligned too. Other columns
that the author aligned stay aligned.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace

from lark.lexer import Token

from pkgen.front.lexer import statements
from pkgen.front.read import USE
from pkgen.front.table import STATEMENTS
from pkgen.source import ModelError, Source

OPENERS = frozenset(("LPAREN", "LINDEX", "LVECTOR", "LEND"))
CLOSERS = frozenset(("RPAREN", "RBRACKET", "REND"))
SIGNS = frozenset(("PLUS", "MINUS"))
TIGHT = frozenset(("TIMES", "OVER", "POWER", "DOTS"))
VALUE_ENDS = frozenset(("NAME", "NUMBER", "PRIME", "COMPONENT", "MEMBER", "UNIT")) | CLOSERS
# Tokens without a space before them (NONE_BEFORE) or after them (NONE_BEHIND).
NONE_BEFORE = CLOSERS | TIGHT | {"_COMMA", "PRIME", "COMPONENT", "MEMBER", "POINT", "LINDEX"}
NONE_BEHIND = OPENERS | TIGHT | {"FUNCTION", "SUM", "POINT"}
INDENT = 2  # Indentation in a scene or a sample block.
HANGING = 4  # Indentation after a bracket that is the last token of its line.
NEAR = 4
NEAR_COMMENT = 8
BEFORE_COMMENT = 2


@dataclass
class Line:
    """A line of the text: the tokens of one statement, and a comment."""

    number: int
    tokens: list[Token] = field(default_factory=list)
    comment: str = ""
    column: int = 0  # Original column of the comment.
    first: bool = False  # Whether it is the first line of its statement.
    last: bool = False
    inside: str = ""  # keyword of the block around the line
    indent: int = 0
    pieces: list[str] = field(default_factory=list)  # text of a token, with the space before it

    @property
    def code(self) -> str:
        return " " * self.indent + "".join(self.pieces) if self.pieces else ""


def laid_out(source: Source) -> str:
    """Returns the formatted text of a model. Raises ModelError for lexical errors."""
    source = replace(
        source, dotted=USE.search(source.text) is not None
    )  # Names of parts have dots.
    lexed = statements(source)
    errors = [error for statement in lexed for error in statement.errors]
    if errors:
        raise ModelError(source, errors)
    lines = _lines(source, lexed)
    _nested(lines)
    tight = set().union(*(_tight_signs(statement.tokens) for statement in lexed))
    before = None
    for line in lines:
        before = None if line.first else before
        line.pieces = _spaced(source, line, before, tight)
        before = line.tokens[-1] if line.tokens else before
    for block in _blocks(lines):
        _align_words(block)
        _keep_columns(source, block)
    _indented(lines)
    for block in _commented(lines):
        _align_comments(block)
    text = _joined(lines)
    if signs(replace(source, text=text)) != signs(source):
        raise AssertionError("the layout has changed what the text says")
    return text


def signs(source: Source) -> list[list[tuple[str, str]]]:
    """Returns the tokens and the comment of each statement; texts with equal results differ in
    spaces only."""
    return [
        [*((t.type, _text(source, t)) for t in statement.tokens), ("#", statement.comment)]
        for statement in statements(source)
    ]


def _text(source: Source, token: Token) -> str:
    return source.text[token.start_pos : token.end_pos]


def _lines(source: Source, lexed: Iterable) -> list[Line]:
    texts = source.text.split("\n")
    lines = [Line(i + 1) for i in range(len(texts))]
    ends = [0] * len(texts)  # column after the last token, per line
    for statement in lexed:
        for token in statement.tokens:
            number, column = source.position(token.start_pos)
            lines[number - 1].tokens.append(token)
            ends[number - 1] = column - 1 + token.end_pos - token.start_pos
        for token, flag in ((statement.tokens[0], "first"), (statement.tokens[-1], "last")):
            setattr(lines[source.position(token.start_pos)[0] - 1], flag, True)
    for line, text, end in zip(lines, texts, ends, strict=True):
        rest = text[end:]
        line.comment = rest.strip(" \t")
        line.column = end + len(rest) - len(rest.lstrip(" \t"))
    return lines


def _nested(lines: list[Line]) -> None:
    inside = ""
    for line in lines:
        word = line.tokens[0].type if line.first else ""
        line.inside = inside = "" if word == "END" else inside
        inside = inside or (word if word in ("SCENE", "SAMPLE") else "")


def _tight_signs(tokens: list[Token]) -> set[int]:
    """Returns the positions of the signs + and - that belong to an index or a range, such as
    i+1..N."""
    found: set[int] = set()
    # [bracket, whether ".." occurs in it, positions of signs]
    waiting: list[list] = [["", False, []]]
    for token in tokens:
        if token.type in OPENERS:
            waiting.append([token.type, False, []])
        elif token.type in CLOSERS and len(waiting) > 1:
            found |= _of_part(waiting.pop())
        elif token.type in ("_COMMA", "EQUAL", "WORD"):
            found |= _of_part(waiting[-1])
            waiting[-1][1:] = [False, []]
        elif token.type == "DOTS":
            waiting[-1][1] = True
        elif token.type in SIGNS:
            waiting[-1][2].append(token.start_pos)
    for part in waiting:
        found |= _of_part(part)
    return found


def _of_part(part: list) -> set[int]:
    opener, dots, places = part
    return set(places) if dots or opener == "LINDEX" else set()


def _spaced(source: Source, line: Line, before: Token | None, tight: set[int]) -> list[str]:
    """Returns the texts of a line's tokens, each with the space before it; `before` is the previous
    token of the statement, in a line above."""
    pieces: list[str] = []
    # Whether the previous token is a sign without a space after it: a unary sign, or one in an
    # index.
    signed = False
    for token in line.tokens:
        text = _text(source, token)
        binary = before is not None and before.type in VALUE_ENDS
        space = before is not None and not signed and before.type not in NONE_BEHIND
        space = space and token.type not in NONE_BEFORE and token.type != "COLON"
        if token.type in SIGNS and binary:
            space = token.start_pos not in tight
        if before is not None and not space and _joins(_text(source, before), text, source.dotted):
            space = True
        pieces.append(" " + text if space and pieces else text)
        signed = token.type in SIGNS and (not binary or token.start_pos in tight)
        before = token
    return pieces


def _joins(left: str, right: str, dotted: bool) -> bool:
    """Whether two texts without a space between them would be lexed as one token. `dotted`: names
    have dots."""
    words = re.match(r"\w|\.\w", right) and re.search(r"\w$", left)
    apart = dotted or right[0] != "." or left[0].isdigit()
    return left + right == "**" or bool(words and apart)


def _blocks(lines: list[Line]) -> Iterator[list[Line]]:
    """Yields blocks of statements without lines between them. A block has the first line of each of
    its statements."""
    block: list[Line] = []
    for line in lines:
        heads = line.first and line.tokens[0].type in ("SCENE", "SAMPLE", "END")
        if line.first and not heads and (not block or line.inside == block[-1].inside):
            block.append(line)
        elif line.tokens and not line.first:
            continue
        else:
            yield block
            block = [line] if line.first and not heads else []
    yield block


def _align_words(block: list[Line]) -> None:
    """Aligns the texts after the leading keywords of consecutive lines, if the keywords have
    similar lengths. Only lines in scenes, and statements whose syntax is a keyword and one
    expression, are aligned."""
    run: list[Line] = []
    for line in block:
        widths = [len(one.pieces[0]) for one in (*run, line)]
        # None if the line does not begin with a statement's keyword.
        row = STATEMENTS.get(line.tokens[0].type.lower())
        alone = row is not None and (line.inside == "SCENE" or row.syntax == "single")
        behind = len(line.pieces) > 1 and alone
        if not behind or max(widths) - min(widths) > NEAR:
            _pad(run)
            run = []
        run += [line] if behind else []
    _pad(run)


def _pad(run: list[Line]) -> None:
    most = max((len(line.pieces[0]) for line in run), default=0)
    for line in run:
        line.pieces[1] = " " * (most - len(line.pieces[0])) + line.pieces[1]


@dataclass
class _Place:
    """A token in a column that the author aligned. `index` is its index in the line's tokens."""

    line: Line
    index: int
    # Index of the token that gets spaces before it: the sign of a signed number, or the token
    # itself.
    before: int

    @property
    def column(self) -> int:
        text = "".join(self.line.pieces[: self.index + 1])
        return len(text) - len(self.line.pieces[self.index].lstrip(" "))


def _keep_columns(source: Source, block: list[Line]) -> None:
    """Keeps columns: tokens that were aligned, with more than one space before some of them, stay
    aligned, as far left as possible."""
    for places in _columns(source, block):
        most = max(place.column for place in places)
        for place in places:
            pieces = place.line.pieces
            pieces[place.before] = " " * (most - place.column) + pieces[place.before]


def _columns(source: Source, block: list[Line]) -> Iterator[list[_Place]]:
    """Yields the aligned columns of the original text, from the left. A column is
    a set of tokens that begin at the same place in several lines. Second tokens of a line align
    with those of any statement, later tokens only with those of the same kind of statement. A
    column may skip lines."""
    # (whether more than one space precedes any of the tokens, the tokens)
    found: dict[tuple[int, str], tuple[bool, list[_Place]]] = {}
    for line in block:
        for index, before, gap in _gaps(line):
            kind = line.tokens[0].type if index > 1 else ""
            column = source.position(line.tokens[index].start_pos)[1], kind
            wide, places = found.get(column, (False, []))
            found[column] = wide or gap > 1, [*places, _Place(line, index, before)]
    yield from (places for _, (wide, places) in sorted(found.items()) if wide and len(places) > 1)


def _gaps(line: Line) -> Iterator[tuple[int, int, int]]:
    """Yields the tokens that may be in an aligned column, as (index, index of the token that gets
    spaces before it, number of spaces in the original). A signed number is aligned by its digits,
    and gets spaces before its sign."""
    for index in range(1, len(line.tokens)):
        gap = line.tokens[index].start_pos - line.tokens[index - 1].end_pos
        if gap and line.pieces[index].startswith(" "):
            signed = line.tokens[index].type in SIGNS and index + 1 < len(line.tokens)
            signed = signed and not line.pieces[index + 1].startswith(" ")
            yield index + signed, index, gap


def _indented(lines: list[Line]) -> None:
    """Sets the indentation of every line; lines within a bracket are indented to its content."""
    opened: list[int] = []
    for line in lines:
        base = INDENT * bool(line.inside)
        if line.first:
            opened = []
        closes = bool(line.tokens) and line.tokens[0].type in CLOSERS
        line.indent = base
        if opened and not line.first:
            hanging = opened[-1] < 0
            line.indent = abs(opened[-1]) - (HANGING if hanging and closes else closes)
        column = line.indent
        for i, (token, piece) in enumerate(zip(line.tokens, line.pieces, strict=True)):
            column += len(piece)
            if token.type in OPENERS:
                ends = i + 1 == len(line.tokens)
                opened.append(-(line.indent + HANGING) if ends else column)
            elif token.type in CLOSERS and opened:
                opened.pop()


def _commented(lines: list[Line]) -> Iterator[list[Line]]:
    """Yields blocks of consecutive lines of code that have comments."""
    block: list[Line] = []
    for line in lines:
        if line.tokens and line.comment:
            block.append(line)
        elif not line.tokens or line.comment:
            yield block
            block = []
    yield block


def _align_comments(block: list[Line]) -> None:
    """Aligns comments in their most common column, or else in the first one's column. Comments of
    lines that are too long for that column are aligned further right."""
    before: list[int] = []
    while before != (before := [line.column for line in block]):  # Repeat until no comment moves.
        waiting = block
        while waiting:
            column = _column(waiting)
            for line in waiting:
                line.column = column if _fits(line, column) else line.column
            waiting = [line for line in waiting if not _fits(line, column)]


def _column(block: list[Line]) -> int:
    """Returns the column in which the comments of a block are aligned."""
    columns = [line.column for line in block]
    column, count = Counter(columns).most_common(1)[0]
    column = column if 2 * count > len(block) else columns[0]
    there = [line for line in block if line.column == column]
    if len(there) > 1 and all(_fits(line, column) for line in there):
        return column
    least = len(there[0].code) + BEFORE_COMMENT
    column = column if _fits(there[0], column) else least
    while True:
        ends = [len(line.code) + BEFORE_COMMENT for line in block if not _fits(line, column)]
        near = [end for end in ends if end <= column + NEAR_COMMENT]
        if not near:
            return column
        column = max(near)


def _fits(line: Line, column: int) -> bool:
    """Whether a comment fits in a column, with at least one space before it."""
    return len(line.code) < column


def _joined(lines: list[Line]) -> str:
    made: list[str] = []
    for line in lines:
        text = line.code or (" " * line.indent if line.comment else "")
        if line.comment:
            text = (text.ljust(line.column) if line.tokens else text) + line.comment
        if text or (made and made[-1]):
            made.append(text)
    while made and not made[-1]:
        made.pop()
    return "\n".join(made) + "\n" if made else ""
