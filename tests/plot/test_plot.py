"""`pkgen plot`: what is on the pictures."""

import json
from pathlib import Path

import numpy
import pytest
from svg import Svg

from conftest import ROOT, ran, run_pkgen
from pkgen.plot import compose
from pkgen.plot.spectrum import amplitudes
from pkgen.plot.table import read
from pkgen.plot.view import View

PENDULUM = ROOT / "models/pendulums/pendulum.lag"
DOUBLE = ROOT / "models/double_pendulum.lag"
HENON = ROOT / "models/particles/henon_heiles.lag"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Rows: of a run with what stands beside them, with units in the head, and without either."""
    folder = tmp_path_factory.mktemp("rows")
    for name, more in (("run.csv", ()), ("units.csv", ("--units",)), ("run.npy", ())):
        ran("run", DOUBLE, "--until", 2, *more, "-o", folder / name)
    (folder / "units.csv.json").unlink()
    t = numpy.linspace(0, 10, 401)
    data = numpy.column_stack([t, 3 * numpy.sin(5 * t), t**2 / 20])
    numpy.savetxt(folder / "made.csv", data, delimiter=",", header="t [s],a [m],b", comments="")
    return folder


def plot(*words: object) -> list[str]:
    """What is said besides."""
    done = ran("plot", *words)
    return done.stderr.splitlines()


def panel(*words: object) -> dict:
    """Of a picture with one."""
    done = ran("plot", *words, "--json")
    (found,) = json.loads(done.stdout)["panels"]
    return found


def test_columns_over_time(folder: Path) -> None:
    assert plot(folder / "made.csv", "-o", folder / "made.svg") == []
    made = Svg(folder / "made.svg")
    assert len(made.axes) == 2 and {"t [s]", "a [m]", "b"} <= set(made.texts)
    assert [axes.colours() for axes in made.axes] == [[0], [0]]
    t = numpy.linspace(0, 10, 401)
    curve = made.axes[0].curve(0)
    expected = numpy.interp(curve[:, 0], t, 3 * numpy.sin(5 * t))
    assert expected == pytest.approx(curve[:, 1], abs=0.1) and numpy.ptp(curve[:, 1]) > 5.9
    assert [*curve[[0, -1], 0]] == pytest.approx([0, 10], abs=0.02)
    assert made.axes[1].curve(0)[-1] == pytest.approx([10, 5], abs=0.02)


def test_names_and_units_are_the_models(folder: Path) -> None:
    words = {"t [s]", "θ₁, θ₂ [rad]", "θ₁′, θ₂′ [rad/s]", "θ₁", "θ₂"}
    for name in ("run.csv", "run.npy", "units.csv"):
        plot(folder / name, "-o", folder / "units.svg")
        made = Svg(folder / "units.svg")
        assert words <= set(made.texts), name
        assert [axes.colours() for axes in made.axes] == [[0, 1], [0, 1]]
        assert not any("energy" in text for text in made.texts)


def test_a_model_is_run_and_drawn_as_its_rows_are(folder: Path) -> None:
    said = plot(DOUBLE, "--until", 2, "-o", folder / "model.svg")
    assert said[0].startswith("gauss: t = 2 after")
    plot(folder / "run.csv", "-o", folder / "file.svg")
    assert (folder / "model.svg").read_text() == (folder / "file.svg").read_text()
    assert "double pendulum: gauss" in Svg(folder / "model.svg").texts


def test_panels_are_of_one_unit_and_size(folder: Path) -> None:
    """Rounding joins what it is the rounding of; components are named by their vector."""
    t = numpy.linspace(0, 1, 50)
    noise = 1e-17 * numpy.cos(999 * t)
    columns = {"t": t, "x [m]": t, "y [m]": 1000 * t, "z [m]": noise, "r.x": t, "r.y": 2 * t}
    numpy.savetxt(
        folder / "sizes.csv",
        numpy.column_stack([*columns.values()]),
        delimiter=",",
        header=",".join(columns),
        comments="",
    )
    plot(folder / "sizes.csv", "-o", folder / "sizes.svg")
    made = Svg(folder / "sizes.svg")
    assert [len(axes.lines) for axes in made.axes] == [1, 2, 2]
    assert {"x [m]", "y, z [m]", "r"} <= set(made.texts)


def test_only_some_columns(folder: Path) -> None:
    plot(folder / "run.csv", "--columns", "theta2,energy", "-o", folder / "some.svg")
    made = Svg(folder / "some.svg")
    assert len(made.axes) == 2 and {"θ₂ [rad]", "energy [J]"} <= set(made.texts)
    energy = made.axes[1].curve(0)[:, 1]
    assert numpy.ptp(energy) < 1e-3 and energy[0] == pytest.approx(-11.273, abs=0.02)


def test_what_a_model_can_record_is_drawn(folder: Path) -> None:
    """x2 and y2 are no columns of its rows."""
    paths = ("--path", "x2,y2", "--path", "x1,y1")
    plot(DOUBLE, *paths, "--until", 2, "-o", folder / "path.svg")
    made = Svg(folder / "path.svg")
    assert {"x₂, x₁ [m]", "y₂, y₁ [m]", "x₂, y₂", "x₁, y₁"} <= set(made.texts)
    upper = made.axes[0].curve(made.axes[0].colours().index(1))
    assert numpy.hypot(*upper.T) == pytest.approx(1, abs=0.01)  # on its rod
    assert numpy.ptp(upper[:, 0]) > 1


def test_lengths_are_equal_in_a_path_alone(folder: Path) -> None:
    plot(folder / "run.csv", "--path", "theta1,theta2", "-o", folder / "equal.svg")
    (axes,) = Svg(folder / "equal.svg").axes
    assert axes.unit("x") == pytest.approx(axes.unit("y"), rel=0.01)
    plot(folder / "run.csv", "--phase", "theta1", "-o", folder / "equal.svg")
    (axes,) = Svg(folder / "equal.svg").axes
    assert axes.unit("x") > 2 * axes.unit("y")


def test_phase_plane(folder: Path) -> None:
    plot(PENDULUM, "--phase", "theta", "-o", folder / "phase.svg")
    made = Svg(folder / "phase.svg")
    assert {"θ [rad]", "θ′ [rad/s]"} <= set(made.texts)
    theta, rate = made.axes[0].curve(0).T
    energy = rate**2 / 2 - 9.81 * numpy.cos(theta)
    assert energy == pytest.approx(0, abs=0.2) and numpy.ptp(rate) > 8


def test_path_in_space(folder: Path) -> None:
    top = ROOT / "models/bodies/heavy_top_rotation.lag"
    plot(top, "--scene", "cusps", "--path", "top", "-o", folder / "space.svg")
    assert {"top.x", "top.y", "top.z"} <= set(Svg(folder / "space.svg").texts)


def test_a_section_is_points(folder: Path) -> None:
    found = panel(HENON, "--at", "section", "--until", 300, "-o", folder / "section.svg")
    assert (found["x"], found["y"]) == ("y", "y′")  # x is 0 there
    (line,) = found["lines"]
    assert line["kind"] == "points" and line["points"] > 20


def test_the_spectrum_has_its_line_where_it_is(folder: Path) -> None:
    plot(folder / "made.csv", "--spectrum", "a", "-o", folder / "spectrum.svg")
    made = Svg(folder / "spectrum.svg")
    assert {"angular frequency [rad/s]", "amplitude of a [m]"} <= set(made.texts)
    omega, found = amplitudes(read(str(folder / "made.csv")), "a")
    k = int(found.argmax())
    assert abs(omega[k] - 5) <= omega[1] and found[k] == pytest.approx(3, rel=0.15)
    assert found[omega > 15].max() < 0.01


def test_drifts_of_all_that_is_constant(folder: Path) -> None:
    found = panel(ROOT / "models/heavy_top.lag", "--drift", "-o", folder / "drift.svg")
    named = [line["label"].split(":")[0] for line in found["lines"] if line["label"]]
    assert {"energy", "p_φ", "p_ψ"} <= set(named) and len(named) == len(set(named))
    assert "relative drift" in Svg(folder / "drift.svg").texts


def test_a_drift_is_that_of_the_report(folder: Path) -> None:
    table = read(str(folder / "run.csv"))
    (found,) = compose.picture(View("drift"), [table]).panels
    strong, pale = found.lines
    most = table.told["report"]["drifts"][0]["max"]
    assert numpy.nanmax(pale.y) == pytest.approx(most, rel=0.5) and most > 1e-14
    assert strong.y[-1] == numpy.nanmax(pale.y)


def test_several_files_over_each_other(folder: Path) -> None:
    for method in ("rk4", "verlet"):
        words = ("--method", method, "--step", 0.1, "--until", 5)
        ran("run", PENDULUM, *words, "-o", folder / f"{method}.csv")
    files = folder / "rk4.csv", folder / "verlet.csv"
    plot(*files, "-o", folder / "both.svg")
    made = Svg(folder / "both.svg")
    assert [axes.colours() for axes in made.axes] == [[2, 0], [2, 0]]  # its methods'
    assert {"rk4.csv", "verlet.csv", "θ [rad]", "pendulum"} <= set(made.texts)
    plot(files[0], "--phase", "theta", files[1], "-o", folder / "between.svg")
    assert Svg(folder / "between.svg").axes[0].colours()[:2] == [2, 0]


def test_a_bundle_of_members(folder: Path) -> None:
    plot(PENDULUM, "--scene", "all_amplitudes", "--columns", "theta", "-o", folder / "bundle.svg")
    assert {"θ [rad]", "member k"} <= set(Svg(folder / "bundle.svg").texts)
    (folder / "members.csv").write_text("theta\n0.5\n1\n1.5\n")
    few = (PENDULUM, "--ensemble", folder / "members.csv", "--every", 0.01, "--until", 2)
    plot(*few, "--columns", "theta", "-o", folder / "few.svg")
    made = Svg(folder / "few.svg")
    assert made.axes[0].colours() == [0, 1, 2]
    starts = [made.axes[0].curve(k)[0, 1] for k in range(3)]
    assert starts == pytest.approx([0.5, 1, 1.5], abs=0.01)
    assert {"member 1", "member 3"} <= set(made.texts)


def test_final_states_are_a_cloud(folder: Path) -> None:
    (folder / "fifty.csv").write_text("theta\n" + "\n".join(f"{k / 50}" for k in range(1, 51)))
    few = (PENDULUM, "--ensemble", folder / "fifty.csv", "--until", 2)
    (line,) = panel(*few, "-o", folder / "cloud.svg")["lines"]
    assert line == {"label": "t = 2\u00a0s", "kind": "points", "points": 50}


def test_a_long_family_is_an_image(folder: Path) -> None:
    plot(ROOT / "models/chains/fput.lag", "--columns", "q", "-o", folder / "chain.svg")
    made = Svg(folder / "chain.svg")
    assert made.images() >= 1 and {"index of q", "q", "t"} <= set(made.texts)


@pytest.mark.parametrize("kind, head", [("png", b"\x89PNG"), ("pdf", b"%PDF"), ("svg", b"<?xml")])
def test_the_end_of_the_name_is_the_format(folder: Path, kind: str, head: bytes) -> None:
    out = folder / f"picture.{kind}"
    found = []
    for _ in range(2):
        plot(folder / "made.csv", "-o", out)
        found.append(out.read_bytes())
    assert found[0].startswith(head) and found[0] == found[1]  # the same from run to run


def test_the_width_is_that_of_a_column_or_a_page(folder: Path) -> None:
    out = folder / "width.svg"
    for words, width in (((), 180), (("--width", 90), 90), (("--phase", "a,b"), 90)):
        plot(folder / "made.csv", *words, "-o", out)
        assert Svg(out).size[0] == pytest.approx(width, abs=0.1)


def test_pictures_are_small(folder: Path) -> None:
    plot(PENDULUM, "--scene", "loop", "-o", folder / "loop.svg")
    assert 20_000 < (folder / "loop.svg").stat().st_size < 400_000  # of 400,000 points
    plot(folder / "run.csv", "-o", folder / "small.svg")
    assert (folder / "small.svg").stat().st_size < 80_000


def test_run_makes_a_picture_beside_its_rows(folder: Path) -> None:
    words = ("run", DOUBLE, "--until", 2)
    done = run_pkgen(*words, "-o", folder / "r.csv", "--plot", folder / "r.svg")
    assert done.returncode == 0 and done.stdout == ""
    assert (folder / "r.csv").read_text() == (folder / "run.csv").read_text()
    plot(folder / "run.csv", "-o", folder / "s.svg")
    assert (folder / "r.svg").read_text() == (folder / "s.svg").read_text()


def test_rows_go_where_o_says(folder: Path) -> None:
    words = ("run", DOUBLE, "--until", 2, "--plot", folder / "o.svg")
    assert run_pkgen(*words).stdout == ""
    assert run_pkgen(*words, "-o", "-").stdout == (folder / "run.csv").read_text()
    assert len(json.loads(run_pkgen(*words, "--json").stdout)["rows"]) == 1001


def test_a_path_is_recorded_beside_what_rows_have(folder: Path) -> None:
    words = ("run", DOUBLE, "--until", 2, "-o", folder / "p.csv", "--plot", folder / "p.svg")
    assert run_pkgen(*words, "--path", "x2,y2").returncode == 0
    head = (folder / "p.csv").read_text().splitlines()[0]
    assert head == "t,theta1,theta2,theta1',theta2',energy,x2,y2"


def test_names_are_no_markup(folder: Path) -> None:
    """A formula of TeX, a tag, an underscore in front, which matplotlib hides."""
    names = ["t", "$\\frac{$", "<script>alert(1)</script>", "_hidden", "&amp;"]
    rows = [",".join(names), *(f"{k},{k},{k + 1},{k + 2},{k + 3}" for k in range(9))]
    (folder / "hostile.csv").write_text("\n".join(rows))
    plot(folder / "hostile.csv", "-o", folder / "hostile.svg")
    made = Svg(folder / "hostile.svg")
    assert set(names) <= set(made.texts)
    assert [*made.root.iter("{http://www.w3.org/2000/svg}script")] == []


def test_gaps_are_left_open(folder: Path) -> None:
    rows = [f"{k},{'nan' if k == 5 else k}" for k in range(10)]
    (folder / "gap.csv").write_text("\n".join(["t,x", *rows]))
    plot(folder / "gap.csv", "-o", folder / "gap.svg")
    assert Svg(folder / "gap.svg").axes[0].lines[0].get("d").count("M") == 2


def test_a_directory_is_all_its_rows_sorted(tmp_path: Path) -> None:
    for name, slope in (("b.csv", 2), ("a.csv", 1), ("c.txt", 3)):
        rows = "".join(f"{k},{slope * k}\n" for k in range(20))
        (tmp_path / name).write_text(f"t,x\n{rows}")
    (tmp_path / "d.csv").mkdir()
    lines = panel(tmp_path)["lines"]
    assert [line["label"] for line in lines] == ["a.csv", "b.csv"]
    empty = tmp_path / "d.csv"
    done = run_pkgen("plot", empty)
    assert (done.returncode, done.stdout) == (2, "")
    assert f"{empty}: no *.csv in this directory" in done.stderr
