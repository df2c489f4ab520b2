"""The cache is run as code: what is not as it was made, or could be another's, is made again."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from pkgen.system import cache, files
from pkgen.system.exits import BuildError


@pytest.fixture
def kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("PKGEN_CACHE", str(tmp_path / "cache"))
    made = []

    def make(new: Path) -> None:
        made.append(new)
        (new / "program").write_text("#!/bin/sh\necho mine\n")
        (new / "program").chmod(0o755)

    def get() -> tuple[Path, int]:
        return cache.cached("programs", "m-1", make), len(made)

    return get


def chown(path: Path) -> None:
    if os.geteuid() != 0:
        pytest.skip("only root gives files away")
    os.chown(path, 65534, 65534)


def swap(entry: Path) -> None:
    """Another entry, sound in itself, under this name."""
    (entry / cache.DIGESTS).write_text(
        (entry / cache.DIGESTS).read_text().replace(entry.name, "m-2", 1)
    )


WRONG = {
    "truncated": lambda e: (e / "program").write_bytes((e / "program").read_bytes()[:10]),
    "empty": lambda e: (e / "program").write_bytes(b""),
    "of others": lambda e: chown(e / "program"),
    "all of others": lambda e: [chown(p) for p in (*e.iterdir(), e)],
    "others may write it": lambda e: (e / "program").chmod(0o777),
    "others may write beside it": lambda e: e.chmod(0o777),
    "a digest that others may write": lambda e: (e / cache.DIGESTS).chmod(0o666),
    "no digests": lambda e: (e / cache.DIGESTS).unlink(),
    "no program": lambda e: (e / "program").unlink(),
    "a link": lambda e: [(e / "program").rename(e / "p"), (e / "program").symlink_to("p")],
    "another's name": swap,
    "a link for all": lambda e: [e.rename(e.parent / "x"), e.symlink_to("x")],
}


@pytest.mark.parametrize("case", WRONG)
def test_what_is_not_as_it_was_made_is_made_again(kept, case: str) -> None:
    entry, _ = kept()
    assert kept() == (entry, 1)
    WRONG[case](entry)
    assert kept() == (entry, 2) and kept() == (entry, 2)
    done = subprocess.run([entry / "program"], capture_output=True, text=True)
    assert done.stdout == "mine\n" and not entry.is_symlink()
    assert {p.name for p in entry.parent.iterdir()} <= {"m-1", "x"}


def test_in_the_folder_of_another_nothing_is_kept(kept, tmp_path: Path) -> None:
    (tmp_path / "cache").mkdir()
    chown(tmp_path / "cache")
    with pytest.raises(BuildError, match="belongs to another user; name another"):
        kept()


@pytest.mark.parametrize("folder", ["cache", "cache/programs"])
@pytest.mark.parametrize("mode", [0o777, 0o775, 0o1777, 0o755, 0o700])
def test_the_mode_of_a_folder_that_is_given_stays(kept, tmp_path, mode: int, folder: str) -> None:
    given = tmp_path / folder
    given.mkdir(parents=True)
    given.chmod(mode)
    if mode in (0o777, 0o775):
        with pytest.raises(BuildError, match="can be written by other users: chmod go-w; name"):
            kept()
    else:
        assert not kept()[0].parent.stat().st_mode & 0o022 or folder != "cache"
    assert given.stat().st_mode & 0o7777 == mode


COLD = """
import sys, time
from pathlib import Path
from pkgen.system import cache
def make(new):
    Path(sys.argv[1]).open("a").write("made\\n")
    time.sleep(1)
    (new / "program").write_text("x")
cache.cached("runtime", "one", make)
"""


def test_eight_cold_processes_make_it_once(tmp_path: Path) -> None:
    env = {**os.environ, "PKGEN_CACHE": str(tmp_path / "cache")}
    log = tmp_path / "log"
    command = [sys.executable, "-c", COLD, log]
    pipe = subprocess.PIPE
    started = [subprocess.Popen(command, env=env, stderr=pipe, text=True) for _ in range(8)]
    said = [child.communicate(timeout=300)[1] for child in started]
    assert all(child.returncode == 0 for child in started), said
    assert log.read_text() == "made\n"
    assert [p.name for p in (tmp_path / "cache/runtime").iterdir()] == ["one"]


def test_what_was_begun_and_never_ended_is_swept(kept) -> None:
    entry, _ = kept()
    old, new = entry.parent / ".new-old", entry.parent / ".new-young"
    for path in (old, new):
        path.mkdir()
        (path / files.MARK).write_text(f"{files._marked(path.name)}{'0' * 32}\n")
    os.utime(old, (1, 1))
    files.sweep.cache_clear()
    entry.chmod(0o777)
    kept()
    assert not old.exists() and new.exists()


def test_the_newest_are_kept_and_those_just_used(kept, monkeypatch) -> None:
    monkeypatch.setattr(cache, "KEPT", 2)
    entry, _ = kept()
    now = time.time()
    for k, age in enumerate((10, 20, 8000, 9000)):
        (entry.parent / f"m{k}").mkdir()
        os.utime(entry.parent / f"m{k}", (now - age, now - age))
    cache._prune(entry.parent)
    assert {p.name for p in entry.parent.iterdir()} == {"m-1", "m0", "m1"}


def test_demo_tests_and_pkgen_share_one() -> None:
    from conftest import ROOT

    assert "PKGEN_CACHE" not in (ROOT / "Makefile").read_text()
