"""What the lexer says of each place of a text, and what the grammars say: a class a character."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

from conftest import ROOT
from pkgen.front.lexer import statements
from pkgen.front.table import STATEMENTS
from pkgen.front.words import BEHIND, CLAUSE_WORDS, CONSTANTS
from pkgen.source import Source
from pkgen_editor.words import words

TYPES = {
    **{word.upper(): "statement" for word in STATEMENTS},
    **{word.upper(): "clause" for word in CLAUSE_WORDS},
    **{"WORD": "clause", "TABLEAU": "clause", "SHAPE": "shape", "NUMBER": "number"},
    **{"UNIT": "unit", "FILE": "file", "SUM": "function"},
    **{"STRING": "file", "AS": "clause", "WITH": "clause"},
}
SIGNS = ("LPAREN", "RPAREN", "LINDEX", "LVECTOR", "LEND", "RBRACKET", "REND")


def by_lexer(text: str) -> list[str]:
    """Of each character; "" of what no grammar is asked about: spaces, brackets, signs, names."""
    found = [""] * len(text)
    for statement in statements(Source("m.lag", text)):
        for i, token in enumerate(statement.tokens):
            behind = i > 0 and token in BEHIND.get(statement.tokens[0].type, ())
            kind = "clause" if behind and token.type != "NAME" else TYPES.get(token.type, "")
            spelt = text[token.start_pos : token.end_pos]
            if token.type == "FUNCTION" and str(token) in words()["function"]:
                kind = "function"
            elif token.type in ("NAME", "FUNCTION"):
                kind = "constant" if str(token) in CONSTANTS else "name"
            found[token.start_pos : token.end_pos] = [kind] * len(spelt)
    for comment in re.finditer("#.*", text):
        found[comment.start() : comment.end()] = ["comment"] * len(comment.group())
    return found


def differences(
    text: str, coloured: list[str], less: Mapping[str, str] = MappingProxyType({})
) -> list[str]:
    """Where a grammar sees another class than the lexer; names may have none. `less` is what it
    sees a class as that it does not tell apart."""
    wanted = [less.get(kind, kind) for kind in by_lexer(text)]
    found = []
    for at, (right, seen) in enumerate(zip(wanted, coloured, strict=True)):
        seen = {"operator": "", "member": ""}.get(seen, seen)
        right = "" if right == "name" else right
        seen = "" if seen == "name" else seen
        if right != seen and not text[at].isspace():
            line = text.count("\n", 0, at) + 1
            column = at - text.rfind("\n", 0, at)
            end = text.find("\n", at)
            found.append(f"{line}:{column}: {right or '-'}, not {seen or '-'}: {text[at:end][:40]}")
    return found


class TextMate:
    """A grammar as its engine reads it, a line at a time: the first match of all that may stand
    here, and of an end before what is inside."""

    def __init__(self, grammar: dict) -> None:
        self.repository = grammar["repository"]
        self.root = self.flat(grammar["patterns"])

    def flat(self, patterns: list) -> list:
        found = []
        for pattern in patterns:
            if "include" in pattern:
                pattern = self.repository[pattern["include"][1:]]
            only = "patterns" in pattern and "begin" not in pattern
            found += self.flat(pattern["patterns"]) if only else [pattern]
        return found

    def colour(self, text: str) -> list[str]:
        found = [""] * len(text)
        stack: list[tuple[str | None, list]] = [(None, self.root)]
        start = 0
        for line in text.splitlines(keepends=True):
            at, body = 0, line.rstrip("\n")
            while True:
                end, inside = stack[-1]
                best = None
                for rule in ([{"end": end}] if end else []) + inside:
                    pattern = rule.get("end") or rule.get("begin") or rule["match"]
                    if "end" in rule and "begin" in rule:
                        pattern = rule["begin"]
                    match = re.compile(pattern).search(body, at)
                    if match and (best is None or match.start() < best[1].start()):
                        best = rule, match
                if best is None:
                    break
                rule, match = best
                self.paint(found, rule, match, start)
                closes = "end" in rule and "begin" not in rule
                if closes:
                    stack.pop()
                elif "begin" in rule:
                    stack.append((rule["end"], self.flat(rule["patterns"])))
                elif match.end() == at and match.start() == at:
                    at += 1  # an empty match
                    continue
                at = match.end()
                if closes and at >= len(body) and match.group() == "":
                    break
            start += len(line)
        return found

    @staticmethod
    def paint(found: list[str], rule: dict, match: re.Match, start: int) -> None:
        captures = rule.get("captures") or rule.get("beginCaptures") or {}
        spans = [(match.span(int(k)), v["name"]) for k, v in captures.items()]
        if "name" in rule:
            spans.append((match.span(), rule["name"]))
        for (a, b), scope in spans:
            if a >= 0:
                found[start + a : start + b] = [KINDS[scope]] * (b - a)


def grammar() -> dict:
    return json.loads((ROOT / "editors/vscode/syntaxes/lag.tmLanguage.json").read_text())


KINDS = {
    "comment.line.number-sign.lag": "comment",
    "keyword.control.lag": "statement",
    "keyword.other.lag": "clause",
    "support.type.lag": "shape",
    "support.function.lag": "function",
    "constant.language.lag": "constant",
    "constant.numeric.lag": "number",
    "storage.type.unit.lag": "unit",
    "keyword.operator.lag": "operator",
    "variable.other.member.lag": "member",
    "variable.other.lag": "name",
    "string.unquoted.lag": "file",
}
FACES = {
    "font-lock-keyword-face": "statement",
    "font-lock-builtin-face": "clause",
    "font-lock-type-face": "unit",
    "font-lock-function-name-face": "function",
    "font-lock-constant-face": "constant",
    "font-lock-string-face": "file",
    "font-lock-comment-face": "comment",
    "font-lock-comment-delimiter-face": "comment",
}
GROUPS = {"Tableau": "clause", "Part": "clause", "Joining": "clause"}
GROUPS |= {"Indexed": "", "Bracket": "", "Bounds": "", "Named": ""}
GROUPS |= {"Drawing": "", "Body": "", "Method": ""}


def by_vim(texts: list[str], folder: Path) -> list[list[str]] | None:
    """As Vim colours the texts; None without one that has colours."""
    vim = shutil.which("vim")
    said = vim and subprocess.run([vim, "--version"], capture_output=True, text=True).stdout
    if not said or "+syntax" not in said or "+eval" not in said:
        return None
    script = [f"set rtp^={ROOT / 'editors/vim'}", "filetype on", "syntax on"]
    for i, text in enumerate(texts):
        (folder / f"{i}.lag").write_text(text, encoding="utf-8")
        script += [
            f"edit {folder}/{i}.lag",
            "let found = []",
            "for l in range(1, line('$'))",
            "  for c in range(1, col([l, '$']) - 1)",
            "    call add(found, synIDattr(synID(l, c, 0), 'name'))",
            "  endfor",
            "  call add(found, '')",
            "endfor",
            f"call writefile(found, '{folder}/{i}.out')",
        ]
    (folder / "colour.vim").write_text("\n".join([*script, "qa!", ""]))
    command = [vim, "-N", "-u", "NONE", "-i", "NONE", "-n", "-es", "-S", folder / "colour.vim"]
    subprocess.run(command, capture_output=True, timeout=300, env={"LANG": "C.UTF-8", "HOME": "/"})
    found = []
    for i, text in enumerate(texts):
        names = (folder / f"{i}.out").read_text().split("\n")[:-1]
        by_byte = [GROUPS.get(n.removeprefix("lag"), n.removeprefix("lag").lower()) for n in names]
        kinds, at = [], 0
        for character in text:
            kinds.append(by_byte[at] if at < len(by_byte) else "")
            at += len(character.encode())
        found.append(kinds)
    return found


EMACS = """
(add-to-list 'load-path "{folder}")
(require 'lag-mode)
(dolist (file '({files}))
  (find-file file)
  (font-lock-ensure)
  (let ((found (mapcar (lambda (at) (format "%s" (get-text-property at 'face)))
                       (number-sequence (point-min) (1- (point-max))))))
    (with-temp-file (concat file ".out") (insert (mapconcat #'identity found "\n")))))
"""


def by_emacs(texts: list[str], folder: Path) -> list[list[str]] | None:
    """As Emacs colours the texts, shapes as units and no numbers; None without it."""
    emacs = shutil.which("emacs")
    if emacs is None:
        return None
    paths = [folder / f"{i}.lag" for i in range(len(texts))]
    for path, text in zip(paths, texts, strict=True):
        path.write_text(text, encoding="utf-8")
    files = " ".join(f'"{path}"' for path in paths)
    script = EMACS.format(folder=ROOT / "editors/emacs", files=files)
    (folder / "colour.el").write_text(script)
    command = [emacs, "--batch", "-Q", "-l", folder / "colour.el"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    outs = (path.with_name(path.name + ".out").read_text().split("\n") for path in paths)
    return [[FACES.get(face, "") for face in out] for out in outs]
