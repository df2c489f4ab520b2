"""Ends of families in scenes: what lies there is recorded, and members are held from there on."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from conftest import case, ran, written

CHAIN = case("ends_chain")


def chain(folder: Path, clauses: str) -> Path:
    path = written(folder, CHAIN.format(clauses))
    return path


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
