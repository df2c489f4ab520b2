"""Plans a compilation from a scene and options: the equations, the kernels and the method."""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from dataclasses import replace

from ..compiler import Compilation
from ..equations import AnyEquations, Equations
from ..graph.solve import looped
from ..methods import METHODS, Method, in_lanes, known
from ..middle.motion import LINEAR_OF_FEW
from ..middle.reduce.reduce import APART, REDUCTIONS
from ..middle.reduce.reduction import ENOUGH, Needs
from ..middle.report import ReportLine
from ..middle.specialise import folded, held
from ..middle.structure import Structure
from ..model import Model, Scene
from ..plan import (
    DEFAULT,
    DEFAULTS,
    OPTION,
    SCENE,
    CompilePlan,
    Made,
    RunNumbers,
    Use,
    default_method,
)
from ..record import record
from ..run import diagnostics
from ..run.values import Numbers
from ..system.exits import UsageError
from ..system.near import unknown
from ..tree import Expr
from . import expects
from . import model as scene_model
from . import scene as scenes
from .options import OPTIONS, is_motion, numbers, record_columns, with_options

FOLD = "fold"
EXACT = "exact"  # the exact flow of a linear system by the matrix exponential
UNREAD = "unread"  # removal of parameters that nothing reads
EVERY = frozenset((*REDUCTIONS, FOLD, APART, EXACT, UNREAD))


@record(kw_only=True)
class SceneUse(Use):
    """The parts of a model that a scene uses, and options that override the scene."""

    scene: str
    columns: tuple[str, ...] | None = None  # recorded columns; None: those of the scene
    event: str | None = None
    run_time: frozenset[str] = frozenset()  # parameters and inputs that are set at run time
    off: frozenset[str] = frozenset()  # reductions that are switched off
    apart: bool = False  # whether blocks of coordinates may be integrated separately
    judged: bool = True  # whether the scene's expectations are checked
    several: bool = False  # whether the run has an ensemble file
    swarm: bool = True  # whether the scene may have a swarm
    options: argparse.Namespace | None = None  # all options of a run

    def kernels(
        self, used: Model, scene: Scene, plan: CompilePlan, made: Made | None
    ) -> frozenset[str] | None:
        """Returns the kernels that are needed (None: all)."""
        return None

    @property
    def method(self) -> str:
        return (self.options and self.options.method) or ""

    def events(self, scene: Scene) -> frozenset[str]:
        """Returns the events of expectations, and the one at which rows are written or ""."""
        at = self.event or (scene.record.at if scene.record else "")
        return expects.events(scene) | {at}

    def many(self, scene: Scene) -> bool:
        return self.several or scene.swarm is not None

    def chosen(self, model: Model) -> Scene:
        scene = scenes.chosen(model, self.scene)
        return scene if self.judged else replace(scene, expects=())

    def declared(self, declared: Model) -> Model:
        if self.options is not None:
            declared = with_options(declared, self.options, self.columns or ())
        return super().declared(declared)

    def model(self, declared: Model) -> tuple[Model, tuple[ReportLine, ...]]:
        scene = self.chosen(declared)
        if scene.swarm is not None and not self.swarm:
            place = declared.source.place(scene.swarm.span)
            raise UsageError(f"{place}: a swarm is many motions: 'pkgen run' runs it")
        if self.many(scene) and (at := declared.consistent or scene.consistent):
            place = declared.source.place(at)
            why = "the members of an ensemble start as they are given"
            raise UsageError(f"{place}: 'start consistent' is for one run: {why}")
        if self.columns is not None:
            columns = scene_model.written_out(declared, self.columns, scene)
            scene = scene_model.recording(declared, scene, columns)
        used, lines = scene_model.used(declared, scene, self.run_time), []
        if FOLD not in self.off:
            used, lines = folded(used, scene, self.run_time)
        used, of_holds = held(used, scene, self.events(scene))
        return used, (*lines, *of_holds)

    def exact(self, declared: Model) -> tuple:
        scene = self.chosen(declared)
        if not scene.exacts:
            return declared, ()
        used, _ = held(scene_model.used(declared, scene, self.run_time), scene)
        found = scenes.values(declared, scene, {})
        return used, scene.exacts, found.values, scenes.numbers(declared, scene, {}).until

    def needs(self, used: Model) -> Needs | None:
        scene = self.chosen(used)
        columns = self.columns and scene_model.written_out(used, self.columns)
        if columns is None and scene.record is not None:
            columns = tuple(scene_model.columns(scene))
        # A reduction takes momenta of the start as it is given.
        if columns is None or frozenset(REDUCTIONS) <= self.off or used.consistent:
            return None
        method = known(used.methods).get(self.method or scene.method)
        if method is not None and "fast" in method.requires:
            return None
        return Needs(
            frozenset(columns) | scene_model.needed(scene),
            self.events(scene),
            () if method is None else method.requires,
            self.apart and scene.swarm is None and _divided(used, scene, columns),
            self.off,
        )

    def plan(self, used: Model, made: Made | None) -> CompilePlan:
        scene = self.chosen(used)
        found = self.settled(used, scene, made)
        return replace(found, kernels=self.kernels(used, scene, found, made))

    def settled(self, model: Model, scene: Scene, made: Made | None) -> CompilePlan:
        """Returns a plan with the numbers and the method of a run, without kernels. The method is
        "" if it depends on equations that are not derived yet. Raises UsageError."""
        given = Numbers(model).of_run(self.options) if self.options else RunNumbers()
        method, source = self.method or scene.method, OPTION if self.method else SCENE
        if method:
            self._refuse_unfit(method, model)
        elif made is not None:
            exact = EXACT not in self.off and not self.many(scene)
            exact = exact and (given.rtol or given.step) is None
            # Only options can set a tolerance here: a scene with a tolerance also sets a method.
            method, source = default_method(made, given.else_of(DEFAULTS).rtol, exact), DEFAULT
        return CompilePlan(None, method, source, given)

    def _refuse_unfit(self, name: str, model: Model) -> None:
        """Raises UsageError for an unknown method, and for options that do not apply to it."""
        methods = known(model.methods)
        if name not in methods:
            raise UsageError(unknown("--method", name, methods, "method"))
        if self.options is None or "adaptive" in methods[name].traits:
            return
        inner = "fast" in methods[name].requires  # method respa: max_step limits its inner steps
        for option in ("rtol", "atol", *(() if inner else ("max_step",))):
            if getattr(self.options, option) is not None:
                shown = "--" + option.replace("_", "-")
                raise UsageError(f"{shown} is for adaptive methods, which {name} is not")

    def reads(self, used: Model) -> frozenset[str] | None:
        if UNREAD in self.off or self.several:
            return None
        return scene_model.reads(used, scenes.chosen(used, self.scene))

    def of_method(
        self, model: Model, scene: Scene, plan: CompilePlan, made: Made | None
    ) -> frozenset[str]:
        """Returns the kernels that the method calls; if it is unknown, any default method."""
        of = known(model.methods).get(plan.method)
        found = of.kernels if of else METHODS["gauss"].kernels | {"mass", LINEAR_OF_FEW}
        if any(self.events(scene)) or any(event.stop for event in model.events):
            found -= {"advance"}  # kernel `advance` makes many steps, without looking for events
        if self.many(scene) and (made is None or _side_by_side(*made, of)):
            found |= {"members"}
        return found


class RunUse(SceneUse):
    """The parts of a model that a run uses."""

    def kernels(
        self, used: Model, scene: Scene, plan: CompilePlan, made: Made | None
    ) -> frozenset[str] | None:
        """Returns the kernels of the run. Diagnostics or a search for a method need all (None)."""
        if self.options.diagnose or promised(plan, scene) is not None:
            return None
        return self.of_method(used, scene, plan, made) | self._of_driver(scene, made)

    def plan(self, used: Model, made: Made | None) -> CompilePlan:
        found = super().plan(used, made)
        return replace(found, jets=promised(found, self.chosen(used)) is not None)

    def _of_driver(self, scene: Scene, made: Made | None) -> frozenset[str]:
        """Returns the kernels that a run calls outside its method: for drifts, energy, checks of
        M."""
        found = {"canonical", "conserve"}
        columns = self.columns or scene_model.columns(scene)
        whole = self.columns is None and scene.record is None
        structure = made[1] if made else None
        watched = structure is None or structure.conservative
        if whole or watched or "energy" in {*columns, *scene_model.needed(scene)}:
            found |= {"energy"}
        definite = structure and getattr(structure, "definite", True)
        solved = made and getattr(made[0], "constraints", ())  # else: kernel `inertia`
        needed = not definite or not (self.many(scene) or solved or structure.mass_diagonal)
        if needed and not (made and _without_mass(made[0])):
            found |= {"mass"}
        return frozenset(found)


class CheckUse(SceneUse):
    """The parts of a model that a scene uses if it runs without options; no C is generated."""

    def kernels(self, *_: object) -> frozenset[str]:
        return ENOUGH


@record(kw_only=True)
class PlainUse(SceneUse):
    """The parts of a model for C without a runtime. The C, named MODEL_SCENE, has only the kernels
    of the scene's method and columns, and those that `more` names."""

    more: frozenset[str] = frozenset()

    def kernels(
        self, used: Model, scene: Scene, plan: CompilePlan, made: Made | None
    ) -> frozenset[str]:
        found = self.of_method(used, scene, plan, made) | self.more
        if scene.record is None:
            return found | {"energy", "conserve"}
        return found | ({"energy"} & set(scene_model.columns(scene)))

    def model(self, declared: Model) -> tuple[Model, tuple[ReportLine, ...]]:
        model, lines = super().model(declared)
        return replace(model, name=f"{model.name}_{self.scene}"), lines


def of_run(options: argparse.Namespace) -> Use:
    """Returns which parts of a model a run uses. Without a scene, it uses the whole model."""
    off = switched_off(options.no_reduce) if options.scene else EVERY
    if options.diagnose:
        off |= {APART}
    if diagnostics.of_whole(options.diagnose):
        # The diagnostic `modes` needs an equilibrium. At an equilibrium of the other coordinates,
        # cyclic coordinates may move: they are removed.
        off |= {*REDUCTIONS} - ({"cyclic"} if options.diagnose == "modes" else set())
    asked = _asked(RunUse, options, record_columns(options), off)
    return replace(asked, apart=not asked.several)


def promised(plan: CompilePlan, scene: Scene) -> Expr | None:
    """Returns the accuracy that the scene requires, or None if options set a method, a step size or
    a tolerance."""
    of = plan.numbers
    free = plan.source != OPTION and (of.step, of.rtol, of.atol) == (None, None, None)
    return scene.accuracy if free else None


def planned(options: argparse.Namespace, compilation: Compilation) -> CompilePlan:
    """Returns the plan with which a model was compiled for a run. If it was compiled for another
    purpose, makes a plan."""
    if compilation.plan.method:
        return compilation.plan
    declared = compilation.declared
    scene = scenes.of(options, declared) or Scene(name=OPTIONS, span=declared.span)
    made = compilation.equations, compilation.structure
    return _asked(SceneUse, options, None, frozenset()).settled(compilation.model, scene, made)


def _asked(
    kind: type[SceneUse],
    options: argparse.Namespace,
    columns: tuple[str, ...] | None,
    off: frozenset[str],
) -> SceneUse:
    """Returns the use that options ask for. `off` are reductions to switch off; the method by exact
    flow is switched off only by --no-reduce and --diagnose. Parameters and inputs to which --set
    assigns numbers can be changed at run time."""
    exact = EXACT in switched_off(options.no_reduce) or options.diagnose
    return kind(
        scene=options.scene or OPTIONS,
        columns=columns,
        event=options.at,
        run_time=frozenset(text.partition("=")[0].strip() for text in numbers(options)),
        off=off | {EXACT} if exact else off - {EXACT},
        several=options.ensemble is not None,
        options=options,
    )


def _without_mass(e: AnyEquations) -> bool:
    """Whether the accelerations of a tree of bodies are computed without M, since M is large."""
    return e.acceleration is not None and looped(e.graph, e.mass)


def _side_by_side(equations: Equations, structure: Structure, method: Method | None) -> bool:
    """Whether ensemble members run in SIMD lanes. Models with constraints or with families of any
    length do not."""
    return equations.dense and not equations.constraints and in_lanes(method, structure)


def whole(
    options: argparse.Namespace, columns: tuple[str, ...] | None = None, off: frozenset[str] = EVERY
) -> Use | None:
    """Returns which parts of a model charts use: all except coordinates whose motion the scene
    prescribes."""
    if options.scene is None and columns is None and not any(map(is_motion, options.set)):
        return None
    return replace(_asked(SceneUse, options, columns, off), event=None, swarm=False)


def enclosed(options: argparse.Namespace) -> Use | None:
    """Returns the restrictions of a model for rigorous bounds: a scene's parameters are exact."""
    return whole(options, record_columns(options), EVERY - {FOLD})


def of_compile(options: argparse.Namespace) -> Use | None:
    """Returns the restrictions of a model that is compiled to C, or None without a scene."""
    if options.scene is None:
        return None
    more = frozenset({"canonical"}) if options.canonical else frozenset()  # for initial momenta
    return of_scene(options.scene, switched_off(options.no_reduce), more)


def of_scene(
    name: str, off: frozenset[str] = frozenset(), more: frozenset[str] = frozenset()
) -> Use:
    """Returns the restrictions of a model for C without a runtime."""
    return PlainUse(scene=name, off=off, apart=True, judged=False, more=more)


def _divided(model: Model, scene: Scene, columns: Iterable[str]) -> bool:
    """Whether blocks of coordinates may be integrated separately. With an accuracy, which is one of
    columns, they may not if a column or an expectation could combine several blocks."""
    coordinates = {item.name for item in model.coordinates}
    plain = all(column.rstrip("'").split("[")[0] in coordinates for column in columns)
    return scene.accuracy is None or (plain and not scene.expects)


def switched_off(text: str | None) -> frozenset[str]:
    """Returns the reductions in the value of --no-reduce: all, or a list. Raises UsageError."""
    if text is None:
        return frozenset()
    names = frozenset(name.strip() for name in text.split(","))
    if names == {"all"}:
        return EVERY
    for name in sorted(names - EVERY):
        raise UsageError(unknown("--no-reduce", name, sorted(EVERY), "reduction"))
    return names
