"""Grammars of .lag for TextMate (VS Code), Vim and Emacs, from the words of the language.

    python tools/editors            writes them into editors/
    python tools/editors --check    says which are not what it would write

They colour by class what the lexer tells apart by what stands before it, as far as a grammar of
regular expressions can: an index touches its name, a unit stands behind a value, words of a drawing
or a body behind what is complete. Those of Vim and Emacs are the templates beside this file.
"""

from __future__ import annotations

import sys
from pathlib import Path

import jinja2
from textmate import grammar

from pkgen_editor.words import words

HERE = Path(__file__).resolve().parent
EDITORS = HERE.parent.parent / "editors"
MADE = "Made by tools/editors from the words of the language; do not edit."
TEMPLATES = ("vim/syntax/lag.vim", "emacs/lag-mode.el")


def made() -> dict[str, str]:
    """By the path in editors/."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(HERE),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,
    )
    given = {"made": MADE, "words": words().__getitem__}
    files = {name: environment.get_template(Path(name).name).render(given) for name in TEMPLATES}
    return files | {"vscode/syntaxes/lag.tmLanguage.json": grammar(MADE)}


def main(options: list[str]) -> int:
    stale = []
    for name, text in made().items():
        path = EDITORS / name
        if path.exists() and path.read_text(encoding="utf-8") == text:
            continue
        stale.append(name)
        if "--check" not in options:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
    print("\n".join(stale), end="\n" if stale else "")
    return int("--check" in options and bool(stale))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
