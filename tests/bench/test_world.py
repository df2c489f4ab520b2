"""The models beside other packages: their exact ends, by SciPy and pkgen; what is counted."""

import importlib

import pytest

from bench import world
from bench.world import cases, measure
from bench.world.contacts import cases as contacts

PACKAGES = ("scipy_", "pkgen_")


@pytest.mark.parametrize("name", cases.EXACT)
def test_two_packages_reach_the_exact_end(name: str) -> None:
    exact = cases.EXACT[name]()
    for package in (importlib.import_module(f"bench.world.{x}") for x in PACKAGES):
        prepare, counted, *_ = package.CASES[name]
        assert cases.error(list(prepare("best")()), exact) < 1e-10
        assert 5 < measure.lines(counted) < 50


def test_lines_are_those_of_the_model() -> None:
    text = "model m\n\n# a comment\ncoord x  # and one more\nkinetic x'^2/2\n"
    assert measure.lines((text,)) == 3
    assert measure.lines((test_lines_are_those_of_the_model, text)) == 3 + 4


def _contact(package: str, name: str, way: str):
    """The run, its end, and the error of it; skipped where the package is missing."""
    pytest.importorskip({"drake_": "pydrake"}.get(package, package.strip("_")))
    go = importlib.import_module(f"bench.world.contacts.{package}").CASES[name][0](way)
    end = list(go())
    return go, end, cases.error(end, contacts.EXACT[name]())


@pytest.mark.parametrize("package", ["pkgen_", "scipy_", "rumoca_", "drake_"])
@pytest.mark.parametrize("name", contacts.EXACT)
def test_packages_reach_the_exact_end_of_impacts_and_friction(name: str, package: str) -> None:
    _, end, error = _contact(package, name, "best")
    assert error < (1e-8 if (package, name) == ("rumoca_", "graze") else 3e-10)
    assert contacts.energy_error(name, end, contacts.EXACT[name]()) < 1e-10


def test_a_soft_box_stops_within_a_tenth_of_a_millimetre() -> None:
    assert _contact("mujoco_", "box", "best")[2] < 0.1


def test_a_graze_is_found_by_pkgen_and_passed_by_events_at_the_ends_of_steps() -> None:
    go, _, error = _contact("pkgen_", "graze", "default")
    assert error < 1e-7
    assert go.contacts[0]["impacts"] == 0  # of the second run, which misses the stop
    assert _contact("scipy_", "graze", "default")[2] > 1e-3


def test_pkgen_tells_the_time_of_rest() -> None:
    go, *_ = _contact("pkgen_", "ball", "default")
    assert go.contacts[0]["impacts"] == 72
    assert go.contacts[0]["rests"] == pytest.approx(2 * 5 / 9.81 / (1 - 0.8), abs=1e-12)


def test_each_table_has_its_place_on_the_page() -> None:
    text = world.PAGE.read_text(encoding="utf-8")
    for what in ("", " --contacts"):
        before, _, rest = text.partition(world.MARK.format(what))
        assert "$ python -m bench world" + what in before
        assert world.END in rest
