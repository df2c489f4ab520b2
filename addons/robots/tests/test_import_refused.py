"""`pkgen import`: what is wrong in a file is a message with its place; hostile files do no harm."""

from __future__ import annotations

import time

import pytest
from robot_files import heavy, joint, link, text_of

from pkgen.front.check.check import check_text
from pkgen.source import ModelError, Source

LAUGHS = "".join(f'<!ENTITY l{k} "{f"&l{k - 1};" * 10}">' for k in range(1, 10))
HOSTILE = {
    "laughs": f'<!DOCTYPE r [<!ENTITY l0 "ha">{LAUGHS}]><robot name="&l9;"/>',
    "outside": '<!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/passwd">]><robot name="&x;"/>',
    "remote": '<!DOCTYPE robot SYSTEM "http://example.org/x.dtd"><robot/>',
    "parameter entity": '<!DOCTYPE r [<!ENTITY % p SYSTEM "file:///dev/zero"> %p;]><robot/>',
    "unknown entity": '<robot name="&x;"/>',
    "deep": "<robot>" + "<a>" * 100_000,
    "many": "<robot>" + "<a/>" * 240_000 + "</robot>",
    "empty": "",
    "text": "model pendulum",
    "unclosed": "<robot><link name='a'>",
    "html": "<html></html>",
    "encoding": '<?xml version="1.0" encoding="utf-16"?><robot name="a"/>',
}
WRONG = {
    "no link": ("<robot/>", "no link"),
    "no name": ("<robot><link/></robot>", "no 'name'"),
    "number": (link(inside=heavy("heavy")), "is no number"),
    "nan": (link(inside=heavy("nan")), "is no number"),
    "inf": (link(inside=heavy("1e999")), "is too large"),
    "no double": (link(inside=heavy("1e-400")), 'value="1e-400" is too small: 1e-400 is not 0'),
    "no square": (link(inside=heavy("1", "1e-200")), "is too small: 1e-200 is not 0"),
    "far round": (
        link() + link("b") + joint("j", "a", "b", inside='<origin rpy="0 0 1e9"/>'),
        'rpy="0 0 1e9" is too large',
    ),
    "underscore": (link(inside=heavy("1_0")), "is no number"),
    "other digits": (link(inside=heavy("\u0661")), "is no number"),
    "two numbers": (link(inside=heavy("1 2")), "is one number, not 2"),
    "negative mass": (link(inside=heavy("-1")), "the mass of 'a' is negative"),
    "negative inertia": (link(inside=heavy("1", "-1")), "has a negative moment"),
    "no mass": (link(inside="<inertial/>"), "has no mass"),
    "twice": (link() + link(), "two links 'a'"),
    "nothing moves": (link() + link("b") + joint("j", "a", "b", "fixed"), "nothing moves"),
    "two roots": (link() + link("b"), "2 links hang on no joint"),
    "unknown link": (link() + joint("j", "a", "c"), "no link 'c'"),
    "no child": (link() + '<joint name="j" type="fixed"><parent link="a"/></joint>', "no <child>"),
    "type": (link() + link("b") + joint("j", "a", "b", "hinge"), "no joint type 'hinge'"),
    "axis": (
        link() + link("b") + joint("j", "a", "b", inside='<axis xyz="0 0 0"/>'),
        "the zero vector",
    ),
    "short axis": (
        link() + link("b") + joint("j", "a", "b", inside='<axis xyz="0 1"/>'),
        "is 3 numbers, not 2",
    ),
    "circle": (
        link() + link("b") + link("c") + joint("i", "b", "c") + joint("j", "c", "b"),
        "go round in a circle",
    ),
    "nothing but a circle": (
        link("b") + link("c") + joint("i", "b", "c") + joint("j", "c", "b"),
        "go round in a circle",
    ),
    "two parents": (
        link() + link("b") + joint("i", "a", "b") + joint("j", "a", "b"),
        "hangs on the joint 'i' already",
    ),
    "itself": (link() + link("b") + joint("i", "b", "b"), "go round in a circle"),
    "damping": (
        link() + link("b") + joint("j", "a", "b", inside='<dynamics damping="-1"/>'),
        "damping of 'j' is negative",
    ),
    "xacro": ("<xacro:include/>", "is xacro"),
}
BODY = '<body name="b">{}<inertial mass="1" diaginertia="1 1 1"/></body>'
GEOM = "<worldbody><body><joint/><geom {}/></body></worldbody>"
JOINT = '<worldbody><body><joint/><inertial mass="1"/></body></worldbody>'
MJCF_WRONG = {
    "none": ("", "no body"),
    "nothing moves": ('<worldbody><body><geom size="1"/></body></worldbody>', "nothing moves"),
    "mesh": (GEOM.format('type="mesh" mesh="m"'), "masses are not taken from meshes"),
    "fitted mesh": (GEOM.format('type="box" mesh="m"'), "masses are not taken from meshes"),
    "shell": (GEOM.format('size="1" shellinertia="true"'), "'shellinertia' of a geom"),
    "flat": (GEOM.format('type="box" size="1 1"'), "the size of a box is 3 positive numbers"),
    "hollow": (GEOM.format('size="0"'), "the size of a sphere is 1 positive numbers"),
    "unsized": (GEOM.format('type="capsule" fromto="0 0 0 0 0 1"'), "the size of a capsule"),
    "point": (GEOM.format('type="capsule" size="1" fromto="1 0 0 1 0 0"'), "are one point"),
    "ball from to": (GEOM.format('size="1" fromto="0 0 0 1 0 0"'), "a sphere has no 'fromto'"),
    "light": (GEOM.format('size="1" density="-1"'), "the density of a geom is negative"),
    "unknown": (GEOM.format('size="1" wieght="1"'), "'wieght' of <geom> is not read"),
    "two ways": (GEOM.format('size="1" quat="1 0 0 0" zaxis="0 0 1"'), "'quat' and 'zaxis' both"),
    "no plane": (GEOM.format('size="1" xyaxes="1 0 0 2 0 0"'), "the zero vector"),
    "no axis": (GEOM.format('size="1" zaxis="0 0 0"'), "the zero vector"),
    "equality": (f"<equality><weld/></equality>{JOINT}", "<weld> of <equality> is not read"),
    "muscle": (f"<actuator><muscle/></actuator>{JOINT}", "a muscle pulls"),
    "muscle by another name": (
        f'<default><general gaintype="muscle"/></default><actuator><motor/></actuator>{JOINT}',
        "a muscle pulls",
    ),
    "flexible": (f"<deformable><flex/></deformable>{JOINT}", "a flexible part"),
    "tendon": (
        f'<default><tendon stiffness="0 2"/></default><tendon><spatial/></tendon>{JOINT}',
        "'stiffness' of <spatial> of <tendon>",
    ),
    "fluid": (f'<option viscosity="1e-5"/>{JOINT}', "a fluid is not read"),
    "unknown option": (f'<compiler x="1"/>{JOINT}', "'x' of <compiler> is not read"),
    "global": (f'<compiler coordinate="global"/>{JOINT}', "global coordinates"),
    "aligned": (f'<compiler alignfree="true"/>{JOINT}', "'alignfree' moves the frames"),
    "sequence": (f'<compiler eulerseq="xyw"/>{JOINT}', 'eulerseq="xyw" is not read'),
    "guess": (f'<compiler inertiafromgeom="maybe"/>{JOINT}', 'inertiafromgeom="maybe"'),
    "neither": (f'<compiler balanceinertia="1"/>{JOINT}', 'balanceinertia="1" is not true or'),
    "springdamper": ('<joint springdamper="1 1"/>', "'springdamper' of a joint"),
    "soft ball": ('<joint type="ball" stiffness="1"/>', "'stiffness' of a ball joint"),
    "polynomial": ('<joint stiffness="1 0 2"/>', "'stiffness' of a joint that is a polynomial"),
    "stiff": ('<joint stiffness="-1"/>', "the stiffness of a joint is negative"),
    "inert": ('<joint armature="-1"/>', "the armature of a joint is negative"),
    "turned free": ('<freejoint align="true"/>', "'align' moves the frame"),
    "class": ('<joint class="x"/>', "there is no default class 'x'"),
    "small axis": ('<joint axis="1e-200 0 0"/>', "is too small: 1e-200 is not 0"),
    "limits": ('<joint range="1 -1"/>', "are [1.0, -1.0]: none between them"),
    "limited": ('<joint limited="perhaps"/>', 'limited="perhaps" is not auto, true or false'),
    "far round": (
        '<worldbody><body axisangle="0 0 1 1e9"/></worldbody>',
        "an angle of 1e+09 is too large",
    ),
    "far ref": ('<joint ref="1e9"/>', 'ref="1e9" is too large'),
    "type": ('<joint type="x"/>', "no joint type 'x'"),
    "axis": ('<joint axis="0 0 0"/>', "the zero vector"),
    "frame": (f"<worldbody><frame/></worldbody>{JOINT}", "<frame> in <worldbody> is not read"),
    "composite": ("<body><composite/></body>", "<composite> in <body> is not read"),
    "lifted": (f'<worldbody><body gravcomp="1"/></worldbody>{JOINT}', "'gravcomp' of <body>"),
    "twice": ('<joint name="b"/><body name="b"/>', "two of the name 'b'"),
    "two inertials": ('<joint/><inertial mass="1"/>', "a body has one <inertial>"),
    "gaining": ('<joint damping="-2"/>', "the damping of a joint is negative"),
    "quat": ('<worldbody><body quat="0 0 0 0"/></worldbody>', "the zero vector"),
}


def refused(tmp_path, xml: str) -> str:
    with pytest.raises(ModelError) as caught:
        text_of(tmp_path, xml)
    (found,) = caught.value.diagnostics
    assert 0 <= found.span.start <= found.span.end <= max(len(xml), 1)
    return found.message


@pytest.mark.parametrize("case", HOSTILE)
def test_hostile_xml_is_refused(tmp_path, case):
    said = refused(tmp_path, HOSTILE[case])
    wanted = {"deep": "deep", "many": "more than", "html": "neither URDF nor MJCF"}
    doctype = "document type" if "DOCTYPE" in HOSTILE[case] else "this is no XML"
    if case == "encoding":
        doctype = "no link"  # it is read as what it is
    assert wanted.get(case, doctype) in said


def test_a_huge_file_is_refused(tmp_path):
    with pytest.raises(ModelError, match="larger than"):
        text_of(tmp_path, "<robot>" + " " * 20_000_000 + "</robot>")


@pytest.mark.parametrize("case", WRONG)
def test_wrong_robots(tmp_path, case):
    inside, said = WRONG[case]
    xml = inside if inside.startswith("<robot") else f"<robot name='r'>{inside}</robot>"
    assert said in refused(tmp_path, xml)


@pytest.mark.parametrize("case", MJCF_WRONG)
def test_wrong_mjcf(tmp_path, case):
    inside, said = MJCF_WRONG[case]
    if inside.startswith(("<joint", "<body", "<freejoint")):
        inside = f"<worldbody>{BODY.format(inside)}</worldbody>"
    assert said in refused(tmp_path, f"<mujoco>{inside}</mujoco>")


def test_hostile_names(tmp_path):
    """Whatever links are called, what is written is a model, and nothing leaves its comment."""
    names = ["a\nb", "mass", "1", "é", "for", "p_a", "g", "ground", "x" * 500, "a b", "a-b", "#"]
    links = "".join(link(n.replace("\n", "&#10;")) for n in names)
    mesh = '<visual><geometry><mesh filename="a&#10;let x = 1"/></geometry></visual>'
    links += link("last", mesh + heavy("1"))
    joints = "".join(joint(n.replace("\n", "&#10;"), "a&#10;b", m, "fixed")
                     for n, m in zip(names[1:], names[1:], strict=True))  # fmt: skip
    joints += joint("turn", "mass", "last")
    xml = f"<robot name='pk_ &#10;let y = 2'>{links}{joints}</robot>"
    model, _ = check_text(Source("r.lag", text_of(tmp_path, xml)))
    assert len(model.coordinates) == 1 and "x" not in {d.name for d in model.definitions}


def test_many_names_that_are_one(tmp_path):
    """Links whose names are one once they are of the language: no time is lost on them."""
    many = range(4000)
    links = "".join(link(f"{chr(0x4E00 + k)}") for k in many)
    inside = heavy("1")
    xml = f"<robot name='r'>{links}{link('last', inside)}"
    xml += "".join(joint(f"{chr(0x4E00 + k)}", chr(0x4E00), chr(0x4E00 + k), "fixed")
                   for k in many[1:])  # fmt: skip
    began = time.process_time()
    text = text_of(tmp_path, xml + joint("j", chr(0x4E00), "last") + "</robot>")
    assert text.count("\nbody ") == 4001 and time.process_time() - began < 10


def test_all_that_keeps_a_model_from_being_read_is_told_at_once(tmp_path):
    """Each once, with how often; what is alike in an included file too."""
    geom = '<geom type="mesh" mesh="m"/>'
    (tmp_path / "more.xml").write_text(f"<m><body><joint/>{geom}</body><body>{geom}</body></m>")
    inside = f"<equality><weld/><weld/><joint/></equality><worldbody><body>{geom}</body>"
    inside += '<include file="more.xml"/></worldbody><option wind="1 0 0" density="1.2"/>'
    with pytest.raises(ModelError) as caught:
        text_of(tmp_path, f"<mujoco>{inside}</mujoco>")
    said = {d.message: d.help for d in caught.value.diagnostics}
    assert [*said] == [
        "<weld> of <equality> is not read, and would change the motion (2 times)",
        "<joint> of <equality> is not read, and would change the motion",
        "masses are not taken from meshes",
        "more.xml: masses are not taken from meshes (2 times)",
        "'density' of <option>: a fluid is not read, and drags bodies",
    ]
    assert said["more.xml: masses are not taken from meshes (2 times)"].startswith(
        "more.xml:1:18: "
    )


INCLUDED_WRONG = {
    "outside": ('<include file="../x.xml"/>', "'../x.xml' lies outside of the folder"),
    "absolute": ('<include file="/etc/passwd"/>', "'/etc/passwd' lies outside of the folder"),
    "none": ('<include file="none.xml"/>', "there is no file 'none.xml' beside this one"),
    "folder": ('<include file="."/>', "there is no file '.' beside"),
    "unnamed": ("<include/>", "<include> has no 'file'"),
    "itself": ('<include file="robot.xml"/>', "'robot.xml' is included twice"),
    "twice": ('<include file="a.xml"/><include file="a.xml"/>', "'a.xml' is included twice"),
    "circle": ('<include file="circle.xml"/>', "'circle.xml' is included twice"),
    "link": ('<include file="link.xml"/>', "'link.xml' lies outside of the folder"),
    "entity": ('<include file="entity.xml"/>', "entity.xml:1:13: a document type is refused"),
    "broken": ('<include file="broken.xml"/>', "broken.xml:1:4: this is no XML"),
}


@pytest.mark.parametrize("case", INCLUDED_WRONG)
def test_what_is_not_included(tmp_path, case):
    inside, said = INCLUDED_WRONG[case]
    folder = tmp_path / "robot"
    folder.mkdir()
    (tmp_path / "x.xml").write_text("<mujoco/>")
    (folder / "a.xml").write_text("<mujoco/>")
    (folder / "circle.xml").write_text('<mujoco><include file="circle.xml"/></mujoco>')
    (folder / "link.xml").symlink_to(tmp_path / "x.xml")
    (folder / "entity.xml").write_text('<!DOCTYPE r [<!ENTITY x "y">]><r/>')
    (folder / "broken.xml").write_text("<a><")
    found = refused(folder, f"<mujoco>{inside}{JOINT}</mujoco>")
    assert said in found


def test_many_included_elements(tmp_path):
    for k in range(3):
        (tmp_path / f"{k}.xml").write_text(f"<mujoco>{'<a/>' * 99_000}</mujoco>")
    inside = "".join(f'<include file="{k}.xml"/>' for k in range(3))
    assert "with those included" in refused(tmp_path, f"<mujoco>{inside}</mujoco>")
