"""Which members a plan draws, and how shards of them become a data set: nothing is run here."""

from __future__ import annotations

import math
import random
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from sweeps import DOUBLE

from pkgen.compiler import compile_model
from pkgen.equations import Quantity
from pkgen.front.read import read
from pkgen.run.ensemble import Column
from pkgen.source import Source
from pkgen_sweep import axes, parts, shards, work
from pkgen_sweep.job import Job
from pkgen_sweep.plan import of_text
from pkgen_sweep.reductions import Kept
from pkgen_sweep.sampling import Axis, Starts

pq = pytest.importorskip("pyarrow.parquet")
qmc = pytest.importorskip("scipy.stats.qmc")


def philox(seed: int, block: int) -> list[int]:
    """Four words of Philox 4x64-10 (Salmon et al., 2011); NumPy's counter begins with 1."""
    words = 1 << 64
    key, x = [seed % words, 0], [block + 1, 0, 0, 0]
    for _ in range(10):
        a, b = 0xD2E7470EE14C6C93 * x[0], 0xCA5A826395121157 * x[2]
        x = [b // words ^ x[1] ^ key[0], b % words, a // words ^ x[3] ^ key[1], a % words]
        key = [(key[0] + 0x9E3779B97F4A7C15) % words, (key[1] + 0xBB67AE8584CAA73B) % words]
    return x


def uniform(seed: int, member: int, axis: int, width: int) -> float:
    blocks = -(-width // 4)
    return (philox(seed, member * blocks + axis // 4)[axis % 4] >> 11) / 2**53


def drawn(kind: str, pick: random.Random) -> Starts:
    made = []
    for k in range(pick.randint(1, 9 if kind in ("random", "latin") else 4)):
        lo, n = pick.uniform(-3, 3), pick.randint(2, 5)
        values = tuple(pick.uniform(-1, 1) for _ in range(pick.choice([0, n])))
        if kind == "list":
            values = tuple(pick.uniform(-1, 1) for _ in range(64))
        made.append(Axis(Column(f"p{k}", "param", k, ""), lo, lo + pick.uniform(0, 2), n, values))
    members = math.prod(len(x.values) or x.points for x in made) if kind == "grid" else 64
    return Starts(kind, tuple(made), members, pick.randrange(1 << 64))


@pytest.mark.parametrize("kind", ["random", "latin", "sobol", "grid", "list", "points"])
def test_members_are_functions_of_their_numbers(kind: str) -> None:
    pick = random.Random(kind)
    for _ in range(10):
        starts = drawn("grid" if kind == "points" else kind, pick)
        seed, width, n = starts.seed, len(starts.axes), starts.members
        lo, hi = (np.array([getattr(x, end) for x in starts.axes]) for end in ("lo", "hi"))
        u = np.array([[uniform(seed, m, k, width) for k in range(width)] for m in range(n)])
        nodes = [x.values or np.linspace(x.lo, x.hi, x.points) for x in starts.axes]
        expected = np.array(list(product(*nodes)) if kind in ("grid", "points") else u)
        if kind == "points":
            some = np.array(sorted(pick.sample(range(n), max(1, n // 2))))
            expected, n = expected[some], len(some)
            starts = Starts(kind, starts.axes, n, seed, some)
        whole = starts.values(0, n)
        if kind == "list":
            expected = np.array([x.values for x in starts.axes]).T
        elif kind == "sobol":
            expected = qmc.Sobol(width, bits=32, seed=seed).random(n)
        elif kind == "latin":  # one in each stratum, in an order of its own along each axis
            strata = np.floor((whole - lo) / (hi - lo) * n + 1e-9 - u + 0.5)
            assert (np.sort(strata, axis=0) == np.arange(n)[:, None]).all()
            orders = {tuple(x) for x in [*strata.T, np.arange(n)]}
            assert len(orders) == width + 1
            expected = (strata + u) / n
        if kind in ("random", "latin", "sobol"):
            expected = lo + (hi - lo) * expected
        assert whole == pytest.approx(expected, rel=1e-12, abs=1e-12)
        for _ in range(5):
            first = pick.randrange(n)
            count = pick.randint(1, n - first)
            assert (starts.values(first, count) == whole[first : first + count]).all()


AXES = [
    ('[random]\ntheta1 = "-90 .. 180 [deg]"\nm1 = "500 [g] .. 2 [kg]"', 0, -math.pi / 2, math.pi),
    ('[random]\ntheta1 = "-90 .. 180 [deg]"\nm1 = "500 [g] .. 2 [kg]"', 1, 0.5, 2.0),
    ('[latin]\n"theta1\'" = "-1 .. 360 [deg/s]"', 0, -math.pi / 180, 2 * math.pi),
    ('[grid]\nl1 = "10 [cm] .. 2"', 0, 0.1, 2.0),
    ('[grid]\nl1 = ["10 .. 200 [cm]", 3]', 0, 0.1, 2.0),
]


@pytest.fixture(scope="module")
def double():
    return compile_model(read(str(DOUBLE)))


@pytest.mark.parametrize(("text", "at", "lo", "hi"), AXES)
def test_ranges_are_in_units(double, text: str, at: int, lo: float, hi: float) -> None:
    starts = axes.starts(of_text(Source("plan.toml", f"members = 3\n{text}\n")), double)
    axis = starts.axes[at]
    assert (axis.lo, axis.hi) == pytest.approx((lo, hi), rel=1e-15)
    assert starts.members == 3
    if starts.kind == "grid":
        assert list(starts.values(0, 3)[:, at]) == pytest.approx([lo, (lo + hi) / 2, hi])


def test_values_are_in_units(double) -> None:
    for kind in ("grid", "list"):
        text = f'[{kind}]\nm1 = ["1 [kg]", "3000 [g]", 0.25]\n'
        starts = axes.starts(of_text(Source("plan.toml", text)), double)
        assert starts.values(0, 3).tolist() == [[1.0], [3.0], [0.25]]


def test_plain_ranges_of_a_grid_share_its_members(double) -> None:
    text = 'members = {}\n[grid]\ntheta1 = "0 .. 1"\ntheta2 = "0 .. 2"\nm1 = [1, 2]\n'
    starts = axes.starts(of_text(Source("plan.toml", text.format(50))), double)
    assert [len(x.values) or x.points for x in starts.axes] == [5, 5, 2]
    with pytest.raises(axes.UsageError, match="axis: 50 or 72 members"):
        axes.starts(of_text(Source("plan.toml", text.format(56))), double)


class Cut:
    """Random members with rows, as shards hold them."""

    def __init__(self, folder: Path, seed: int):
        pick, rng = random.Random(seed), np.random.default_rng(seed)
        n = self.n = pick.randint(20, 300)
        self.before = pick.choice([0, 1000])
        axis = Axis(Column("x", "q", 0, "m"), -1.0, 1.0)
        columns = tuple(Quantity(name, "m", "") for name in "txy")
        kept = Kept(((b"f", 0),), columns[2:], columns[:2])
        starts = Starts("random", (axis,), n, seed)
        counts = Quantity("member", "", "")
        self.job = Job("m", "d", {}, (), {}, None, starts, kept, "s", counts, None, self.before)
        shard, part = pick.randint(1, n), pick.randint(1, n)
        self.folder = shards.Folder(folder, "d", n, shard, part, True, int(self.before > 0))
        self.folder.made()
        self.status = rng.choice([0, 1, -1, -2, -7], n, p=[0.5, 0.2, 0.1, 0.1, 0.1])
        y = np.where((self.status < 0) | (rng.random(n) < 0.2), np.nan, rng.normal(size=n))
        self.members = np.stack([self.status, rng.random(n), y], axis=1)
        number = np.repeat(np.arange(n) + self.before + 1, rng.integers(0, 4, n))
        self.rows = np.column_stack([number, rng.normal(size=(len(number), 2))])
        self.pick = pick

    def write(self, k: int) -> None:
        first, count = self.folder.of_shard(k)
        blocks, pick = [], random.Random(k)
        while count:
            some = pick.randint(1, count)
            ends = np.array([first, first + some]) + self.before + 1
            a, b = np.searchsorted(self.rows[:, 0], ends)
            blocks.append(
                (self.members[first : first + some], self.rows[a:b], self.report(first, some))
            )
            first, count = first + some, count - some
        shards.write_shard(self.folder, k, blocks)

    def report(self, first: int, count: int) -> dict:
        found = {}
        for k in range(first, first + count):
            if self.status[k] < 0:
                name = parts.STATUSES[self.status[k]]
                one = {"status": name, "count": 0, "member": k + 1 + self.before}
                one = {**one, "t": self.members[k, 1], "reason": f"why {k}"}
                found.setdefault(name, one)["count"] += 1
        return {"failures": list(found.values())}


@pytest.mark.parametrize("seed", range(8))
def test_parts_are_cut_by_members(monkeypatch, tmp_path: Path, seed: int) -> None:
    of = Cut(tmp_path, seed)
    folder = of.folder
    monkeypatch.setattr(parts, "GROUP", of.pick.randint(1, of.n))
    for k in of.pick.sample(folder.shards, len(folder.shards)):
        of.write(k)
    assert work.survey(folder, True) == ([], list(folder.parts))
    for k in of.pick.sample(folder.parts, len(folder.parts)):
        said = work.part(of.job, folder, k)
        first, count = folder.of_part(k)
        assert (said["first"], said["count"]) == (first, count)
        wanted = of.report(first, count)["failures"]
        each = [of.report(*folder.of_shard(one))["failures"] for one in folder.shards_of(k)]
        reasons = {x["reason"] for known in each for x in known}  # of the first of a shard
        wanted = [{**x, "reason": x["reason"] if x["reason"] in reasons else ""} for x in wanted]
        assert sorted(said["failures"], key=str) == sorted(wanted, key=str)
        file = pq.ParquetFile(folder.data_files(k)[0])
        groups = [file.metadata.row_group(g).num_rows for g in range(file.num_row_groups)]
        assert set(groups[:-1]) <= {parts.GROUP} and sum(groups) == count
    assert not list((tmp_path / "shards").iterdir())
    assert work.survey(folder, True) == ([], [])
    found = pq.read_table(tmp_path / "data").to_pydict()
    assert found["member"] == list(range(of.before + 1, of.before + of.n + 1))
    assert found["x(0)"] == of.job.starts.values(0, of.n)[:, 0].tolist()
    assert found["status"] == [parts.STATUSES[code] for code in of.status]
    assert found["t"] == of.members[:, 1].tolist()
    assert found["y"] == [None if math.isnan(y) else y for y in of.members[:, 2]]
    rows = pq.read_table(tmp_path / "rows").to_pydict()
    assert list(zip(*rows.values(), strict=True)) == list(map(tuple, of.rows.tolist()))


@pytest.mark.parametrize("seed", range(4))
def test_a_shard_that_is_torn_is_made_again(tmp_path: Path, seed: int) -> None:
    """Bytes are changed, lost or more, or it is a shard of another sweep."""
    of = Cut(tmp_path, seed)
    folder = of.folder
    for k in folder.shards:
        of.write(k)
    part = of.pick.choice(folder.parts)
    torn = of.pick.choice(folder.shards_of(part))
    file = folder.shard_file(torn)
    whole = file.read_bytes()
    at = of.pick.randrange(len(whole))
    changed = whole[:at] + bytes([whole[at] ^ 1 << seed]) + whole[at + 1 :]
    size = 24 * folder.of_shard(torn)[1]  # of its numbers, at least
    in_numbers = bytes([whole[size // 2] ^ 1])
    for wrong in (
        changed,
        whole[: size // 2] + in_numbers + whole[size // 2 + 1 :],
        whole[:at],
        whole + b"\n",
        whole.replace(b'"sweep": "d"', b'"sweep": "e"'),
        whole.replace(b'"level": ', b'"level": 1'),
        b"",
    ):
        file.write_bytes(wrong)
        assert work.part(of.job, folder, part) is None
        assert work.survey(folder, True)[0] == [torn]
        assert not shards.part_is_whole(folder, part, False)
        of.write(torn)
        assert file.read_bytes() == whole
    assert work.part(of.job, folder, part)["part"] == part
