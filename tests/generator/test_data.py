"""What CSV files of tables may hold, and which are refused, at the cell that is wrong."""

from pathlib import Path

import numpy as np
import pytest

from pkgen.front import data

XY = (("x", "m"), ("y", ""))


def read(tmp_path: Path, text: str, outside: str = "error") -> list[list[float]]:
    path = tmp_path / "f.csv"
    path.write_bytes(text.encode())
    made = data.curve(data.read(path), XY, (1, 1), "linear", outside)
    return [made.axes[0].knots.tolist(), made.knot_values().tolist()]


@pytest.mark.parametrize(
    "text",
    [
        "0,1\n2,3\n",
        "x,y\r\n0,1\r\n2,3",
        "\ufeffx [m],y\n0,1\n\n2,3\n",
        "y;x\n1;0\n3;2\n",
        "x\ty\tmore\n0\t1\ta\n2\t3\t\n",
        '# by "hand\n0,1\n# and, then"\n2,3\n',
        '"x","y"\n"0",1\n 2 , 3 \n',
    ],
)
def test_what_is_read(text: str, tmp_path: Path) -> None:
    assert read(tmp_path, text) == [[0, 2], [1, 3]]


@pytest.mark.parametrize(
    ("text", "place", "why"),
    [
        ("x,y\n1,5,3\n2,5,4\n", "2:5", "the first row has fewer cells"),
        ("0,nan\n0.5,3\n3,7\n", "1:3", "'nan' is no finite number"),
        ("0,1.O\n0.5,3\n3,7\n", "1:3", "'1.O' is no number, though others of its row are"),
        ("x,y\n0,1\n2,1e999\n", "3:3", "'1e999' is no finite number"),
        ("x;y\n0;1\n0,5;3\n", "3:1", "'0,5' is no finite number"),
        ("x,y\n0,1\n2\n", "3:3", "column 2 has no number here"),
        ("x,y\n0,1\n0,3\n", "3:1", "0 is not above 0"),
        ('x,y\n0,"1\n2,3\n', "2:1", "unexpected end of data"),
        ("x,x,y\n0,1,2\n1,2,3\n", "", "there are two columns 'x'"),
        ("x [mm],y\n0,1\n2,3\n", "", "the column 'x' is in [mm], not in [m]"),
        ("x,z\n0,1\n2,3\n", "", "there is no column 'y'"),
        ("", "", "two rows of numbers at least"),
        ("0,-1e308\n1e-320,1e308\n", "", "the rows are too close for their values"),
    ],
)
def test_what_is_refused(text: str, place: str, why: str, tmp_path: Path) -> None:
    with pytest.raises(data.WrongData) as wrong:
        read(tmp_path, text)
    assert why in str(wrong.value)
    assert f"f.csv:{place}: " in str(wrong.value) if place else "f.csv: " in str(wrong.value)


def test_arrays_are_copied_and_stay_as_they_are() -> None:
    x, y = np.array([0.0, 1, 2]), np.array([0.0, 1, 4])
    made = data.of_arrays([x], y, "linear", "hold", "road")
    x[1], y[1] = 1.5, 9
    assert made.value((0,), 1.0) == 1
    for array in (made.axes[0].knots, made.coefficients):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 3


@pytest.mark.parametrize("far", [1e7, 1e16, 1e300])
def test_far_outside_the_last_value_holds(far: float) -> None:
    x = np.linspace(0, 1, 100_001)
    made = data.of_arrays([x], x, "linear", "hold", "road")
    assert [float(made.value((0,), sign * far)) for sign in (1, -1)] == [1, 0]
