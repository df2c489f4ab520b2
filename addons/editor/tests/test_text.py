"""What stands at a place of a text, without a server: what mutations of the code showed missing."""

from __future__ import annotations

import pytest

from pkgen_editor.look import Text
from pkgen_editor.propose import Refused, proposals, renamed, uses

MODEL = """\
model swing
param l = 2 [m]
coord x [m]
body cart mass 1 [kg] inertia [1, 1, 1 [kg*m^2]]
joint slide: ground to cart prismatic [1, 0, 0] coord slide_far
kinetic l*0*x'^2/2*(1 [kg/m])
constraint keeps: x = l
scene many
  swarm k = 1..3
  start x = k*(1 [m])
  until 1
end
draw curve [cos(k), sin(k), 0], k = 0..8
draw ground z = 0
"""


def text() -> Text:
    return Text("swing.lag", MODEL)


def at(part: str, inside: int = 0) -> int:
    return MODEL.index(part) + inside


def written(offset: int) -> list[int]:
    return sorted(span.start for span, _ in uses(text(), offset))


def test_behind_a_name_it_is_that_name() -> None:
    found = text().hover(at("l*0*x", 1))
    assert found is not None and found[1].startswith("**l**: a parameter [m] = 2")


def test_a_name_that_a_joint_is_given_is_not_made_of_the_joint() -> None:
    new = renamed(text(), at("slide:"), "guide")
    assert [name for _, name in new] == ["guide"]
    assert "slide_far" not in text().made


def test_a_loop_variable_of_a_statement_is_not_that_of_a_swarm() -> None:
    curve = at("draw curve")
    places = written(at("k = 0..8"))
    assert len(places) == 3 and min(places) > curve
    swarm = written(at("swarm k", 6))
    assert len(swarm) == 2 and max(swarm) < curve


def test_multipliers_come_with_their_constraint() -> None:
    assert text().base("lambda_keeps") == "keeps" and "force" in text().made["lambda_keeps"][1]


def test_nothing_is_proposed_in_a_comment() -> None:
    commented = MODEL + "let a = 2  # the "
    assert proposals(Text("a.lag", commented), len(commented)) == []
    assert proposals(Text("a.lag", commented), commented.index("  # the"))


def test_what_every_model_has_is_no_other_name() -> None:
    for taken in ("pi", "V", "energy"):
        with pytest.raises(Refused):
            renamed(text(), at("l = 2"), taken)


def test_the_axis_of_a_plane_is_no_name() -> None:
    other = Text("a.lag", MODEL.replace("coord x [m]", "coord x [m], z [m]"))
    found = uses(other, other.source.text.index("z [m]"))
    assert len(found) == 1


def test_clauses_are_proposed_to_the_end_of_a_scene() -> None:
    def words(offset: int) -> set[str]:
        return {p.label for p in proposals(text(), offset)}

    assert "expect" in words(at("  until", 2)) and "kinetic" not in words(at("  until", 2))
    assert "expect" not in words(at("draw curve")) and "kinetic" in words(at("draw curve"))
