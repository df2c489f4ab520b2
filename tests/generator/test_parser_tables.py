"""The parser's tables are kept in the cache; a broken file there costs time, and nothing else."""

from pathlib import Path

import pytest

from pkgen.front import parse
from pkgen.source import Source

MODEL = Source("m.lag", "model m\ncoord x\nkinetic x'^2/2\npotential cos(x)\n")


@pytest.fixture
def kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Parses with a cache of its own; returns the file of tables."""
    monkeypatch.setenv("PKGEN_CACHE", str(tmp_path / "cache"))

    def read() -> Path:
        parse.parser.cache_clear()
        parse.parse_all.cache_clear()
        found = parse.parse(MODEL)
        assert len(found.statements) == 4
        (folder,) = (tmp_path / "cache/parser").iterdir()
        return folder / "tables"

    yield read
    parse.parser.cache_clear()


def test_tables_are_made_once(kept) -> None:
    file = kept()
    made = file.stat().st_mtime_ns
    assert file.stat().st_size > 10_000
    assert kept() == file and file.stat().st_mtime_ns == made


@pytest.mark.parametrize("keep", [0, 4, 100, 30_000])
def test_a_broken_file_is_made_again(kept, keep: int) -> None:
    file = kept()
    whole = file.read_bytes()
    file.write_bytes(whole[:keep] if keep != 4 else b"junk")
    assert kept() == file and file.stat().st_size > 0.9 * len(whole)


def test_a_cache_that_cannot_be_written_is_done_without(monkeypatch, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("PKGEN_CACHE", str(tmp_path / "file" / "cache"))
    parse.parser.cache_clear()
    parse.parse_all.cache_clear()
    assert len(parse.parse(MODEL).statements) == 4
    parse.parser.cache_clear()
