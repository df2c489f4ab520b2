"""`pkgen film`: films are read back, by ffprobe, Pillow and as XML."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
from pathlib import Path
from xml.etree import ElementTree

import numpy
import pytest
from PIL import Image

from conftest import ROOT, run_pkgen

PENDULUM = ROOT / "models/pendulums/pendulum.lag"
DOUBLE = ROOT / "models/double_pendulum.lag"
NS = "{http://www.w3.org/2000/svg}"
BLUE = (0, 0x72, 0xB2)
FFMPEG = pytest.mark.skipif(shutil.which("ffprobe") is None, reason="no ffmpeg here")
SWINGS = """model swings
param l = 1 [m]
param g = 9.81 [m/s^2]
coord theta [rad]
let P = [l*sin(theta), -l*cos(theta), 0]
kinetic (1 [kg])*l^2*theta'^2/2
potential -(1 [kg])*g*l*cos(theta)
start theta = 1.2
draw rod from O to P
draw bob P radius 0.1 [m]
"""


def film(*words: object, code: int = 0) -> dict:
    """What --json says."""
    done = run_pkgen("film", *words, "--json")
    assert done.returncode == code, done.stderr
    return json.loads(done.stdout)


@FFMPEG
@pytest.mark.parametrize("kind, codec", [("mp4", "h264"), ("webm", "vp9")])
def test_videos(tmp_path: Path, kind: str, codec: str) -> None:
    out = tmp_path / f"film.{kind}"
    words = ("--fps", 10, "--seconds", 2, "--pixels", "320x180", "-o", out)
    found = film(DOUBLE, *words)
    assert (found["frames"], found["width"], found["height"]) == (20, 320, 180)
    command = ["ffprobe", "-v", "error", "-count_frames", "-show_streams", "-of", "json", out]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    (stream,) = json.loads(done.stdout)["streams"]
    assert stream["codec_name"] == codec and stream["nb_read_frames"] == "20"
    assert (stream["width"], stream["height"], stream["r_frame_rate"]) == (320, 180, "10/1")
    assert [p.name for p in tmp_path.iterdir()] == [out.name]


def bobs(path: Path) -> list[tuple[float, float]]:
    """Where a GIF's blue disc is, frame by frame, in pixels from the lower left."""
    found = []
    with Image.open(path) as picture:
        for k in range(picture.n_frames):
            picture.seek(k)
            pixels = numpy.asarray(picture.convert("RGB")).astype(int)
            blue = numpy.abs(pixels - BLUE).sum(axis=2) < 60
            assert blue.sum() > 30
            rows, columns = numpy.nonzero(blue)
            found.append((columns.mean() + 0.5, pixels.shape[0] - rows.mean() - 0.5))
    return found


def test_a_gif_shows_the_motion(tmp_path: Path, write) -> None:
    """The disc goes as `pkgen run` says, on a circle about the pivot."""
    model, out = write(SWINGS), tmp_path / "film.gif"
    found = film(model, "--until", 2, "--fps", 10, "--pixels", "320x240", "-o", out)
    assert found["frames"] == 20
    places = numpy.array(bobs(out))
    done = run_pkgen("run", model, "--until", 2, "--every", 2 / 19)
    theta = numpy.array([float(line.split(",")[1]) for line in done.stdout.splitlines()[1:]])
    assert len(theta) == len(places) == 20
    expected = numpy.column_stack([numpy.sin(theta), -numpy.cos(theta)])
    (scale,) = {round(float(x), 3) for x in [numpy.ptp(places[:, 0]) / numpy.ptp(expected[:, 0])]}
    shifts = places - scale * expected
    assert scale > 60 and numpy.ptp(shifts, axis=0).max() < 2  # pixels
    with Image.open(out) as picture:
        assert picture.info["loop"] == 0 and picture.info["duration"] == 100
        assert picture.convert("RGB").getpixel((2, 2)) == (255, 255, 255)


def test_an_svg_moves_without_script(tmp_path: Path, write) -> None:
    out = tmp_path / "film.svg"
    found = film(write(SWINGS), "--until", 2, "--fps", 10, "--no-labels", "-o", out)
    root = ElementTree.parse(out).getroot()
    assert found["frames"] == 20 and root.get("viewBox") == "0 0 960 540"
    assert [*root.iter(f"{NS}script")] == [] and "href" not in out.read_text()
    moving = [a for a in root.iter(f"{NS}animate")]
    assert {a.get("attributeName") for a in moving} == {"d", "cx", "cy"}
    assert {a.get("dur") for a in moving} == {"2s"}
    (rod,) = (a for a in moving if a.get("attributeName") == "d")
    x, y = (a.get("values").split(";") for a in moving if a.get("attributeName") != "d")
    ends = [re.findall(r"[\d.-]+", d)[2:] for d in rod.get("values").split(";")]
    assert len(ends) == 20 and ends == [[a, b] for a, b in zip(x, y, strict=True)]
    assert numpy.ptp([float(v) for v in x]) > 300


def test_an_svg_is_the_same_from_run_to_run(tmp_path: Path) -> None:
    for name in ("a.svg", "b.svg"):
        film(ROOT / "models/heavy_top.lag", "--seconds", 2, "-o", tmp_path / name)
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()
    assert b'calcMode="discrete"' in (tmp_path / "a.svg").read_bytes()


SHAPES = """model shapes
coord x, z
rotation R
kinetic (x'^2 + z'^2)/2 + dot(omega(R), omega(R))/2
potential x^2/2 + z^2
start x = 1, omega(R) = [1, 0.3, 0]
let P = [x, 0, z]
draw ground z = -2
draw spring from O to P turns 5
draw line from O to P
draw circle P radius 0.3
draw arrow [0, 0, x'] at P scale 1
draw trail P lasting 1
draw trail [z, 0, x]
draw bob P
draw body R at [0, 2, 0] box [1, 0.6, 0.3]
draw body R at [2, 2, 0] cylinder [0.3, 1]
draw body R at [-2, 2, 0] ellipsoid [0.5, 0.3, 0.2]
draw body R at [0, -2, 0] disk [0.5, 0.1]
draw body R at [2, -2, 0] top [0.4, 0.8]
view space
"""


def test_all_shapes(tmp_path: Path, write) -> None:
    out = tmp_path / "film.svg"
    found = film(write(SHAPES), "--until", 2, "--no-labels", "-o", out)
    root = ElementTree.parse(out).getroot()
    animated = [*root.iter(f"{NS}animate")]
    counts = {len(a.get("values").split(";")) for a in animated}
    assert counts == {found["frames"]} and len(animated) > 100
    assert "stroke-dasharray" in {a.get("attributeName") for a in animated}
    assert "nan" not in out.read_text()
    assert film(write(SHAPES), "--until", 1, "--fps", 4, "-o", tmp_path / "film.gif")["frames"] > 2


def test_a_swarm_is_a_cloud(tmp_path: Path) -> None:
    """Members, evenly chosen, go as each by itself does."""
    out = tmp_path / "cloud.svg"
    words = ("--scene", "all_amplitudes", "--until", 2, "--seconds", 2, "--fps", 11)
    found = film(PENDULUM, *words, "-o", out)
    root = ElementTree.parse(out).getroot()
    discs = [*root.iter(f"{NS}circle")]
    assert found["frames"] == 22 and len(discs) == 143  # each seventh of 1000
    assert {"θ [rad]", "θ′ [rad/s]", "pendulum, all amplitudes"} <= {
        t.text for t in root.iter(f"{NS}text")
    }

    def way(disc: ElementTree.Element) -> numpy.ndarray:
        (values,) = (
            a.get("values") for a in disc.iter(f"{NS}animate") if a.get("attributeName") == "cx"
        )
        return numpy.array(values.split(";"), float)

    def first(disc: ElementTree.Element, name: str) -> float:
        return float(disc.get(name))

    assert len({first(disc, "cy") for disc in discs}) == 1  # all are at rest
    starts = numpy.array([first(disc, "cx") for disc in discs])
    assert numpy.diff(starts) == pytest.approx(numpy.diff(starts).mean(), abs=0.11)
    near, far = way(discs[0]), way(discs[-1])
    assert len(near) == 22 and numpy.ptp(far) > 300 > 10 > numpy.ptp(near)
    gif = film(PENDULUM, *words, "-o", tmp_path / "cloud.gif")
    assert gif["frames"] == 22


def test_models_without_places(tmp_path: Path, write) -> None:
    """Coordinates over time."""
    model = write(
        "model plain\ncoord a, b\nkinetic a'^2 + b'^2\npotential a^2 + 2*b^2\nstart a = 1\n"
    )
    assert film(model, "-o", tmp_path / "film.svg")["frames"] == 200


def test_a_motion_that_ends_early_is_shown_as_far_as_it_came(tmp_path: Path, write) -> None:
    model = write(
        "model fall\ncoord x [m]\nkinetic (1 [kg])*x'^2/2\npotential -(1 [J*m])/x\nstart x = 1\n"
    )
    found = film(model, "--until", 10, "-o", tmp_path / "film.svg", code=4)
    assert 10 < found["frames"] < 40 and (tmp_path / "film.svg").exists()


def test_an_event_that_stops_ends_it(tmp_path: Path) -> None:
    words = ("--until", 4, "--start", "theta'=8", "-o", tmp_path / "film.svg")
    assert film(PENDULUM, *words)["frames"] == 80


def test_how_long_it_takes(tmp_path: Path) -> None:
    out = tmp_path / "film.svg"
    for words, seconds in (
        (("--until", 4), 4),
        (("--until", 1), 10),
        (("--until", 100), 10),
        (("--until", 100, "--seconds", 3), 3),
    ):
        found = film(PENDULUM, *words, "-o", out)
        assert found["seconds"] == pytest.approx(seconds) and found["frames"] == 20 * seconds


WRONG = [
    (("-o", "film.avi"), "must end in .mp4, .webm, .gif or .svg"),
    (("-o", "film"), "must end in"),
    ((), "-o"),
    (("-o", "x.svg", "--pixels", "33x33"), "--pixels 33x33"),
    (("-o", "x.svg", "--pixels", "big"), "--pixels big"),
    (("-o", "x.svg", "--pixels", "321x240"), "even"),
    (("-o", "x.svg", "--fps", "0"), "--fps 0: must be positive"),
    (("-o", "x.svg", "--fps", "nan"), "--fps nan: must be positive"),
    (("-o", "x.svg", "--seconds", "-1"), "--seconds -1: must be positive"),
    (("-o", "x.svg", "--seconds", "99999", "--fps", "60"), "100,000 at most"),
    (("-o", "x.svg", "--scene", "loopp"), "did you mean 'loop'"),
    (("-o", "x.svg", "--pixel", "640x480"), "did you mean '--pixels'"),
    (
        (
            "-o",
            "no/x.svg",
        ),
        "no/x.svg",
    ),
]


@pytest.mark.parametrize("words, said", WRONG, ids=[" ".join(w) for w, _ in WRONG])
def test_wrong_options(words: tuple, said: str, tmp_path: Path) -> None:
    done = run_pkgen("film", PENDULUM, *words, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "") and said in done.stderr, done.stderr
    assert [*tmp_path.iterdir()] == []


def test_without_ffmpeg_it_says_so(tmp_path: Path) -> None:
    tools = tmp_path / "bin"
    tools.mkdir()
    for name in ("gcc", "cc", "as", "ld", "ar", "gsl-config"):  # the runtime is that of others
        if shutil.which(name):
            (tools / name).symlink_to(shutil.which(name))
    env = {**os.environ, "PATH": str(tools)}
    done = run_pkgen("film", PENDULUM, "-o", "x.mp4", cwd=tmp_path, env=env)
    assert done.returncode == 2 and "ffmpeg, which is not here" in done.stderr
    done = run_pkgen("film", PENDULUM, "-o", "x.gif", "--fps", 4, cwd=tmp_path, env=env)
    assert done.returncode == 0, done.stderr


@FFMPEG
def test_what_ffmpeg_says_is_passed_on(tmp_path: Path) -> None:
    tools = tmp_path / "bin"
    tools.mkdir()
    broken = tools / "ffmpeg"
    broken.write_text("#!/bin/sh\necho 'no such codec' >&2\nexit 3\n")
    broken.chmod(0o755)
    env = {**os.environ, "PATH": f"{tools}:{os.environ['PATH']}"}
    done = run_pkgen("film", PENDULUM, "-o", "x.mp4", cwd=tmp_path, env=env)
    assert done.returncode == 3 and "ffmpeg: no such codec" in done.stderr
    assert not (tmp_path / "x.mp4").exists()


def test_names_are_text(tmp_path: Path, write) -> None:
    """In a path of TeX and a title of SVG."""
    model = write(SWINGS.replace("model swings", "model a_b"))
    film(model, "--seconds", 1, "-o", tmp_path / "film.svg")
    root = ElementTree.parse(tmp_path / "film.svg").getroot()
    texts = [t.text for t in root.iter(f"{NS}text")]
    assert [t for t in texts if not t.startswith("t = ")] == ["a b", "P"]


def test_labels_of_vectors(tmp_path: Path) -> None:
    """Title, a clock of which one text is seen at a time, and names that go with their bobs."""
    out = tmp_path / "film.svg"
    film(DOUBLE, "--seconds", 5, "--until", 5, "-o", out)
    root = ElementTree.parse(out).getroot()
    texts = {t.text: t for t in root.iter(f"{NS}text")}
    assert {"double pendulum", "upper bob", "lower bob", "t = 0.0 s", "t = 1.2 s"} <= texts.keys()
    (seen,) = texts["t = 1.2 s"].iter(f"{NS}animate")
    assert (seen.get("keyTimes"), seen.get("dur")) == ("0;0.24;0.26", "5s")
    assert seen.get("values") == "hidden;visible;hidden"
    visible = [t for t, e in texts.items() if e.get("visibility") == "visible"]
    assert visible == ["t = 0.0 s"]  # without SMIL
    x = next(a for a in texts["lower bob"] if a.get("attributeName") == "x").get("values")
    ways = [a for a in root.iter(f"{NS}animate") if a.get("attributeName") == "cx"]
    offs = [
        numpy.array(x.split(";"), float) - numpy.array(w.get("values").split(";"), float)
        for w in ways
    ]
    assert min(numpy.ptp(off) for off in offs) < 0.25
    film(DOUBLE, "--seconds", 5, "--until", 5, "--no-labels", "-o", out)
    assert [*ElementTree.parse(out).getroot().iter(f"{NS}text")] == []


def test_labels_of_pixels(tmp_path: Path) -> None:
    """Names move with what they name; without labels nothing is left of them."""

    def frames(*words: str) -> numpy.ndarray:
        out = tmp_path / "film.gif"
        film(DOUBLE, "--seconds", 2, "--fps", 5, "--pixels", "480x270", *words, "-o", out)
        with Image.open(out) as picture:
            made = []
            for k in range(picture.n_frames):
                picture.seek(k)
                made.append(numpy.asarray(picture.convert("L")).astype(int))
        return numpy.array(made)

    differ = numpy.abs(frames() - frames("--no-labels")) > 60
    corner = differ[:, :40, :200].any(axis=0), differ[:, -40:, :200].any(axis=0)
    assert all(c.sum() > 100 for c in corner)  # the title above, the time below
    names = differ[:, 40:-40, 100:]
    assert all(20 < frame.sum() < 1500 for frame in names)
    assert (names[0] & names[-1]).sum() < 0.5 * names[0].sum()


def test_a_graph_grows_beside_the_motion(tmp_path: Path, write) -> None:
    """The point at its end goes as the column does, from the left to the right."""
    model, out = write(SWINGS), tmp_path / "film.svg"
    film(model, "--until", 2, "--fps", 10, "--beside", "theta'", "-o", out)
    circles = ElementTree.parse(out).getroot().findall(f".//{NS}circle")
    moves = [{a.get("attributeName"): a.get("values") for a in c} for c in circles]
    (x, y) = (numpy.array(moves[-1][name].split(";"), float) for name in ("cx", "cy"))
    done = run_pkgen("run", model, "--until", 2, "--every", 2 / 19)
    rate = numpy.array([float(line.split(",")[2]) for line in done.stdout.splitlines()[1:]])
    assert numpy.ptp(numpy.diff(x)) < 0.3 and 960 * 0.6 < x[0] < x[-1] < 960
    slope, offset = numpy.polyfit(rate, y, 1)
    assert slope < 0 and numpy.abs(slope * rate + offset - y).max() < 0.1
    done = run_pkgen("film", model, "--beside", "thet", "-o", out)
    assert done.returncode == 2 and "did you mean 'theta'" in done.stderr
