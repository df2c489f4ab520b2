"""The layer of runs (pk/run.h) in process: runs in threads, and settings that a caller changes."""

from __future__ import annotations

import resource
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import checkpoint_runs as runs
import pytest

from conftest import case
from pkgen.cli.run import prepared
from pkgen.run import library

KEPLER = case("run_layer_kepler")


@pytest.fixture(scope="module")
def what(tmp_path_factory: pytest.TempPathFactory):
    path = tmp_path_factory.mktemp("layer") / "kepler.lag"
    path.write_text(KEPLER)
    words = ("--until", "40", "--every", "4", "--method", "dop853", "--diagnose", "lrl")
    return prepared(runs.options(path, *words))


def test_runs_in_threads_have_their_own_particles(what) -> None:
    def found(k: int) -> dict:
        settings = replace(what.settings, start_q=((0, 0.4 + 0.05 * (k % 8)),))
        return library.load(what.library).run(settings).report["diagnostics"]["lrl"]

    alone = [found(k) for k in range(8)]
    assert len({one["pericentres"] for one in alone}) > 1
    with ThreadPoolExecutor(8) as pool:
        assert [*pool.map(found, range(64))] == alone * 8


def test_threads_read_the_list_of_methods(what) -> None:
    of = library.load(what.library)
    alone = of.methods()
    with ThreadPoolExecutor(8) as pool:
        assert all(one == alone for one in pool.map(lambda _: of.methods(), range(64)))


def test_a_run_has_copies_of_its_settings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Members are made long after pk_run_new(), with the parameters that it was given."""
    (tmp_path / "kepler.lag").write_text(KEPLER)
    (tmp_path / "members.csv").write_text("x\n0.3\n0.4\n0.5\n")
    words = ("--until", "4", "--method", "rk4", "--step", "0.01", "--every", "1")
    words += ("--set", "mu=1.5")
    members = ("--ensemble", str(tmp_path / "members.csv"))
    what = prepared(runs.options(tmp_path / "kepler.lag", *words, *members))
    of, given, run = library.load(what.library), [], library.Run
    whole = of.run(what.settings, None, what.ensemble)
    assert whole.code == 0 and len(whole.rows()) == 15

    def idle(library, asked, poll, _):
        given.append(asked)
        return run(library, asked, poll, True)

    monkeypatch.setattr(library, "Run", idle)
    late = of.run(what.settings, None, what.ensemble)
    given[0].parameters[0].value = 9.0
    assert late._c.pk_run_go(late._run) == 0
    assert (late.rows() == whole.rows()).all()


def test_a_run_without_memory_gives_nothing_of_it(what) -> None:
    """Its settings went with the memory: they are not read again."""
    before = resource.getrlimit(resource.RLIMIT_AS)
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    try:
        most = pages * resource.getpagesize() + 2**26
        resource.setrlimit(resource.RLIMIT_AS, (most, before[1]))
        run = library.load(what.library).run(replace(what.settings, every=1e-7))
    finally:
        resource.setrlimit(resource.RLIMIT_AS, before)
    assert run.code == 4 and run.messages == "out of memory\n"
    assert run.given() == {} and len(run.rows()) == 0
