"""Ends of families in scenes: what lies there is recorded, and members are held from there on."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from conftest import ran

CHAIN = """model chain
size N = 6
param k[i = 1..N] = 10*i
coord q[1..N]
fixed q[0] = 0.1*sin(t)
free q[N+1]
kinetic   sum(q[i]'^2, i = 1..N)/2
potential sum((q[i+1] - q[i])^2, i = 0..N)/2
start q[i = 1..N] = k[i] + sum(j, j = 1..i)
scene one
  until 1
  {}
end
"""
# What is wrong, the text that the caret is below, and the hint.
WRONG = [
    ("record q", "'q' is a family: it needs an index", "q", "one by one, e.g. q[1]"),
    ("record q[1], p_q[0]", "p_q[0] is outside the family", "p_q[0]", ""),
    (
        "hold q[N]\n  record p_q[2], p_q[N]",
        "'p_q[6]': q[6] is held here, and has no momentum",
        "p_q[N]",
        "'q[6]' and its rate can be recorded",
    ),
    ("hold q[3]", "it is neither the first nor the last", "q[3]", "in order: q[1] or q[6] first"),
]


def chain(folder: Path, clauses: str) -> Path:
    path = folder / "chain.lag"
    path.write_text(CHAIN.format(clauses))
    return path


@pytest.mark.parametrize(("clauses", "said", "under", "hint"), WRONG)
def test_what_cannot_be(pkgen, tmp_path: Path, clauses, said, under, hint) -> None:
    done = pkgen("check", chain(tmp_path, clauses))
    assert done.returncode == 1 and said in done.stderr and hint in done.stderr
    _, shown, caret, *_ = done.stderr.splitlines()
    assert shown[caret.index("^") : caret.rindex("^") + 1] == under


def test_ends_and_held_members_are_recorded(tmp_path: Path) -> None:
    """Held are q[1] and q[2] where they start, and q[N] by a motion: then q[N+1] moves with it. As
    outputs members of one family stand apart from each other."""
    columns = "q[0], q[0]', q[1], q[2], q[N]', q[N+1], p_q[3]"
    clauses = f"hold q[1], q[2], q[N] = 3*t\n  method rk4 step 0.125\n  record {columns} every 0.5"
    done = ran("run", chain(tmp_path, clauses), "--scene", "one")
    head, *rows = done.stdout.splitlines()
    assert head == "t,q[0],q[0]',q[1],q[2],q[6]',q[7],p_q[3]"
    for row in rows:
        t, *ends, p = map(float, row.split(","))
        driven = [0.1 * math.sin(t), 0.1 * math.cos(t)]
        assert ends == pytest.approx([*driven, 11, 23, 3, 3 * t], abs=1e-15)
        assert (p != 0) == (t > 0)
