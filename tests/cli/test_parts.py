"""Parts: what the page about them shows, files that they may be, names in commands and exports."""

import json
import os
import re
from pathlib import Path

import pytest

import pkgen as api
from conftest import ROOT, ran, run_pkgen
from pkgen.compiler import check_model, compile_model
from pkgen.front.read import read, with_parts
from pkgen.source import ModelError, Source

PAGE = (ROOT / "docs/parts.md").read_text(encoding="utf-8")
MOTORS = ROOT / "models/parts/two_motors.lag"
TRAIN = ROOT / "models/parts/train.lag"
WRONG = ROOT / "tests/generator/wrong/parts"
PART = """model mass
param m = 1 [kg] in (0, inf)
input F [N]
coord x [m]
kinetic m/2*x'^2
force x = F
observe p = p_x
event middle: x rising
start x' = 1
scene thrown
  set F = -1 [N]
  start x' = 2
  until 1
  method gauss rtol 1e-10
  record x, p every 0.5
  expect x < 0 [m]
end
"""


def written(folder: Path, text: str, part: str = PART) -> Path:
    (folder / "mass.lag").write_text(part)
    path = folder / "whole.lag"
    path.write_text(text)
    return path


def wrong(path: Path) -> str:
    with pytest.raises(ModelError) as caught:
        check_model(read(path))
    return caught.value.text()


def test_the_page_shows_what_is_there() -> None:
    found = re.findall(r"^```(\w*)\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
    blocks = [text for language, text in found if not language]
    assert len(blocks) == 5
    shown = "".join(
        path.read_text() for path in [MOTORS, *WRONG.glob("*.lag"), *WRONG.glob("*.txt")]
    )
    for block in blocks:
        for line in block.splitlines():
            assert line in shown, line


def test_names_in_commands(tmp_path: Path) -> None:
    path = written(
        tmp_path, 'model whole\nuse "mass.lag" as one with m = 2\nset one.F = 3 [N/s]*t\n'
    )
    done = ran("run", path, "--until", "2", "--every", "1", "--method", "gauss", "--rtol", "1e-12")
    assert done.stdout.splitlines()[0] == "t,one.x,one.x',one.p,energy"
    options = [
        "--set",
        "one.m=4",
        "--start",
        "one.x=5",
        "--record",
        "one.p_x,one.x",
        "--at",
        "one.middle",
    ]
    more = ran("run", path, "--until", "2", "--every", "2", "--method", "gauss", *options)
    rows = [[*map(float, row.split(","))] for row in more.stdout.splitlines()[1:]]
    assert rows[0] == [0, 4, 5]
    assert rows[-1] == pytest.approx([2, 4 + 3 * 2, 5 + 2 + 3 / 4 * 8 / 6], rel=1e-9)
    told = json.loads(ran("describe", path, "--json").stdout)
    assert [(c["name"], c["momentum"]) for c in told["coordinates"]] == [("one.x", "one.p_x")]
    assert told["scenes"] == []


def test_a_scene_of_a_part_runs_the_whole(tmp_path: Path) -> None:
    text = 'model whole\nuse "mass.lag" as one\nuse "mass.lag" as two\n'
    path = written(tmp_path, text + "potential (2 [N/m])*(one.x - two.x)^2/2\n")
    done = ran("run", path, "--scene", "two.thrown", "-o", tmp_path / "rows.csv")
    assert (tmp_path / "rows.csv").read_text().startswith("t,two.x,two.p\n0,0,2\n")
    assert "expected" not in done.stderr
    # The sum moves as one mass of 2 kg does, and one.x' begins with 1.
    found = api.load(path, scene="two.thrown").run(record=["one.x", "two.x"])
    assert found["one.x"][-1] + found["two.x"][-1] == pytest.approx(3 - 1 / 2, rel=1e-9)
    assert api.load(path).scenes == ()
    path.write_text(text + "set two.F = 1 [N]\n")
    said = run_pkgen("run", path, "--scene", "two.thrown").stderr
    assert "mass.lag:11:7: error: 'two.u'" not in said and "mass.lag:11:7: error: 'two.F'" in said
    assert f"is set already, at {path}:4:5" in said and f"used at {path}:3:1 as two" in said
    ran("check", path)


def test_a_signal_may_come_later(tmp_path: Path) -> None:
    part = PART.replace("observe", "let y = (F + x*(1 [N/m]))*(1 [m/N])\nobserve")
    text = 'model whole\nuse "mass.lag" as one\nuse "mass.lag" as two\nuse "mass.lag" as three\n'
    text += "set one.F = two.y*(2 [N/m])\n"
    text += "set two.F = three.y*(3 [N/m]), three.F = sin(t*(1 [1/s]))*(1 [N])\n"
    model = api.load(written(tmp_path, text, part))
    q = [0.3, 0.5, 0.7]
    three = 0.8414709848078965
    two = 3 * (three + q[2])
    one = 2 * (two + q[1])
    assert model.acceleration(q, [0, 0, 0], 1.0) == pytest.approx([one, two, three], rel=1e-14)


def test_inputs_that_remain(tmp_path: Path) -> None:
    part = PART.replace("input F [N]", "input F, G, H [N]").replace("x = F", "x = F + 2*G + 4*H")
    path = written(tmp_path, 'model whole\nuse "mass.lag" as one\nset one.F = one.G/8\n', part)
    model = api.load(path)
    assert model.inputs == ("one.G", "one.H")
    assert model.acceleration([0], [0], u=[1, 10]).tolist() == [42.125]
    options = [
        "--set",
        "one.H=t*(1 [N/s])",
        "--set",
        "one.G=8",
        "--method",
        "gauss",
        "--every",
        "1",
    ]
    done = ran("run", path, "--until", "1", *options, "--rtol", "1e-12", "--record", "one.p,one.F")
    assert [*map(float, done.stdout.split()[-1].split(","))] == pytest.approx([1, 1 + 17 + 2, 1])


def test_gravity_is_of_each_file(tmp_path: Path) -> None:
    arm = "model mass\nbody arm mass 2 [kg]\njoint slide: ground to arm prismatic [0, 0, 1]\n"
    uses = 'model whole\nuse "mass.lag" as one\nuse "other.lag" as two\n'
    uses += 'use "deep.lag" as three\ngravity [0, 0, -3]\n'
    (tmp_path / "deep.lag").write_text('model deep\nuse "mass.lag" as in1\ngravity [0, 0, -7]\n')
    (tmp_path / "other.lag").write_text(arm + "gravity [0, 0, -5]\n")
    model = api.load(written(tmp_path, uses, arm))
    assert model.acceleration([0, 0, 0], [0, 0, 0]).tolist() == [-3, -5, -7]


def test_the_digest_and_the_cache_see_a_change(tmp_path: Path) -> None:
    path = written(tmp_path, 'model whole\nuse "mass.lag" as one\n')
    before, model = read(path).sha256, api.load(path)
    assert model.run(1.0, method="gauss")["one.p"][-1] == pytest.approx(1)
    written(tmp_path, path.read_text(), PART.replace("m = 1 [kg]", "m = 3 [kg]"))
    assert read(path).sha256 != before
    assert model.run(1.0, method="gauss")["one.p"][-1] == pytest.approx(3)


def test_files_stay_in_their_folder(tmp_path: Path) -> None:
    (tmp_path / "secret.lag").write_text("model secret\nprivate words\n")
    inner = tmp_path / "inner"
    (inner / "deeper").mkdir(parents=True)
    (inner / "link.lag").symlink_to(tmp_path / "secret.lag")
    (inner / "deeper/up.lag").write_text('model up\nuse "../mass.lag" as back\n')
    names = "link.lag", "../secret.lag", "deeper/up.lag"
    for name in (*names, str(tmp_path / "secret.lag"), str(inner / "mass.lag")):
        said = wrong(written(inner, f'model whole\nuse "{name}" as one\n'))
        assert "private" not in said
        assert "lies outside of the folder" in said or "no such file" in said, name
    os.mkfifo(inner / "pipe.lag")
    assert "not a regular file" in wrong(written(inner, 'model whole\nuse "pipe.lag" as one\n'))


def test_the_number_of_parts_is_bounded(tmp_path: Path) -> None:
    lines = [f'use "next{{}}.lag" as a{k}' for k in range(10)]
    for level in range(4):
        text = "\n".join([f"model next{level}", *lines, ""]).format(*[level + 1] * 10)
        (tmp_path / f"next{level}.lag").write_text(text)
    (tmp_path / "next4.lag").write_text("model next4\n")
    assert "more than 1,000 parts" in wrong(tmp_path / "next0.lag")
    for level in range(40):
        (tmp_path / f"n{level}.lag").write_text(f'model n\nuse "n{level + 1}.lag" as part\n')
    assert "characters; the limit is 63" in wrong(tmp_path / "n0.lag")


def test_old_words_remain_names() -> None:
    text = "model m\nparam use = 2 [kg]\ncoord as, with [m]\nlet part = (as +\n with)\n"
    text += "kinetic use/2*(as'^2 + with'^2)\npotential (1 [N])*(part +\nuse*(1 [m/kg]))\n"
    model, _ = check_model(Source("m.lag", text))
    assert [c.name for c in model.coordinates] == ["as", "with"]


def test_c_has_underscores() -> None:
    files = compile_model(read(TRAIN)).files
    text = "".join(files.values())
    assert "car10_x" in text and "p->car3_c" in text
    assert with_parts(Source("m.lag", "model m\n")).text == "model m\n"


def test_options_make_no_part(tmp_path: Path) -> None:
    """Clauses from the command line are a piece of the text, and no part."""
    path = tmp_path / "m.lag"
    body = "body arm mass 2 [kg]\njoint slide: ground to arm prismatic [0, 0, 1]\n"
    path.write_text(f"model m\n{body}let arm_com = 3 [m]\npotential arm_com*(1 [N])\n")
    ran("run", path, "--until", "1", "--record", "arm.com", "-o", tmp_path / "rows.csv")
    assert Source("m.lag", "model m\n").with_options("s", ["until 1"]).parts == frozenset()


def test_parameters_follow_each_other(tmp_path: Path) -> None:
    text = 'model whole\nparam a = 2 [kg]\nuse "mass.lag" as one with m = 2*a\n'
    text += "param T = one.m*(1 [s/kg]) in (0, 5)\n"
    text += "scene s\n  until T\n  method gauss rtol 1e-9\n  record one.p\nend\n"
    path = written(tmp_path, text)
    for given, end, p in (([], "4", 4), (["one.m=3"], "3", 3), (["a=1"], "2", 2)):
        options = [x for text in given for x in ("--set", text)]
        done = ran("run", path, "--scene", "s", *options, "--every", "1")
        assert done.stdout.splitlines()[-1] == f"{end},{p}"
    path.write_text(text.replace("(0, 5)", "(0, 3)"))
    assert "the default of T is outside its bounds: 4 [s]" in wrong(path)
    assert "never used" not in ran("check", written(tmp_path, text)).stderr


def test_numbers_of_a_scene_of_a_part_are_checked(tmp_path: Path) -> None:
    part = PART.replace("  until 1\n", "  set m = -1\n  until 1\n")
    path = written(tmp_path, 'model whole\nuse "mass.lag" as one\n', part)
    ran("check", path)
    said = run_pkgen("run", path, "--scene", "one.thrown")
    assert said.returncode == 1
    assert "mass.lag:13:7: error: one.m is set outside its bounds: -1 [kg]" in said.stderr


def test_a_table_of_a_part_lies_beside_it(tmp_path: Path) -> None:
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub/road.csv").write_text("x,y\n0,0\n1,2\n2,6\n", encoding="utf-8")
    (tmp_path / "sub/part.lag").write_text(
        'model part\ntable road = "road.csv" x, y linear\ncoord x\nkinetic x\'^2/2\n'
        "force x = road(t)\n",
        encoding="utf-8",
    )
    path = tmp_path / "user.lag"
    path.write_text(
        'model user\nuse "sub/part.lag" as left\ncoord z\nkinetic z\'^2/2\n'
        "force z = 2*left.road(1.5)\n",
        encoding="utf-8",
    )
    m = api.load(path)
    assert m.acceleration([0, 0], [0, 0], 1.5).tolist() == [4, 8]
    assert [*m.tables] == ["left.road"]
