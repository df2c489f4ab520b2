"""`show` compiles each model of the collection far below its limit of time.

Work is counted in calls of functions, which no load of the machine changes. Python makes three
to four million of these calls a second here, so a machine ten times slower makes 300,000.
"""

from __future__ import annotations

import cProfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from conftest import ROOT, SHOWN, long_but
from pkgen import limits
from pkgen.__main__ import main
from pkgen.back.wasm.build import missing
from pkgen.cli import compilation

CALLS_A_SECOND = 300_000
MODELS = SHOWN
QUICK = [ROOT / "models/double_pendulum.lag"]


@pytest.mark.skipif(bool(missing()), reason=f"not here: {', '.join(missing())}")
@pytest.mark.parametrize("model", long_but(QUICK, MODELS), ids=lambda path: path.stem)
def test_a_slow_machine_shows_the_collection(
    model: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    counts = []

    @contextmanager
    def counted(seconds: float, memory: int) -> Iterator[None]:
        assert seconds == limits.CPU_SECONDS
        with cProfile.Profile() as profile:
            yield
        counts.append(sum(entry.callcount for entry in profile.getstats()))

    monkeypatch.setattr(compilation, "bounded", counted)
    monkeypatch.setattr("pkgen_web.show.wasm", lambda *_: b"")  # clang is under no such limit
    assert main(["show", str(model), "-o", str(tmp_path / "page.html")]) == 0
    assert counts and max(counts) < limits.CPU_SECONDS * CALLS_A_SECOND
