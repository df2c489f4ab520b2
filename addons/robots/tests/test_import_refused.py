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
MJCF_WRONG = {
    "none": ("", "no body"),
    "geoms": ('<worldbody><body><geom size="1"/></body></worldbody>', "no <inertial>"),
    "equality": ("<equality/>", "would change the motion"),
    "include": ('<include file="/etc/passwd"/>', "would change the motion"),
    "defaults": ("<default><default><joint/></default></default>", "defaults of joints"),
    "armature": ('<joint armature="1"/>', "'armature' of a joint"),
    "stiffness": ('<joint stiffness="1"/>', "'stiffness' of a joint"),
    "class": ('<joint class="x"/>', "classes of defaults"),
    "small axis": ('<joint axis="1e-200 0 0"/>', "is too small: 1e-200 is not 0"),
    "limits": ('<joint range="1 -1"/>', "are [1.0, -1.0]: none between them"),
    "limited": ('<joint limited="perhaps"/>', 'limited="perhaps" is not auto, true or false'),
    "far round": (
        '<worldbody><body axisangle="0 0 1 1e9"/></worldbody>',
        "an angle of 1e+09 is too large",
    ),
    "type": ('<joint type="x"/>', "no joint type 'x'"),
    "axis": ('<joint axis="0 0 0"/>', "the zero vector"),
    "frame": (
        "<worldbody><frame><body/></frame></worldbody>",
        "<frame> in <worldbody> is not read",
    ),
    "composite": ('<body q=""><composite/></body>', "<composite> in <body> is not read"),
    "weightless": ('<option><flag gravity="disable"/></option>', "'gravity' of <flag> is not read"),
    "scaled": ('<compiler settotalmass="3"/>', "'settotalmass' of <compiler> is not read"),
    "gaining": ('<joint damping="-2"/>', "the damping of a joint is negative"),
    "quat": ('<body quat="0 0 0 0"/>', "the zero vector"),
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
    if inside.startswith(("<joint", "<body q")):
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
