"""Checks integration methods that a model adds: `method NAME tableau FILE`."""

from __future__ import annotations

from pathlib import Path

from ...methods import METHODS
from ...own.made import of_text
from ...source import ModelError
from .. import statements as st
from ..read import ALLOW, UnreadableModel, inside, read_text, refusal, unquoted
from ..words import reserved
from .shared import Checks

LONGEST = 40
_FORM = "e.g. method mine tableau mine.tab"


class Methods(Checks):
    def declare(self, statement: st.Method) -> None:
        """Checks a `method` statement outside of scenes: it adds a method, but selects none."""
        for value, word in ((statement.step, "step"), (statement.rtol, "rtol")):
            if value is not None:
                message = f"'{word}' is of a scene that the method is used in"
                self.error(message, value, f"in it: method {statement.name} {word} …")
        if statement.file is None:
            message = f"'method {statement.name}' outside of a scene does not say what it is"
            self.error(message, statement, _FORM)
        else:
            self.bring(statement)

    def bring(self, statement: st.Method) -> None:
        """Reads the tableau file and adds the method. Raises ModelError, which points into that
        file."""
        name, help = statement.name, _FORM
        why = reserved(name)
        if name in METHODS:
            why, help = "is one of pkgen's methods", "give it another name"
        elif not name.isascii() or len(name) > LONGEST:
            why, help = f"is not a plain name of {LONGEST} letters at most", "shorten it"
        if why:
            self.error(f"'{name}' {why}", statement.name_span, help)
            return
        folder = Path(self.source.piece(statement.span.start).path).parent
        path = folder / statement.file
        if wrong := refusal(statement.file, path, folder):
            self.error(wrong, statement.file_span, ALLOW)
            return
        try:
            own = of_text(name, read_text(path, "a tableau file"))
        except UnreadableModel as wrong:
            (found,) = wrong.diagnostics
            self.error(f"{path}: {found.message}", statement.file_span, found.help)
            return
        except ModelError as wrong:
            if inside(path, folder):
                raise
            message, help = unquoted(path, wrong)
            self.error(message, statement.file_span, help)
            return
        same = [other for other in self.parts["methods"] if other.name == name]
        if not same:
            self.parts["methods"].append(own)
        elif same != [own]:
            message = f"there is another method '{name}' already"
            self.error(message, statement.name_span, "give one of them another name")
