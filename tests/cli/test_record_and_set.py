"""`--record` of definitions, `--set` of inputs to functions of t: as a scene has them."""

from __future__ import annotations

from conftest import case, written
from pkgen import __main__ as command
from pkgen.compiler import compile_model
from pkgen.front.read import read
from pkgen.scenes import compile_plan as scene_use
from pkgen.scenes import options as scene_options

MODEL = case("pulled")


def test_charts_and_maps_drive_inputs_too(tmp_path):
    path = written(tmp_path, MODEL)
    for name, scene in (("chart", []), ("stability", ["--scene", "slow"])):
        words = [str(path), *scene, "--set", "F=(1 [N])*sin(t/(1 [s]))", "--set", "k=2"]
        options = command.parser_of(name).parse_args(words)
        made = compile_model(read(str(path)), use=scene_use.whole(options))
        assert not made.equations.inputs and made.structure.autonomous is False
        assert scene_options.numbers(options) == ["k=2"]
