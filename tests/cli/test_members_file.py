"""Files of members: CSV a block at a time is CSV cell by cell, and Parquet is the same."""

from __future__ import annotations

import random
from pathlib import Path

import numpy
import pytest

from conftest import seeds
from pkgen.compiler import Compilation, compile_model
from pkgen.run import members_file
from pkgen.source import Source
from pkgen.system.exits import UsageError

MODEL = "model m\nparam m = 2 [kg] in (0, inf)\ncoord x [m]\nkinetic m*x'^2/2\nstart x = 1\n"
NUMBERS = ("0", "-1.5", "+2", "1e-3", "2.5E+10", "007", "1e22", "0.1", "123456789.123456789")
ODD = (
    "",
    " 1 ",
    "2 [cm]",
    '"3"',
    "é",
    "1 2",
    *[".5", "1.", "1e", "--1", "1-2", "1e999", "nan", "0x1", "1.2.3", "+", "e5", "1.e5"],
)


@pytest.fixture(scope="module")
def compilation() -> Compilation:
    return compile_model(Source("m.lag", MODEL))


def found(path: Path, compilation: Compilation) -> object:
    """What a file has, or what is said of it."""
    try:
        read = members_file.read(str(path), compilation)
    except UsageError as error:
        return str(error)
    return read.columns, list(read.lines), list(numpy.ravel(read.values))


@pytest.fixture
def both(compilation: Compilation, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """What a text has by blocks where that can be, and cell by cell."""

    def read(data: bytes) -> list[object]:
        path = tmp_path / "m.csv"
        path.write_bytes(data)
        quick = found(path, compilation)
        monkeypatch.setattr(members_file._Reader, "plain", lambda self: None)
        return [quick, found(path, compilation)]

    return read


@pytest.mark.parametrize("cell", ODD)
@pytest.mark.parametrize("place", range(3))
def test_one_cell_that_is_odd(cell: str, place: int, both) -> None:
    cells = ["1", "2", "3"]
    cells[place] = cell
    quick, slow = both(("x\n" + "\n".join(cells)).encode())
    assert quick == slow


LENGTHS = ["1,2,3\n4\n", "1\n2,3,4\n", "1,2\n3\n4\n", "1,2\r", "1,2\r3,4", "1,2\n\n3,4"]


@pytest.mark.parametrize("rows", [*LENGTHS, "1,2,", "1,2,3,4\n", ""])
def test_rows_of_other_lengths(rows: str, both) -> None:
    quick, slow = both(b"x,m\n" + rows.encode())
    assert quick == slow


@pytest.mark.parametrize("seed", seeds(range(3), 27))
def test_plain_rows_are_cells(seed: int, both) -> None:
    rng = random.Random(seed)
    names = rng.sample(["x", "x'", "m"], rng.choice([1, 2, 3]))
    odd = rng.choice([0, 0, 0.02, 0.3])

    def cell() -> str:
        if rng.random() < odd:
            return rng.choice(ODD)
        return rng.choice([rng.choice(NUMBERS), repr(rng.lognormvariate(0, 90))])

    def row() -> str:
        count = len(names) + (rng.random() < odd / 4) - (rng.random() < odd / 4)
        return "" if rng.random() < odd / 4 else ",".join(cell() for _ in range(count))

    end = rng.choice(["\n", "\r\n"])
    text = end.join([",".join(names), *(row() for _ in range(rng.choice([0, 1, 7, 40])))])
    mark = rng.choice(["", "\ufeff"]).encode()
    quick, slow = both(mark + (text + rng.choice(["", end])).encode())
    assert quick == slow


def test_plain_numbers_are_read_by_numpy(compilation: Compilation, tmp_path: Path) -> None:
    path = tmp_path / "members.csv"
    path.write_text("x,m\n" + "-1.5e-3,2\n" * 3)
    assert members_file._Reader(str(path), compilation).plain() is not None


def test_parquet_is_csv_with_units_of_its_own(compilation: Compilation, tmp_path: Path) -> None:
    arrow = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    values = {"x": numpy.linspace(-1, 1, 7), "m": numpy.arange(1, 8)}

    def written(name: str, unit: str = "", **more: object) -> Path:
        fields = [
            arrow.field("x", arrow.float64(), metadata={"unit": unit} if unit else None),
            arrow.field("m", arrow.int32()),
        ]
        table = arrow.table({**values, **more}, schema=arrow.schema(fields))
        parquet.write_table(table, tmp_path / name)
        return tmp_path / name

    rows = zip(values["x"].tolist(), values["m"].tolist(), strict=True)
    (tmp_path / "m.csv").write_text("x,m\n" + "".join(f"{x!r},{m}\n" for x, m in rows))
    columns, _, plain = found(tmp_path / "m.csv", compilation)
    assert found(written("m.parquet"), compilation) == (columns, list(range(1, 8)), plain)
    _, _, in_cm = found(written("cm.parquet", "cm"), compilation)
    assert in_cm == [v if k % 2 else pytest.approx(v / 100) for k, v in enumerate(plain)]
    said = found(written("s.parquet", "s"), compilation)
    assert said.startswith(f"{tmp_path}/s.parquet: column x: 1 [s]: "), said
    missing = [1.0, None, 3.0, 4.0, 5.0, 6.0, 7.0]
    said = found(written("none.parquet", x=missing), compilation)
    assert said == f"{tmp_path}/none.parquet:2: column x: a value is missing or not finite"
    (tmp_path / "no.parquet").write_text("x,m\n1,2\n")
    assert "no.parquet: not Parquet that can be read" in found(tmp_path / "no.parquet", compilation)
