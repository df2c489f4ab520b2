"""The plan of a compile: a run has the method and the numbers with which its C was made."""

import pytest

from pkgen.__main__ import parser_of
from pkgen.compiler import Compilation, compile_model
from pkgen.defaults import RTOL
from pkgen.own.given import given
from pkgen.plan import DEFAULT, OPTION, SCENE
from pkgen.scenes import compile_plan, run_settings, scene
from pkgen.source import Source
from pkgen.system.exits import UsageError

TEXT = """
model m
param tight = 1e-6 in [0, 10]
param m = 1 [kg]
param k = 1 [N/m]
coord q [m]
kinetic m*q'^2/2
potential k*q^2/2
start q = 1
scene of_radau
  method radau rtol tight
  until 1
end
scene plain
  until 1
end
"""


def made(*words: str) -> tuple[Compilation, run_settings.Settings]:
    options = parser_of("run").parse_args(["m.lag", *words])
    source, use = Source("m.lag", TEXT), compile_plan.of_run(options)
    compilation = compile_model(source, own=given(options), unroll=16, use=use)
    chosen = scene.of(options, compilation.declared)
    return compilation, run_settings.settings(options, compilation, chosen=chosen)


@pytest.mark.parametrize(
    ("words", "method", "source"),
    [
        ("", "exponential", DEFAULT),
        ("--scene plain", "exponential", DEFAULT),
        ("--no-reduce exact", "gauss", DEFAULT),
        ("--scene plain --no-reduce exact", "gauss", DEFAULT),
        ("--step 0.1", "gauss", DEFAULT),
        ("--rtol 1e-3", "dop853", DEFAULT),
        ("--diagnose lyapunov", "gauss", DEFAULT),
        ("--method rk4 --step 0.1", "rk4", OPTION),
        ("--composition 0.5,0.5 --method composition --step 0.1", "composition", OPTION),
        ("--scene of_radau", "radau", SCENE),
    ],
)
def test_a_run_has_the_method_that_was_compiled(words, method, source) -> None:
    compilation, settings = made(*words.split())
    plan = compilation.plan
    assert (settings.method, plan.method, plan.source) == (method, method, source)
    if plan.kernels is not None:
        assert ("linear" in plan.kernels) == (method == "exponential")
        assert ("lanes" in plan.kernels) == (method == "gauss")


def test_numbers_are_an_options_else_a_scenes_else_the_default() -> None:
    assert made()[1].rtol == RTOL
    assert made("--scene", "of_radau")[1].rtol == 1e-6
    assert made("--scene", "of_radau", "--set", "tight=1e-4")[1].rtol == 1e-4
    assert made("--scene", "of_radau", "--rtol", "1e-5", "--until", "2")[1].until == 2
    assert made("--scene", "of_radau", "--rtol", "1e-5")[1].rtol == 1e-5


@pytest.mark.parametrize("words", ["--rtol {}", "--scene of_radau --set tight={}"])
@pytest.mark.parametrize(("rtol", "said"), [("1", "controls nothing"), ("1e-17", "that exact")])
def test_a_tolerance_has_the_same_bounds_wherever_it_comes_from(words, rtol, said) -> None:
    with pytest.raises(UsageError, match=said):
        made(*words.format(rtol).split())


def test_wrong_options_are_told_before_the_compile(monkeypatch) -> None:
    monkeypatch.setattr("pkgen.compiler.derive.derive", None)
    for words, said in (
        ("--method rk5", "there is no such method"),
        ("--method rk4 --rtol 1e-5", "for adaptive methods"),
        ("--step 1 [m]", "--step"),
    ):
        with pytest.raises(UsageError, match=said):
            made(*words.split(maxsplit=3 if "--rtol" in words else 1))
