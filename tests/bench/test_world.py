"""The five models beside other packages: their exact ends, by SciPy and pkgen; what is counted."""

import importlib

import pytest

from bench.world import cases, measure

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
