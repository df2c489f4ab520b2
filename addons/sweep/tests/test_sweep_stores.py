"""Sweeps whose files lie in an object store, here one of S3's interface that is made for the test:
the same bytes as in a folder, whatever is killed."""

from __future__ import annotations

import json
import os
import random
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from sweeps import DOUBLE, PLAN, contents

pytest.importorskip("pyarrow")
pytest.importorskip("s3fs")
pytest.importorskip("upath")
moto = pytest.importorskip("moto.server")
SLOW = PLAN.replace("members = 8", "members = 40").replace("step = 0.1", "step = 2e-5")
KEYS = {
    "AWS_ACCESS_KEY_ID": "a",
    "AWS_SECRET_ACCESS_KEY": "b",
    "AWS_DEFAULT_REGION": "us-east-1",
}


@pytest.fixture(scope="module")
def env() -> Iterator[dict[str, str]]:
    server = moto.ThreadedMotoServer(port=0, verbose=False)
    server.start()
    host, port = server.get_host_and_port()
    yield {**os.environ, **KEYS, "AWS_ENDPOINT_URL": f"http://{host}:{port}"}
    server.stop()


def bucket(env: dict[str, str], name: str):
    """Its file system."""
    import s3fs

    keys = {"key": env["AWS_ACCESS_KEY_ID"], "secret": env["AWS_SECRET_ACCESS_KEY"]}
    found = s3fs.S3FileSystem(
        **keys, endpoint_url=env["AWS_ENDPOINT_URL"], use_listings_cache=False,
        skip_instance_cache=True,
    )  # fmt: skip
    found.mkdir(name)
    return found


def swept(env: dict[str, str], *words: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "pkgen", *map(str, words)]
    return subprocess.run(command, env=env, capture_output=True, text=True)


def test_a_store_has_the_bytes_of_a_folder(pkgen, env: dict[str, str], tmp_path: Path) -> None:
    path, at = tmp_path / "plan.toml", "s3://first/some/sweep"
    path.write_text(
        PLAN.replace('["final"]', '["final", "rows", "max(theta2)"]') + 'm1 = "1 .. 2"\n'
    )
    store = bucket(env, "first")
    command = ("sweep", DOUBLE, "--plan", path, "--shard", 3, "-o")
    assert pkgen(*command, tmp_path / "s").returncode == 0
    done = swept(env, *command, at)
    assert done.returncode == 0, done.stderr
    here = contents(tmp_path / "s")
    assert {name: store.cat(f"first/some/sweep/{name}") for name in here} == here
    assert not store.find("first/some/sweep/shards")
    found = json.loads(swept(env, "sweep", "--status", at, "--json").stdout)
    assert found["done"] == found["members"] == 8 and not found["running"]
    name = next(iter(here))
    store.pipe(f"first/some/sweep/{name}", here[name][:-9] + b"x" * 9)  # what is torn is mended
    assert swept(env, "sweep", "--resume", at).returncode == 0
    assert store.cat(f"first/some/sweep/{name}") == here[name]
    drawn = swept(env, "plot", at, "--columns", "max(theta2)", "-o", tmp_path / "m.svg")
    assert drawn.returncode == 0 and (tmp_path / "m.svg").exists(), drawn.stderr
    refused = swept(env, "sweep", DOUBLE, "--plan", path, "-o", at, "--engine", "slurm")
    assert refused.returncode == 2
    other = tmp_path / "other.toml"
    other.write_text(PLAN.replace("= 8", "= 9"))
    refused = swept(env, "sweep", DOUBLE, "--plan", other, "-o", at)
    assert refused.returncode == 2 and "of another plan" in refused.stderr
    store.pipe("first/mine/thing", b"x")
    refused = swept(env, "sweep", DOUBLE, "--plan", path, "-o", "s3://first/mine")
    assert refused.returncode == 2 and "it has thing in it" in refused.stderr


def test_what_is_killed_is_not_lost(pkgen, env: dict[str, str], tmp_path: Path) -> None:
    path, at = tmp_path / "plan.toml", "s3://second/sweep"
    path.write_text(SLOW)
    store = bucket(env, "second")
    command = ("sweep", DOUBLE, "--plan", path, "-o")
    assert pkgen(*command, tmp_path / "s").returncode == 0
    words = [sys.executable, "-m", "pkgen", *map(str, command), at, "--shard", "4"]
    killed = 0
    for _ in range(9):
        running = subprocess.Popen(words, env=env, stderr=subprocess.PIPE, text=True)
        due = len(store.find("second/sweep/shards")) + random.randint(1, 3)
        while running.poll() is None and killed < 2:
            time.sleep(0.05)
            if len(store.find("second/sweep/shards")) >= due:
                killed += 1
                running.kill()
        said = running.communicate()[1]
        if running.returncode == 0:
            break
        assert running.returncode == -9, said
    assert running.returncode == 0 and killed, said
    here = contents(tmp_path / "s")
    assert {name: store.cat(f"second/sweep/{name}") for name in here} == here


def test_an_address_that_is_none(env: dict[str, str], tmp_path: Path) -> None:
    path = tmp_path / "plan.toml"
    path.write_text(PLAN)
    for at, why in (
        ("s3://nowhere/x", "nowhere/x"),
        ("gopher://x/y", "gopher"),
        (f"file://{tmp_path}/s", ""),
    ):
        done = swept(env, "sweep", DOUBLE, "--plan", path, "-o", at)
        assert done.returncode == (2 if why else 0) and why in done.stderr, done.stderr
        assert "Traceback" not in done.stderr
    assert contents(tmp_path / "s")
