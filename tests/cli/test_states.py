"""`state` and `rate` at the command line: rows, starts, options, other commands."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

# Of an orbit from its pericentre: the action of a revolution is that of T - V, whose means are a
# half and 1 by the virial theorem, and the area is that of the ellipse.
ORBIT = """\
model orbit
param e = 0.6 in [0, 1)
coord x, y
state S         # action
state area
kinetic (x'^2 + y'^2)/2
potential -1/sqrt(x^2 + y^2)
rate S = L
rate area = (x*y' - y*x')/2
start x = 1 - e, y' = sqrt((1 + e)/(1 - e))
observe energies = T + V
event half: S - 3*pi/2

scene revolution
  until  2*pi
  method gauss rtol 1e-12
  record S, S', area, x every pi
  expect S = 3*pi within 1e-9 at 2*pi
  expect area = pi*sqrt(1 - e^2) within 1e-9 at 2*pi
  expect S' - L = 0 within 1e-14
  expect time(half) > 3.1415
  expect drift(energy) < 1e-10
end

scene still
  hold   S = sin(t)
  start  area = 2
  until  1
  method rk4 step 0.001
  record S, S', area every 1
end

scene many
  swarm  k = 1..3
  start  area = k
  until  1
  method rk4 step 0.01
  record area
end
"""
# Its sums of logarithms are constant; no coordinate, so no energy.
LOTKA = """\
model lotka
param a = 2/3
state hare, lynx
rate hare = a*hare - 4/3*hare*lynx
rate lynx = hare*lynx - lynx
start hare = 1, lynx = 2
conserve H = hare - log(hare) + 4/3*lynx - a*log(lynx)
"""


@pytest.fixture
def orbit(tmp_path: Path) -> Path:
    return written(tmp_path, ORBIT)


def written(folder: Path, text: str) -> Path:
    path = folder / f"{text.split()[1]}.lag"
    path.write_text(text, encoding="utf-8")
    return path


def rows(text: str) -> tuple[list[str], list[list[float]]]:
    head, *lines = text.splitlines()
    return head.split(","), [[float(x) for x in line.split(",")] for line in lines]


def test_the_action_of_a_revolution(pkgen, orbit: Path) -> None:
    done = pkgen("run", orbit, "--scene", "revolution", "--json")
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    assert [c["name"] for c in said["columns"]] == ["t", "S", "S'", "area", "x"]
    _, half, end = said["rows"]
    assert half[1] == pytest.approx(1.5 * math.pi, abs=1e-9) and end[4] == pytest.approx(0.4)
    assert len(said["report"]["q"]) == 2 and len(said["report"]["v"]) == 4


def test_columns_in_the_order_of_the_language(pkgen, orbit: Path) -> None:
    """Coordinates, rates, states, observed names, energy; starts by the option."""
    done = pkgen("run", orbit, "--until", "1", "--every", "1", "--start", "area=0.25")
    head, (first, _) = rows(done.stdout)
    assert head == ["t", "x", "y", "x'", "y'", "S", "area", "energies", "energy"]
    assert first[5:7] == [0, 0.25]


@pytest.mark.long
def test_states_alone_have_no_energy(pkgen, tmp_path: Path) -> None:
    model = written(tmp_path, LOTKA)
    done = pkgen("run", model, "--until", "20", "--every", "10", "--json", "--start", "lynx=1.5")
    said = json.loads(done.stdout)
    assert [c["name"] for c in said["columns"]] == ["t", "hare", "lynx"]
    assert [len(row) for row in said["rows"]] == [3, 3, 3] and said["rows"][0][2] == 1.5
    (drift,) = said["report"]["drifts"]
    assert drift["name"] == "H" and 0 < drift["max"] < 1e-8


WRONG = [
    ("run --start area'=1", "area is a state, and its rate follows: --start area=…"),
    ("run --start sarea=1", "did you mean 'area'?"),
    ("run --record p_S", "no such column"),
    ("run --scene still --start S=1", "the scene holds S"),
    ("stability", "orbit.lag:4:7: the model has states (S, area), and 'pkgen stability' maps"),
]


@pytest.mark.parametrize(("words", "said"), WRONG, ids=[words for words, _ in WRONG])
def test_what_cannot_be(pkgen, orbit: Path, words: str, said: str) -> None:
    command, *options = words.split()
    done = pkgen(command, orbit, *options)
    assert done.returncode == 2 and said in done.stderr and "Traceback" not in done.stderr


def test_an_energy_that_there_is_not(pkgen, tmp_path: Path) -> None:
    done = pkgen("run", written(tmp_path, LOTKA), "--record", "energy")
    assert done.returncode == 2 and "it has: hare, lynx" in done.stderr
    model = written(tmp_path, LOTKA + "scene s\n  until 1\n  record energy\nend\n")
    done = pkgen("check", model)
    assert done.returncode == 1 and "a model of states alone has no energy" in done.stderr


def test_an_energy_of_held_coordinates(pkgen, tmp_path: Path) -> None:
    scene = "scene s\n  hold q = sin(t)\n  until 1\n  record x, {}\nend\n"
    text = "model m\ncoord q\nstate x\nkinetic q'^2/2\nrate x = q'\n" + scene
    done = pkgen("check", written(tmp_path, text.format("energy")))
    assert done.returncode == 1
    assert "m.lag:9:13: error: there is no energy here: every coordinate is held" in done.stderr
    assert pkgen("check", written(tmp_path, text.format("T"))).returncode == 0


@pytest.mark.long
def test_explained(pkgen, orbit: Path, tmp_path: Path) -> None:
    said = pkgen("explain", orbit).stdout
    assert "2 degrees of freedom, 2 states" in said and "\n  area' = x*y'/2 - x'*y/2\n" in said
    assert "x*p_y - y*p_x" in said  # symmetries are still searched for: S moves nothing
    told = json.loads(pkgen("explain", orbit, "--json").stdout)
    assert [s["name"] for s in told["states"]] == ["S", "area"]
    page = tmp_path / "page.html"
    model = written(tmp_path, LOTKA)
    assert pkgen("explain", model, "--html", page).returncode == 0
    lotka = pkgen("explain", model).stdout
    assert "2 states\n" in lotka and "Lagrangian" not in lotka and "mass matrix" not in lotka
    assert "Rates of the states" in page.read_text(encoding="utf-8")


@pytest.mark.long
def test_held_and_many(pkgen, orbit: Path, tmp_path: Path) -> None:
    done = pkgen("run", orbit, "--scene", "still")
    head, (_, last) = rows(done.stdout)
    assert head == ["t", "S", "S'", "area"] and done.returncode == 0
    swept = math.sqrt(1 - 0.36) / 2
    assert last[1:] == pytest.approx([math.sin(1), math.cos(1), 2 + swept], abs=1e-9)
    head, found = rows(pkgen("run", orbit, "--scene", "many").stdout)
    assert head == ["k", "t", "area"]
    assert [row[2] for row in found] == pytest.approx([k + swept for k in (1, 2, 3)], abs=1e-5)
    table = tmp_path / "members.csv"
    table.write_text("area,x'\n1,0\n5,0.1\n")
    done = pkgen("run", orbit, "--ensemble", table, "--until", "1", "--record", "area")
    assert [row[2] for row in rows(done.stdout)[1]] == pytest.approx([1.4, 5.4], abs=0.1)


@pytest.mark.long
def test_the_chart_has_states(pkgen, tmp_path: Path) -> None:
    model = written(tmp_path, LOTKA)
    done = pkgen(
        "chart", model, "--until", "5", "--quick", "--methods", "rk4,gauss,radau,verlet",
        "-o", tmp_path, "--json",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "verlet" in json.loads(done.stdout)["refused"]


DECAY = """\
model decay
state u [K]
param tau = 1 [min]
rate u = -u/tau
start u = 300 [K]
let closed = (300 [K])*exp(-t/tau)
scene cold
  until 10 [min]
  {}
  record u every 1 [min]
  expect u = closed within 3e-6 [K]
end
"""


@pytest.mark.long
@pytest.mark.parametrize("how", ["accuracy 1e-8", "method radau rtol 1e-8", "method exponential"])
def test_an_accuracy_is_kept_by_a_state(pkgen, tmp_path: Path, how: str) -> None:
    done = pkgen("run", written(tmp_path, DECAY.format(how)), "--scene", "cold")
    assert done.returncode == 0, done.stderr


LORENZ = """\
model lorenz
param s = 10
param r = 28
param b = 8/3
state x, y, z
rate x = s*(y - x)
rate y = x*(r - z) - y
rate z = x*y - b*z
start x = 1, y = 1, z = 1
"""


@pytest.mark.long
@pytest.mark.parametrize(("method", "order"), [("euler", 1), ("rk2", 2), ("rk3", 3), ("rk4", 4)])
def test_order_on_lorenz(pkgen, tmp_path: Path, method: str, order: int) -> None:
    """Of steps that the compiler has put together with the model."""
    model, at = written(tmp_path, LORENZ), ("--until", "0.5", "--every", "0.5")

    def end(*how: str) -> list[float]:
        return rows(pkgen("run", model, *at, *how).stdout)[1][-1]

    exact = end("--method", "gauss", "--rtol", "1e-14")
    steps = [0.5 / n for n in (4000, 8000)] if order < 3 else [0.5 / n for n in (400, 800)]
    first, second = (
        max(
            abs(a - b)
            for a, b in zip(end("--method", method, "--step", f"{h!r}"), exact, strict=True)
        )
        for h in steps
    )
    assert second > 1e-11 and abs(math.log2(first / second) - order) < 0.1


# H. H. Robertson (1966), at t = 40 from the manual of CVODE, at 1e11 from E. Hairer, G. Wanner's
# set of problems.
ROBERTSON = """\
model robertson
state A, B, C
rate A = -0.04*A + 1.0e4*B*C
rate B = 0.04*A - 1.0e4*B*C - 3.0e7*B^2
rate C = 3.0e7*B^2
start A = 1
conserve sum_of_all = A + B + C
"""


@pytest.mark.long
def test_a_stiff_reaction(pkgen, tmp_path: Path) -> None:
    model = written(tmp_path, ROBERTSON)
    radau = ("--method", "radau", "--rtol", "1e-9", "--atol", "1e-16")
    done = pkgen("run", model, "--until", "1e11", "--every", "1e11", *radau, "--json")
    said = json.loads(done.stdout)
    expected = [0.2083340149701255e-07, 0.8333360770334713e-13, 0.9999999791665050]
    assert said["rows"][-1][1:] == pytest.approx(expected, rel=1e-6)
    assert said["report"]["steps"] < 3000
    done = pkgen("run", model, "--until", "40", "--every", "40", *radau)
    assert rows(done.stdout)[1][-1][1:] == pytest.approx([0.71582, 9.1855e-6, 0.28417], rel=1e-4)


DIFFUSION = """\
model diffusion
size N = 9
param D = 1 [m^2/s] in (0, inf)
param dx = 0.1 [m]
state c[1..N] [1/m^3]
fixed c[0] = 0, c[N+1] = 0
rate c[i = 1..N] = D/dx^2*(c[i+1] - 2*c[i] + c[i-1])
start c[i = 1..N] = sin(pi*i/(N+1)) [1/m^3]

scene between
  hold   c[1] = 1, c[N]
  until  2 [s]
  method radau rtol 1e-9
  record c[1], c[2], c[8], c[9] every 2 [s]
end
"""


@pytest.mark.long
@pytest.mark.parametrize("how", [("exponential",), ("radau", "--rtol", "1e-9")])
def test_a_chain_of_states(pkgen, tmp_path: Path, how: tuple[str, ...]) -> None:
    """A mode of the chain decays by 4 D/dx^2 sin^2(pi/(2 (N + 1)))."""
    model = written(tmp_path, DIFFUSION)
    assert "unrolled: a model with states" in pkgen("explain", model).stdout
    run = ("run", model, "--until", "0.05", "--every", "0.05", "--method", *how)
    head, (first, last) = rows(pkgen(*run, "--start", "c[9]=0.30901699437494745").stdout)
    assert head == ["t", *(f"c[{i}]" for i in range(1, 10))]
    left = math.exp(-0.05 * 400 * math.sin(math.pi / 20) ** 2)
    assert left < 0.7
    assert last[1:] == pytest.approx([left * c for c in first[1:]], rel=1e-8)
    _, (_, last) = rows(pkgen("run", model, "--scene", "between").stdout)
    end = math.sin(0.9 * math.pi)  # straight between what is held
    straight = [1 - (1 - end) * i / 8 for i in (0, 1, 7, 8)]
    assert last[1:] == pytest.approx(straight, abs=1e-7)


ROCKET = """\
model rocket
param u = 2000 [m/s]
param k = 3 [kg/s]
param g = 9.81 [m/s^2]
coord z [m]
state m [kg]
kinetic m/2*z'^2
potential m*g*z
force z = k*(u - z')  # what leaves takes its momentum along
rate m = -k
start m = 100
let closed = u*log((100 [kg])/m) - g*t
observe off = z' - closed
"""


@pytest.mark.long
@pytest.mark.parametrize(
    "how", [("rk4", "--step", "0.01"), ("gauss4", "--step", "0.1"), ("radau", "--rtol", "1e-10")]
)
def test_a_mass_that_is_a_state(pkgen, tmp_path: Path, how: tuple[str, ...]) -> None:
    """K. E. Tsiolkovsky (1903)."""
    run = ("run", written(tmp_path, ROCKET), "--until", "20", "--every", "10", "--method", *how)
    head, (*_, last) = rows(pkgen(*run).stdout)
    end = dict(zip(head, last, strict=True))
    assert end["z'"] > 1600 and end["m"] == pytest.approx(40)
    assert abs(end["off"]) < 1e-6
