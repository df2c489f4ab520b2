"""A run whose method was measured goes on by that method, whatever would be measured now."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from checkpoint_runs import BLOCKS

from conftest import case
from pkgen.analysis import choose
from pkgen.api.chosen import data, settled
from pkgen.cli import checkpoints
from pkgen.cli.commands import parsed
from pkgen.run.settings import Settings
from pkgen.system.exits import UsageError

MODEL = case("rocks")
LONGER = BLOCKS.replace("until 2", "until 300").replace("every 0.1", "every 1")
LONGER = LONGER.replace("accuracy 1e-6", "accuracy 1")


def done(*words: str) -> int:
    command, options = parsed(list(words))
    return command.module.run(options)


@pytest.mark.parametrize("text", [MODEL, LONGER], ids=["whole", "parts"])
def test_nothing_is_chosen_again(text: str, tmp_path: Path, monkeypatch) -> None:
    (tmp_path / "m.lag").write_text(text)
    ck = tmp_path / "c"
    words = ["run", "m.lag", "--scene", "s", "-o"]
    of_run = checkpoints.settings
    monkeypatch.chdir(tmp_path)
    with monkeypatch.context() as patch:
        patch.setattr(checkpoints, "settings", lambda *x: of_run(*x) | {"checkpoint_after": 30})
        assert done(*words, "b.csv", "--checkpoint", "c") == 75
    note = checkpoints.note(ck)

    def never(*_: object) -> None:
        raise AssertionError("it was chosen when the run was begun")

    monkeypatch.setattr(choose, "chosen", never)
    assert done("resume", str(ck)) == 0
    with monkeypatch.context() as patch:
        patch.setattr(checkpoints, "chosen", lambda _: note["chosen"])
        assert done(*words, "a.csv") == 0
    a, b = ((tmp_path / f"{x}.csv").read_bytes() for x in "ab")
    assert a == b and a.count(b"\n") == 302
    told = json.loads((tmp_path / "b.csv.json").read_text())
    parts = told["accuracy"].get("parts", [told["accuracy"]])
    assert parts == note["chosen"]["said"] and len(parts) == (1 if text == MODEL else 2)


def test_a_choice_that_is_none_is_refused() -> None:
    """What a file says that somebody has forged."""
    good = Settings("rk4", 1.0, None, 0.1, 1e-9, None, "newton", 0, None, (), (), (), (), ())
    assert settled(good, json.loads(json.dumps(data(good)))) == good
    for key in data(good):
        for wrong in (True, {}, [1], [{"method": 1}]):
            with pytest.raises(UsageError, match="is none"):
                settled(good, {**data(good), key: wrong})
    for none in (None, 3, [], {}):
        with pytest.raises(UsageError, match="is none"):
            settled(good, none)
