"""MJCF: default classes, springs, armature, masses of geoms, settings, includes."""

from __future__ import annotations

import importlib
import random
from argparse import Namespace

import numpy as np
import pytest
from random_states import state_of
from robot_files import text_of
from solids import cloud, moved, summed
from trees_of_bodies import Link, Motion, of_quaternion, turn

from pkgen import limits
from pkgen.front.check.check import check_text
from pkgen.graph.evaluate import evaluate
from pkgen.middle.derive.derive import derive
from pkgen.source import Source
from pkgen_robots.read import imported
from pkgen_robots.shapes import volume_and_moments

X, Y, Z = np.eye(3)
BALL = "<worldbody><body><joint/>{}</body></worldbody>"


@pytest.mark.parametrize("kind, size", [
    ("sphere", [0.7]), ("ellipsoid", [0.3, 0.5, 0.8]), ("box", [0.3, 0.5, 0.8]),
    ("cylinder", [0.3, 0.8]), ("capsule", [0.3, 0.8]),
])  # fmt: skip
def test_shapes(kind, size):
    volume, moments = volume_and_moments(kind, size)
    mass, _, inertia = summed(cloud(kind, size))
    assert abs(volume - mass) < 1e-13 * mass
    assert abs(np.diag(moments) - inertia / mass).max() < 1e-13


ROBOT = """<mujoco><compiler eulerseq="zYx"/>
<default><joint armature="0.1" damping="0.2" stiffness="3" springref="20"/><geom density="500"/>
<default class="way"><joint type="slide" axis="3 0 4" armature="0.3" springref="0.2"/>
<geom type="capsule" size="0.1 0.3" euler="0 90 0"/></default></default>
<worldbody><body name="a" pos="0.1 0.2 0.3" euler="10 20 30">
<joint name="h" axis="0 1 0" pos="0 0 0.1" ref="30"/><geom type="box" size="0.1 0.2 0.3"
 pos="0 0.1 0" axisangle="1 2 3 40"/><geom class="way" fromto="0 0 0 0.3 0.4 0" mass="2"/>
<body name="b" pos="0 0 0.5" xyaxes="1 1 0 0 1 0" childclass="way"><joint name="s" ref="0.5"/>
<joint class="main" name="k" stiffness="0" pos="0 0.1 0"/>
<geom size="0.2" zaxis="1 0 1"/><geom type="cylinder" group="6"/>
<body name="c" pos="0.1 0 0"><joint name="r" class="main" type="ball" stiffness="0"/>
<geom type="ellipsoid" size="0.2 0.3 0.4"/></body></body></body>
<body name="d" pos="1 2 3" quat="0.8 0.6 0 0"><joint type="free" name="f" stiffness="0"/>
<geom size="0.2" pos="0.1 0 0"/></body></worldbody></mujoco>"""


def links_of_robot() -> list[Link]:
    """The robot by hand. Frames are at the last joint of a body."""
    first = [(Z, np.radians(10)), (X, np.radians(30))]  # Y stands, so that it is before both
    first.insert(0, (Y, np.radians(20)))
    tilted = turn([1, 2, 3], np.radians(40))
    along = turn([4, -3, 0], -np.pi / 2)  # of z to x = 0.3, y = 0.4
    a = summed(
        moved("box", [0.1, 0.2, 0.3], 500, [0, 0.1, 0], tilted),
        moved("capsule", [0.1, 0.25], 2 / volume_and_moments("capsule", [0.1, 0.25])[0],
              [0.15, 0.2, 0], along),
    )  # fmt: skip
    R = turn(first[0][0], first[0][1]) @ turn(*first[1]) @ turn(*first[2])
    up = np.array([0, 0, 0.1])
    nothing = (0, np.zeros(3), np.zeros((3, 3)))
    b = summed(moved("capsule", [0.2, 0.3], 500, R=turn(Y, np.pi / 4)))
    c, d = (
        summed(moved("ellipsoid", [0.2, 0.3, 0.4], 500, R=turn(Y, np.pi / 2))),
        summed(moved("sphere", [0.2], 500)),
    )
    aside, at_k = [(Z, np.pi / 4)], np.array([0, 0.1, 0])
    return [
        Link("a", -1, "revolute", Y, np.array([0.1, 0.2, 0.3]) + R @ up, first, a[0], a[1] - up,
             a[2], ["h"]),
        Link("b1", 0, "prismatic", np.array([3.0, 0, 4]), Z / 2 - up, aside, *nothing, ["s"]),
        Link("b", 1, "revolute", Z, at_k, [], b[0], b[1] - at_k, b[2], ["k"]),
        Link("c", 2, "spherical", Z, X / 10 - at_k, [], *c, [], "r"),
        Link("d", -1, "free", Z, np.zeros(3), [], d[0], X / 10, d[2], ["f_x", "f_y", "f_z"], "f"),
    ]  # fmt: skip


@pytest.mark.parametrize("seed", range(3))
def test_classes_springs_armature_and_geoms(tmp_path, seed):
    """Accelerations beside those of the bodies by hand."""
    model = check_text(Source("robot.lag", text_of(tmp_path, ROBOT)))[0]
    e = derive(model)
    symbols, values, rates = state_of(model, random.Random(seed))
    drawn = values | {"h": values["h"] - np.radians(30), "s": values["s"] - 0.5}
    motion = Motion(links_of_robot(), drawn, rates, np.array([0, 0, -9.81]))
    armature, force = [], []
    for b, which in motion.speeds:
        rate = rates[which] if isinstance(which, str) else rates[b.rotation][which]
        armature.append(0.3 if which == "s" else 0.1)
        force.append(-0.2 * rate)
    force[0] -= 3 * (values["h"] - np.radians(20))
    force[1] -= 3 * (values["s"] - 0.2)
    wanted = motion.accelerations(armature, force)
    turns = {r.name: r.turns for r in model.rotations}
    names = [c.name for c in model.coordinates]
    order = [w if isinstance(w, str) else turns[b.rotation][w] for b, w in motion.speeds]
    found = np.array(evaluate(e.graph, e.acceleration[: len(names)], symbols))
    found = found[[names.index(name) for name in order]]
    assert abs(found - wanted).max() < 1e-11 * abs(wanted).max()
    assert abs(wanted).min() > 1e-3


def test_a_model_starts_as_it_is_drawn(tmp_path):
    """Coordinates are those of qpos, by the names of the joints."""
    text = text_of(tmp_path, ROBOT)
    assert "start h = 0.5235987755982988  # as drawn" in text
    assert "start s = 0.5 [m]  # as drawn" in text
    (start,) = (line for line in text.split("\n") if line.startswith("start f_x"))
    assert start.startswith(
        "start f_x = 1.0 [m], f_y = 2.0 [m], f_z = 3.0 [m], f = rot([0.6, 0, 0], "
    )
    angle = float(start.partition("0, 0], ")[2].partition(")")[0])
    R = of_quaternion([0.8, 0.6, 0, 0])
    assert abs(turn(X, angle) - R).max() < 1e-15
    check_text(Source("robot.lag", text))


def the_body(tmp_path, xml: str):
    (tmp_path / "robot.xml").write_text(f"<mujoco>{xml}</mujoco>")
    return imported(tmp_path / "robot.xml")[1].links[-1]


INERTIAL = '<inertial pos="0 0 1" mass="2" diaginertia="1 2 0.5"/>'
WEIGHED = {
    "geoms where there is no inertial": ("", '<geom size="1" mass="5"/>', 5, [2, 2, 2]),
    "inertial": ("", f'{INERTIAL}<geom size="1"/>', 2, [1, 2, 0.5]),
    "geoms in place of it": ('inertiafromgeom="true"', f'{INERTIAL}<geom size="1" mass="5"/>', 5,
                             [2, 2, 2]),
    "no geoms in place of it": ('inertiafromgeom="true"', INERTIAL, 2, [1, 2, 0.5]),
    "massless geoms": ('inertiafromgeom="true"', f'{INERTIAL}<geom size="1" density="0"/>', 2,
                       [1, 2, 0.5]),
    "some groups": ('inertiagrouprange="1 2"',
                    '<geom size="3"/><geom size="1" mass="5" group="2"/>', 5, [2, 2, 2]),
    "a mesh that is only seen": ("", f'{INERTIAL}<geom type="mesh" mesh="m"/>', 2, [1, 2, 0.5]),
    "a mesh without mass": ("", '<geom size="1" mass="5"/><geom type="mesh" mass="0" mesh="m"/>', 5,
                            [2, 2, 2]),
    "between points": (
        "",
        '<geom type="box" size="0.3" fromto="0 0 0 0 0 2" mass="3"/>',
        3,
        [1.09, 1.09, 0.18],
    ),
    "a plane": ("", '<geom type="plane" size="1 1 1"/><geom size="1" mass="5"/>', 5, [2, 2, 2]),
    "least mass": ('boundmass="3"', INERTIAL, 3, [1, 2, 0.5]),
    "least moment": ('boundinertia="1.5"', INERTIAL, 2, [1.5, 2, 1.5]),
    "balanced": ('balanceinertia="true"', INERTIAL, 2, [3.5 / 3] * 3),
    "in balance": ('balanceinertia="true"', '<geom size="1" mass="5"/>', 5, [2, 2, 2]),
    "total": ('settotalmass="8"', INERTIAL, 8, [4, 8, 2]),
}  # fmt: skip


@pytest.mark.parametrize("case", WEIGHED)
def test_masses(tmp_path, case):
    settings, inside, mass, moments = WEIGHED[case]
    link = the_body(tmp_path, f"<compiler {settings}/>{BALL.format(inside)}")
    assert abs(link.mass - mass) < 1e-14
    assert abs(np.array(link.inertia) - np.diag(moments)).max() < 1e-14


def test_the_least_moment_is_of_the_principal_axes(tmp_path):
    inside = '<inertial mass="1" pos="0 0 0" diaginertia="1 2 0.1" euler="10 20 30"/>'
    found = np.array(
        the_body(tmp_path, f'<compiler boundinertia="1.2"/>{BALL.format(inside)}').inertia
    )
    R = turn(X, np.radians(10)) @ turn(Y, np.radians(20)) @ turn(Z, np.radians(30))
    assert abs(found - R @ np.diag([1.2, 2, 1.2]) @ R.T).max() < 1e-14


def test_where_a_mass_is_that_boundmass_alone_gives(tmp_path):
    """As in MuJoCo: at the position of the body, in its own frame."""
    body = '<body pos="1 2 3"><joint pos="1 0 0"/></body>'
    link = the_body(tmp_path, f'<compiler boundmass="2"/><worldbody>{body}</worldbody>')
    assert (link.mass, link.com) == (2, (0, 2, 3))


PLAIN = """<compiler{}/><option{}><flag{}/></option><worldbody><body{}>
<joint name="j" range="-1 1"{}/><geom size="1"{}/></body></worldbody>"""
WRITTEN = (
    ' angle="degree" coordinate="local" inertiafromgeom="auto" boundmass="0" boundinertia="0"'
    ' settotalmass="-1" balanceinertia="false" autolimits="true" eulerseq="xyz" meshdir="x"'
    ' inertiagrouprange="0 5" alignfree="false"',
    ' density="0" viscosity="0" wind="0 0 0" gravity="0 0 -9.81" timestep="0.002"',
    ' gravity="enable" contact="enable"',
    ' gravcomp="0" mocap="false" pos="0 0 0" quat="1 0 0 0"',
    ' stiffness="0" damping="0" armature="0" frictionloss="0" springref="0" ref="0"'
    ' springdamper="0 0" type="hinge" axis="0 0 1" limited="auto" margin="0"',
    ' density="1000" type="sphere" shellinertia="false" contype="1" conaffinity="1" group="0"',
)


def test_defaults_may_be_written(tmp_path):
    plain = text_of(tmp_path, f"<mujoco>{PLAIN.format(*[''] * 6)}</mujoco>")
    assert text_of(tmp_path, f"<mujoco>{PLAIN.format(*WRITTEN)}</mujoco>") == plain
    assert "limits [" in plain


def test_flags(tmp_path):
    """Switched off: gravity, springs and dampers, limits, contacts."""
    passive = ' stiffness="1" damping="2" frictionloss="3"'
    with_all = PLAIN.format("", "", "", "", passive, "")
    for flags, gone in [
        ("gravity", ["-9.81"]), ("spring", ["potential"]), ("damper", ["dissipation"]),
        ("passive", ["potential", "dissipation"]), ("limit", ["limits"]),
        ("contact", ["contacts of"]), ("frictionloss", ["frictionloss"]),
        ("constraint", ["limits", "contacts of", "frictionloss"]),
    ]:  # fmt: skip
        text = text_of(tmp_path, f"<mujoco>{with_all}</mujoco>")
        off = with_all.replace("<flag/>", f'<flag {flags}="disable"/>')
        less = text_of(tmp_path, f"<mujoco>{off}</mujoco>")
        assert [word for word in gone if word not in text or word in less] == []
    off = with_all.replace("<flag/>", '<flag equality="disable"/>')
    text_of(tmp_path, f"<mujoco><equality><weld/></equality>{off}</mujoco>")


def test_what_is_left_out_is_named(tmp_path):
    xml = """<mujoco><actuator><motor/><motor/><position/></actuator>
    <sensor><gyro/><touch/></sensor>
    <tendon><fixed/></tendon><keyframe><key/></keyframe><asset><mesh/></asset><visual/>
    <contact><exclude/></contact><equality><weld active="false"/></equality>
    <deformable><skin/></deformable><worldbody><light/><geom size="1"/><body mocap="true"><camera/>
    <site/><site/></body><body><joint type="ball" range="0 1" frictionloss="1"/>
    <geom size="1"/><geom size="1" contype="0" conaffinity="0"/></body></worldbody></mujoco>"""
    (tmp_path / "robot.xml").write_text(xml)
    assert imported(tmp_path / "robot.xml")[1].left_out == {
        "<motor> of <actuator>": 2, "<position> of <actuator>": 1, "<sensor>": 2,
        "<fixed> of <tendon>": 1, "<keyframe>": 1, "<asset>": 1, "<visual>": 1,
        "<exclude> of <contact>": 1, "<weld> of <equality>": 1, "<skin> of <deformable>": 1,
        "<light>": 1, "contacts of <geom>": 2, "<camera>": 1, "<site>": 2, "limits of a ball": 1,
        "frictionloss of a joint": 1, "motions of a mocap <body>": 1,
    }  # fmt: skip


def test_files_are_included_where_they_are_named(tmp_path):
    """Beside the first file, or beside the one that names them; in any element."""
    whole = text_of(tmp_path, ROBOT)
    (tmp_path / "parts").mkdir()
    defaults, bodies = ROBOT.index("<default>"), ROBOT.index("<worldbody>")
    (tmp_path / "d.xml").write_text(f"<mujocoinclude>{ROBOT[defaults:bodies]}</mujocoinclude>")
    inner = ROBOT[bodies + len("<worldbody>") : ROBOT.index("</worldbody>")]
    cut = inner.index('<body name="d"')
    (tmp_path / "parts" / "c.xml").write_text(f"<x>{inner[cut:]}</x>")
    (tmp_path / "parts" / "b.xml").write_text(f'<x>{inner[:cut]}<include file="c.xml"/></x>')
    (tmp_path / "parts" / "a.xml").write_text(
        '<x><include file="d.xml"/><worldbody><include file="parts/b.xml"/></worldbody></x>'
    )
    text = text_of(tmp_path, f'{ROBOT[:defaults]}<include file="parts/a.xml"/></mujoco>')
    assert text == whole


def test_names_that_a_reader_makes_are_new(tmp_path):
    """A body of two joints needs a name between them, which another body may have."""
    inside = '<inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/>'
    xml = f'<body name="a"><joint name="j"/><joint name="k" axis="1 0 0"/>{inside}</body>'
    xml += f'<body name="a_1"><joint name="b_weld"/>{inside}<body name="b">{inside}</body></body>'
    text = text_of(tmp_path, f"<mujoco><worldbody>{xml}</worldbody></mujoco>")
    model = check_text(Source("robot.lag", text))[0]
    assert [c.name for c in model.coordinates] == ["j", "k", "b_weld"]


def test_a_model_is_written_that_is_too_large_for_all_kernels(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(limits, "UNROLLED", 15_000)
    (tmp_path / "robot.xml").write_text(ROBOT)
    written = str(tmp_path / "robot.lag")
    options = Namespace(model=tmp_path / "robot.xml", base="fixed", json=False, output=written)
    assert importlib.import_module("pkgen_robots.command").run(options) == 0
    assert "not checked to the end, since it is large" in capsys.readouterr().err
    assert (tmp_path / "robot.lag").read_text().startswith("model robot")
