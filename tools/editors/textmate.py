"""The grammar for TextMate, which VS Code reads: data that JSON holds."""

from __future__ import annotations

import json

from pkgen_editor.words import words

NAME = r"[^\W\d]\w*"
NUMBER = r"[0-9]+(?:\.[0-9]+)?(?:[eE][+-]?[0-9]+)?"
# Statements that have words of their own.
DRAWN, METHOD = "draw|view", "method"
SCOPES = {
    "comment": "comment.line.number-sign",
    "statement": "keyword.control",
    "clause": "keyword.other",
    "shape": "support.type",
    "function": "support.function",
    "constant": "constant.language",
    "number": "constant.numeric",
    "unit": "storage.type.unit",
    "operator": "keyword.operator",
    "member": "variable.other.member",
    "name": "variable.other",
    "file": "string.unquoted",
}


def alternatives(kind: str) -> str:
    return "|".join(words()[kind])


def scope(kind: str) -> str:
    return f"{SCOPES[kind]}.lag"


def match(kind: str, pattern: str) -> dict:
    return {"name": scope(kind), "match": pattern}


def captured(pattern: str, *kinds: str) -> dict:
    captures = {str(i + 1): {"name": scope(kind)} for i, kind in enumerate(kinds) if kind}
    return {"match": pattern, "captures": captures}


def region(begin: str, end: str, *inside: str, kinds: tuple[str, ...] = ()) -> dict:
    made = {"begin": begin, "end": end, "patterns": [{"include": f"#{name}"} for name in inside]}
    if kinds:
        made["beginCaptures"] = captured("", *kinds)["captures"]
    return made


def grammar(made: str) -> str:
    part = alternatives("part")
    behind = r"(?<=[\w'\)\]])[ \t]+"
    value = ("comment", "expression")
    repository = {
        "comment": match("comment", r"#.*$"),
        "statements": {
            "patterns": [
                region(
                    rf"^[ \t]*({DRAWN})\b[ \t]*(?:\b({alternatives('shape')})\b[ \t]*"
                    rf"(?:({alternatives('part')})\b[ \t]*)?)?",
                    "$",
                    *("comment", "parts", "expression"),
                    kinds=("statement", "shape", "clause"),
                ),
                region(
                    rf"^[ \t]*({alternatives('parted')})\b[ \t]+(?={NAME})",
                    "$",
                    *("comment", "parts", "expression"),
                    kinds=("statement",),
                ),
                region(
                    rf"^[ \t]*({METHOD})\b[ \t]*(?:({NAME})(?:[ \t]+({alternatives('method')})\b"
                    r"[ \t]*([^\s#]*))?)?",
                    "$",
                    *("comment", "clauses", "expression"),
                    kinds=("statement", "name", "clause", "file"),
                ),
                region(
                    rf'^[ \t]*({alternatives("named")})\b[ \t]+(?={NAME}|")',
                    "$",
                    *("comment", "strings", "joints", "expression"),
                    kinds=("statement",),
                ),
                captured(rf"^[ \t]*({alternatives('opening')})\b[ \t]*", "statement"),
            ]
        },
        "parts": captured(
            rf"(?:{behind}|\b(falling|rising)[ \t]+)({part})\b[ \t]*(?:({part})\b[ \t]*)?",
            *("clause", "clause", "clause"),
        ),
        "strings": match("file", r'"[^"]*"'),
        "joints": captured(rf"(?<=[\w\"])[ \t]+({alternatives('joining')})\b[ \t]*", "clause"),
        "clauses": {
            "patterns": [
                region(r"\b(in)[ \t]*([\[(])", r"[\])]", *value, kinds=("clause", "operator")),
                captured(rf"\b({alternatives('clause')})\b[ \t]*", "clause"),
            ]
        },
        "expression": {
            "patterns": [
                captured(rf"\b({alternatives('function')})(?=[ \t]*\()", "function"),
                captured(rf"\b({alternatives('statement')})\b[ \t]*", "statement"),
                {"include": "#clauses"},
                match("constant", rf"\b(?:{alternatives('constant')})\b(?![\[\w])"),
                region(rf"({NAME})(\[)", r"\]", *value, kinds=("name", "operator")),
                match("name", NAME),
                match("number", NUMBER),
                captured(r"(?<=[\w'\)\]])[ \t]*(\[[^\[\]\n#]*\])", "unit"),
                captured(rf"(?<=[\w\]])\.({alternatives('member')})\b", "member"),
                region(r"\(", r"\)", *value, kinds=()),
                region(r"\[", r"\]", *value, kinds=()),
                match("operator", r"\*\*|\.\.|[-+*/^=<>:,']"),
            ]
        },
    }
    whole = {
        "information_for_contributors": [made],
        "name": "Lagrangian",
        "scopeName": "source.lag",
        "fileTypes": ["lag"],
        "patterns": [{"include": f"#{name}"} for name in ("comment", "statements", "expression")],
        "repository": repository,
    }
    return json.dumps(whole, indent=1) + "\n"
