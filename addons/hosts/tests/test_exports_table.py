"""The table of exports in docs: what is there is kept when more is measured."""

from __future__ import annotations

import pytest

from bench import exports, machine
from conftest import HOSTED


@pytest.fixture
def page(tmp_path, monkeypatch):
    copy = tmp_path / "exports.md"
    copy.write_text(exports.PAGE.read_text())
    monkeypatch.setattr(exports, "PAGE", copy)
    return copy


def test_it_has_every_model_and_is_written_as_it_is_read(page) -> None:
    before = page.read_text()
    found = exports._read()
    assert set(found) == {path.stem for path in HOSTED}
    assert all(set(row) == set(exports.HOSTS) for row in found.values())
    exports._write(found)
    assert page.read_text() == before


def test_one_that_is_measured_anew_leaves_the_others(page, monkeypatch) -> None:
    one = {"kB": 7, "s": 0.25, "off": 3e-14}
    found = exports._read()
    assert found["free_body"]["single"] == {"refused": "rotations"}
    found["pendulum"]["js"] = one
    here = machine.describe()
    monkeypatch.setattr(type(here), "lines", lambda _: ["A machine of its own"])
    before = page.read_text()
    exports._write(found)
    again = exports._read()
    assert again["pendulum"]["js"] == one | {"s": 0.2}
    assert again | {"pendulum": found["pendulum"]} == found
    new = [line for line in page.read_text().splitlines() if line not in before.splitlines()]
    assert new[0] == "A machine of its own" and before.splitlines()[40] in page.read_text()
