"""The sections of `explain` about scenes: the parts of the model that each scene needs."""

from __future__ import annotations

from collections.abc import Mapping

from ..back.c.program import Kernel
from ..compiler import Compilation, compile_model
from ..model import Scene
from ..record import record
from ..scenes import check as scene_check
from ..scenes import compile_plan as scene_use


@record
class SceneShown:
    """A summary of a scene. `lines` name the parts of the model that the scene leaves out, with
    reasons. `before` has the number of operations of each kernel of the model, `after` that of the
    scene's C. Operations are summed over independent subsystems."""

    name: str
    description: str
    lines: tuple[str, ...]
    before: dict[str, int]
    after: dict[str, int]


def scene_shown(whole: Compilation, sizes: Mapping[str, int], scene: Scene) -> SceneShown:
    """Compiles a scene; returns its summary, or the reasons why it cannot be compiled."""
    before = _operations(whole.program.kernels)
    name, description, source = scene.name, scene.description, whole.declared.source
    wrong = scene_check.wrong(whole.declared, sizes, scene)
    if wrong:
        said = tuple(finding.text(source) for finding in wrong)
        return SceneShown(name, description, said, before, {})
    made = compile_model(source, sizes=sizes, c=False, use=scene_use.of_scene(name))
    kernels = [*made.program.kernels, *(k for part in made.parts for k in part.program.kernels)]
    report, lines = made.report, [str(line) for line in made.report.lines]
    n, left = report.coordinates
    if n != left:
        states = " and states" if whole.model.states else ""
        lines.insert(0, f"{left} of {n} degrees of freedom{states} are left")
    return SceneShown(name, description, tuple(lines), before, _operations(kernels))


def _operations(kernels: list[Kernel] | tuple[Kernel, ...]) -> dict[str, int]:
    found: dict[str, int] = {}
    for kernel in kernels:
        found[kernel.name] = found.get(kernel.name, 0) + sum(kernel.operations.values())
    return found


def text(scenes: list[SceneShown]) -> str:
    """Returns the sections of all scenes; "" if there are none."""
    return "\n\n".join(_text(scene) for scene in scenes)


def _text(scene: SceneShown) -> str:
    title = f"Scene {scene.name}" + (f": {scene.description}" if scene.description else "")
    lines = [f"  {line}" for line in scene.lines or ("it needs all of the model",)]
    if scene.after and scene.before:
        width = max(map(len, scene.after))
        lines.append("  operations of a kernel, in the scene and in the model:")
        lines += [
            f"    {name:<{width}}  {scene.after[name]:>6}  {scene.before.get(name, '-'):>6}"
            for name in scene.after
        ]
        gone = [name for name in scene.before if name not in scene.after]
        lines += [f"    not called, so not there: {', '.join(gone)}"] if gone else []
    return "\n".join([title, *lines])


def record(scenes: list[SceneShown]) -> list[dict[str, object]]:
    return [vars(scene) | {"lines": list(scene.lines)} for scene in scenes]
