"""Grammars of .lag for TextMate (VS Code), Vim and Emacs, from the words of the language.

    python tools/editors.py            writes them into editors/
    python tools/editors.py --check    says which are not what it would write

They colour by class what the lexer tells apart by what stands before it, as far as a grammar of
regular expressions can: an index touches its name, a unit stands behind a value, words of a drawing
or a body behind what is complete.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from pkgen.editor.words import words

EDITORS = Path(__file__).resolve().parent.parent / "editors"
MADE = "made by tools/editors.py from the words of the language; do not edit"

NAME = r"[^\W\d]\w*"
NUMBER = r"[0-9]+(?:\.[0-9]+)?(?:[eE][+-]?[0-9]+)?"
# Statements that have words of their own, and whose.
DRAWN, BODIES, METHOD = "draw|view", "body|joint", "method"


def alternatives(*kinds: str) -> str:
    return "|".join(sorted({word for kind in kinds for word in words()[kind]}))


# ---- TextMate

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


def textmate() -> str:
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
                    rf"^[ \t]*({BODIES})\b[ \t]*",
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
                captured(rf"^[ \t]*({alternatives('opening')})\b[ \t]*", "statement"),
            ]
        },
        "parts": captured(rf"{behind}({part})\b[ \t]*(?:({part})\b[ \t]*)?", "clause", "clause"),
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
    grammar = {
        "information_for_contributors": [MADE],
        "name": "Lagrangian",
        "scopeName": "source.lag",
        "fileTypes": ["lag"],
        "patterns": [{"include": f"#{name}"} for name in ("comment", "statements", "expression")],
        "repository": repository,
    }
    return json.dumps(grammar, indent=1) + "\n"


# ---- Vim

LINKS = {
    "Comment": "Comment",
    "Statement": "Statement",
    "Clause": "Keyword",
    "Shape": "Type",
    "Function": "Function",
    "Constant": "Constant",
    "Number": "Number",
    "Unit": "Type",
    "Operator": "Operator",
    "Member": "Identifier",
    "File": "String",
}


def vim() -> str:
    def either(*kinds: str) -> str:
        return "%(" + alternatives(*kinds) + ")"

    value = (
        "lagComment,lagFunction,lagClause,lagStatement,lagConstant,lagIndexed,lagName,lagNumber,"
        "lagUnit,lagMember,lagBracket,lagOperator"
    )
    behind = r"%(%(\k|['\])])\s+)@<="
    lines = [
        f'" Syntax of .lag files; {MADE}.',
        "if exists('b:current_syntax') | finish | endif",
        "syn case match",
        r"syn match lagOperator /\v\*\*|\.\.|[-+*\/^=<>:,']/",
        r"syn match lagName /\v[[:alpha:]_]\k*|[^\x00-\x7f]\k*/",
        r"syn match lagNumber /\v[0-9]+%(\.[0-9]+)?%([eE][+-]?[0-9]+)?/",
        rf"syn match lagConstant /\v<{either('constant')}>[\[]@!/",
        rf"syn match lagClause /\v<{either('clause')}>\s*/",
        r"syn match lagClause /\v<in\ze\s*[\[(]/ nextgroup=lagBounds skipwhite",
        r"syn region lagBounds matchgroup=lagOperator start=/[\[(]/ end=/[\])]/ contained"
        rf" contains={value}",
        rf"syn match lagStatement /\v<{either('statement')}>\s*/",
        rf"syn match lagFunction /\v<{either('function')}>\ze\s*\(/",
        rf"syn match lagMember /\v%(\k|\])@1<=\.{either('member')}>/",
        rf"syn region lagBracket start=/(/ end=/)/ contains={value}",
        rf"syn region lagBracket start=/\[/ end=/\]/ contains={value}",
        r"syn match lagUnit /\v%(\k|['\])])@1<=\s*\zs\[[^\[\]#]*\]/",
        r"syn region lagIndexed matchgroup=lagName start=/\v%([[:alpha:]_]|[^\x00-\x7f])\k*\[/"
        rf" matchgroup=NONE end=/\]/ contains={value}",
        rf"syn match lagPart /\v{behind}{either('part')}>\s*/ contained",
        rf"syn match lagShape /\v%(^\s*%({DRAWN})\s+)@<=%({alternatives('shape')})>\s*/ contained",
        rf"syn match lagFile /\v%(<{either('method')}\s+)@<=[^ \t#]+/ contained",
        rf"syn match lagTableau /\v%({METHOD}\s+\k+\s+)@<={either('method')}>\s*/ contained",
        rf"syn match lagStatement /\v^\s*\zs{either('opening')}>\s*/",
        rf"syn region lagDrawing start=/\v^\s*\zs%({DRAWN})>/ end=/$/"
        rf" contains={value},lagShape,lagPart",
        rf"syn region lagBody start=/\v^\s*\zs%({BODIES})>/ end=/$/ contains={value},lagPart",
        rf"syn region lagMethod start=/\v^\s*\zs{METHOD}>/ end=/$/"
        rf" contains={value},lagTableau,lagFile",
        "syn match lagComment /#.*$/",
        "syn sync minlines=50",
        *(f"hi def link lag{kind} {group}" for kind, group in LINKS.items()),
        *("hi def link lagPart lagClause", "hi def link lagTableau lagClause"),
        "let b:current_syntax = 'lag'",
    ]
    return "\n".join(lines) + "\n"


# ---- Emacs

FACES = {
    "statement": "font-lock-keyword-face",
    "clause": "font-lock-builtin-face",
    "shape": "font-lock-type-face",
    "function": "font-lock-function-name-face",
    "constant": "font-lock-constant-face",
    "unit": "font-lock-type-face",
    "file": "font-lock-string-face",
}


def emacs() -> str:
    def listed(*kinds: str) -> str:
        return " ".join(f'"{word}"' for word in alternatives(*kinds).split("|"))

    text = r"""
;;; lag-mode.el --- Lagrangians for pkgen  -*- lexical-binding: t -*-
;; MADE.

;; Package-Requires: ((emacs "26.1"))
;; SPDX-License-Identifier: MIT

;;; Commentary:
;; Colours of .lag files; with eglot, all that `pkgen lsp' tells.

;;; Code:

(defun lag--words (&rest words)
  "A pattern of WORDS, the first group being the word."
  (concat "\\_<\\(" (regexp-opt words) "\\)\\_>"))

(defun lag--value-end (start)
  "Whether something complete ends before the blanks before START."
  (save-excursion
    (goto-char start)
    (skip-chars-backward " \t")
    (and (not (bolp)) (looking-back "[])'[:alnum:]_]" (1- (point))))))

(defun lag--part (limit)
  "Find a word of a drawing, a body or a joint before LIMIT."
  (let (found)
    (while (and (not found) (re-search-forward (lag--words PART) limit t))
      (setq found (save-match-data
                    (and (zerop (car (save-excursion (syntax-ppss))))
                         (lag--value-end (match-beginning 0))))))
    found))

(defun lag--unit (limit)
  "Find a unit before LIMIT: behind a value, not touching its name."
  (let (found)
    (while (and (not found) (re-search-forward "\\[[^][\n#]*\\]" limit t))
      (let ((start (match-beginning 0)))
        (save-match-data
          (save-excursion
            (goto-char start)
            (let ((blank (< (skip-chars-backward " \t") 0)))
              (setq found
                    (and (lag--value-end start)
                         (not (memq (get-text-property (1- (point)) 'face)
                                    '(NOT)))
                         (or blank
                             (memq (char-before) '(?\) ?\] ?'))
                             (looking-back "\\_<[0-9][0-9.]*\\(?:[eE][-+]?[0-9]+\\)?"
                                           (line-beginning-position))))))))
        (unless found (goto-char (1+ start)))))
    found))

(defun lag--end ()
  "The end of the statement that begins before point: a line goes on in a bracket."
  (save-excursion
    (end-of-line)
    (while (and (> (car (syntax-ppss)) 0) (not (eobp)))
      (forward-line 1)
      (end-of-line))
    (point)))

(defconst lag-font-lock-keywords
  `(("\\_<method[ \t]+\\sw+[ \t]+\\(tableau\\)[ \t]+\\([^ \t\n#]+\\)"
     (1 CLAUSE) (2 FILE))
    (,(concat "^[ \t]*" (lag--words "draw" "view") "\\(?:[ \t]+" (lag--words SHAPES) "\\)?")
     (1 STATEMENT) (2 SHAPE nil t)
     (lag--part (lag--end) nil (1 CLAUSE)))
    (,(concat "^[ \t]*" (lag--words "body" "joint"))
     (1 STATEMENT)
     (lag--part (lag--end) nil (1 CLAUSE)))
    (,(concat "^[ \t]*" (lag--words OPENINGS)) (1 STATEMENT))
    (,(concat (lag--words FUNCTIONS) "[ \t]*(") (1 FUNCTION))
    (,(lag--words STATEMENTS) (1 STATEMENT))
    (,(lag--words CLAUSES) (1 CLAUSE))
    (,(lag--words CONSTANTS) (1 CONSTANT))
    (lag--unit (0 UNIT)))
  "What is coloured in a .lag file.")

(defvar lag-mode-syntax-table
  (let ((table (make-syntax-table)))
    (modify-syntax-entry ?# "<" table)
    (modify-syntax-entry ?\n ">" table)
    (modify-syntax-entry ?_ "_" table)
    (dolist (sign '(?' ?\" ?. ?+ ?- ?* ?/ ?^ ?= ?< ?> ?& ?| ?%))
      (modify-syntax-entry sign "." table))
    table)
  "The syntax of .lag files.")

;;;###autoload
(define-derived-mode lag-mode prog-mode "Lag"
  "A mode for Lagrangians of pkgen."
  (setq-local comment-start "# ")
  (setq-local comment-end "")
  (setq-local font-lock-multiline t)
  (setq-local font-lock-defaults '(lag-font-lock-keywords)))

;;;###autoload
(add-to-list 'auto-mode-alist '("\\.lag\\'" . lag-mode))

(defvar eglot-server-programs)
(with-eval-after-load 'eglot
  (add-to-list 'eglot-server-programs '(lag-mode . ("pkgen" "lsp"))))

(provide 'lag-mode)
;;; lag-mode.el ends here
"""
    kinds = {"SHAPES": "shape", "OPENINGS": "opening", "FUNCTIONS": "function", "PART": "part"}
    kinds |= {"STATEMENTS": "statement", "CLAUSES": "clause", "CONSTANTS": "constant"}
    for mark, kind in kinds.items():
        text = text.replace(f"lag--words {mark})", f"lag--words {listed(kind)})")
    for kind, face in FACES.items():
        text = text.replace(f" {kind.upper()}", f" '{face}")
    faces = {FACES[kind] for kind in ("statement", "clause", "shape")}
    text = text.replace("(NOT)", f"({' '.join(sorted(faces))})")
    return text.replace("MADE", f"{MADE[0].upper()}{MADE[1:]}").lstrip()


FILES = {
    "vscode/syntaxes/lag.tmLanguage.json": textmate,
    "vim/syntax/lag.vim": vim,
    "emacs/lag-mode.el": emacs,
}


def main(words: list[str]) -> int:
    stale = []
    for name, make in FILES.items():
        path, text = EDITORS / name, make()
        if path.exists() and path.read_text(encoding="utf-8") == text:
            continue
        stale.append(name)
        if "--check" not in words:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
    print("\n".join(stale), end="\n" if stale else "")
    return int("--check" in words and bool(stale))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
