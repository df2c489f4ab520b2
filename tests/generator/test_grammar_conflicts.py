"""Lark resolves a conflict silently as a shift; its log tells, so this test reads the log."""

import logging

import pytest
from lark import Lark
from lark.exceptions import GrammarError

from pkgen.front.parse import GRAMMAR, _Tokens
from pkgen.front.table import grammar

RULES = GRAMMAR.read_text(encoding="utf-8") + grammar()


def conflicts(grammar: str) -> list[str]:
    """What lark says about conflicts while it builds a grammar."""
    heard: list[str] = []

    class Listener(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            heard.append(record.getMessage())

    logger = logging.getLogger("lark")
    if not logger.handlers:
        from lark.utils import logger as own

        logger = own
    listener, before = Listener(logging.DEBUG), logger.level
    logger.addHandler(listener)
    logger.setLevel(logging.DEBUG)
    try:
        Lark(grammar, parser="lalr", lexer=_Tokens, debug=True)
    except GrammarError as error:  # lark raises for two reductions
        assert "Reduce/Reduce" in str(error)
        heard.append(str(error))
    finally:
        logger.removeHandler(listener)
        logger.setLevel(before)
    return [m for m in heard if "Shift/Reduce" in m or "Reduce/Reduce" in m]


def test_the_grammar_has_no_conflict():
    assert conflicts(RULES) == []


@pytest.mark.parametrize(
    ("rules", "kind"),
    [
        ("start: e\ne: e A e | B\n%declare A B", "Shift/Reduce"),
        ("start: x | y\nx: A\ny: A\n%declare A", "Reduce/Reduce"),
    ],
)
def test_a_conflict_would_be_noticed(rules: str, kind: str):
    assert any(kind in message for message in conflicts(rules))


def test_a_conflict_in_this_grammar_would_be_noticed():
    worse = RULES.replace("?signed: power", "?signed: power | signed PLUS signed")
    assert worse != RULES
    assert conflicts(worse)
