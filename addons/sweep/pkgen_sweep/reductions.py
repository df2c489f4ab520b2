"""The numbers of each member that a plan keeps: final state, reductions over rows, and counts and
times of events."""

from __future__ import annotations

import re
import sys
from dataclasses import replace

from pkgen.compiler import Compilation
from pkgen.equations import Quantity
from pkgen.front.check.expects import calls
from pkgen.model import Expect, Scene
from pkgen.record import record
from pkgen.run import named
from pkgen.run.named import columns
from pkgen.run.settings import Settings
from pkgen.run.values import Values
from pkgen.scenes.expects import column, of_run, written
from pkgen.system.exits import UsageError
from pkgen.system.near import near

from .plan import Plan

OF_COLUMNS = {"max": "M", "min": "m", "mean": "a", "final": "f"}
WORDS = ("final", "rows", "lyapunov", "expects")
OF_EVENTS = {"count": "n", "time": "t"}
_CALL = re.compile(r"\s*(\w+)\s*\(\s*(.+?)\s*\)\s*")


class NotThere(UsageError):
    """A quantity to keep is not in the compiled model: the compiler leaves out parts that a scene
    does not need."""


@record
class Kept:
    """The numbers of each member that the plan keeps, with the reductions by which the runtime
    computes them; and the columns of rows that the plan keeps."""

    # the kind and the index of each reduction, as in struct pk_run_reduced
    reduced: tuple[tuple[bytes, int], ...]
    numbers: tuple[Quantity, ...]
    # columns of the rows over time that are kept; empty if no rows are kept
    rows: tuple[Quantity, ...]


def by_row(plan: Plan) -> bool:
    """Whether the plan needs rows over time, not only the final state."""
    return any(x == "rows" or x.startswith(("max", "min", "mean")) for x in plan.keep)


def kept(
    plan: Plan, compilation: Compilation, settings: Settings, scene: Scene | None
) -> tuple[Kept, Settings]:
    """Returns the kept numbers, and settings of a run that computes them. Raises UsageError with
    the position of an error in the plan."""
    return _Keeper(plan, compilation, settings, scene).all()


class _Keeper:
    def __init__(self, plan: Plan, compilation: Compilation, settings: Settings, scene):
        self.plan, self.compilation, self.settings = plan, compilation, settings
        self.scene = scene
        self.values = Values(compilation)
        names = [c.name for c in columns(compilation, settings.show, sys.maxsize)[1:]]
        self.final = list(settings.show) or [self.values.shown(name) for name in names]
        whole = "final" in plan.keep or "rows" in plan.keep
        self.show = list(self.final) if whole else []
        self.watched = settings.watched
        self.found: list[tuple[str, int, Quantity]] = []

    def all(self) -> tuple[Kept, Settings]:
        for text in self.plan.keep:
            self.one(text)
        shown = self.show or self.final
        settings = replace(self.settings, show=tuple(shown), watched=self.watched)
        if any(what in "ntl" for what, _, _ in self.found):
            settings = replace(settings, watch=settings.watch or "events")
        names = [quantity.name for _, _, quantity in self.found]
        for name in names:
            if names.count(name) > 1:
                raise self.wrong(f"{name} is kept twice")
        rows = columns(self.compilation, settings.show, sys.maxsize)
        return Kept(
            tuple((what.encode(), index) for what, index, _ in self.found),
            tuple(quantity for _, _, quantity in self.found),
            tuple(rows) if "rows" in self.plan.keep else (),
        ), settings

    def wrong(self, message: str, help: str = "") -> UsageError:
        return self.plan.wrong("", "keep", message, help)

    def absent(self, message: str) -> NotThere:
        return NotThere(str(self.wrong(message)))

    def one(self, text: str) -> None:
        if text == "rows":
            return
        if text == "final":
            for k, shown in enumerate(self.final):
                self.found.append(("f", k, self.quantity(shown.kind, shown.name)))
        elif text == "drift":
            self.drift("energy")
        elif text == "lyapunov":
            time = "" if self.compilation.model.dimensionless else "1/s"
            self.found.append(("l", 0, Quantity("lyapunov", time, "largest exponent")))
        elif text == "expects":
            self.expects()
        else:
            self.call(text)

    def call(self, text: str) -> None:
        of = _CALL.fullmatch(text)
        known = (*WORDS, *(f"{f}(…)" for f in self.functions()))
        if not of or of[1] not in self.functions():
            name = of[1] if of else text
            said = near(name, [*self.functions(), *WORDS], "option")
            raise self.wrong(
                f"nothing is kept as '{text}'; {said}", f"there are {', '.join(known)}"
            )
        if of[1] == "drift":
            self.drift(of[2])
        elif of[1] in OF_EVENTS:
            self.event(of[1], of[2])
        else:
            index, quantity = self.column(of[2])
            name = f"{of[1]}({quantity.name})"
            self.found.append((OF_COLUMNS[of[1]], index, replace(quantity, name=name)))

    @staticmethod
    def functions() -> tuple[str, ...]:
        return (*OF_COLUMNS, *OF_EVENTS, "drift")

    def quantity(self, kind: str, name: str) -> Quantity:
        return named.kinds(self.compilation)[kind][name][1]

    def column(self, name: str) -> tuple[int, Quantity]:
        """Returns the index and the quantity of the column `name` of the rows. If the rows have no
        such column, it is added."""
        try:
            shown = self.values.shown(self.values.flat_name("keep", name), "keep")
        except UsageError as error:
            raise self.absent(str(error)) from None
        places = [(other.kind, other.index) for other in self.show]
        if (shown.kind, shown.index) in places:
            k = places.index((shown.kind, shown.index))
        else:
            k = len(places)
            self.show.append(shown)
        return k, self.quantity(shown.kind, shown.name)

    def event(self, function: str, name: str) -> None:
        events = named.events(self.compilation)
        if name not in events:
            raise self.absent(f"the model has no event {name}; {near(name, events, 'event')}")
        time = "" if self.compilation.model.dimensionless else "s"
        unit = time if function == "time" else ""
        quantity = Quantity(f"{function}({name})", unit, "")
        self.found.append((OF_EVENTS[function], events.index(name), quantity))

    def drift(self, name: str) -> None:
        """Keeps the largest drift of the energy or of an output, over all steps."""
        if name == "energy" and not self.compilation.equations.has_energy:
            raise self.wrong("the model has no energy")
        outputs = [quantity.name for quantity in named.observed(self.compilation)]
        if name != "energy" and name not in outputs:
            said = near(name, ["energy", *outputs], "output")
            raise self.absent(f"the model has no output {name} that could drift; {said}")
        of = None if name == "energy" else outputs.index(name)
        drifts = self.watched.drifts
        if of not in drifts:
            self.watched = replace(self.watched, drifts=(*drifts, of))
        index = self.watched.drifts.index(of)
        self.found.append(("d", index, Quantity(f"drift({name})", "", "relative to its size")))

    @staticmethod
    def whole(item: Expect) -> list[str]:
        """Returns entries of the plan's `keep` from which a user can judge an expectation about the
        whole run."""
        drifts = [column(call.arguments[0]) or "…" for call in calls(item, "drift")]
        times = [call.arguments[0].id for call in calls(item, "time")]
        return [*(f'"drift({name})"' for name in drifts), *(f'"time({name})"' for name in times)]

    def expects(self) -> None:
        """Keeps a number per expectation of the scene: 1 if it is met."""
        if self.scene is None or not self.scene.expects:
            raise self.wrong("'expects' is for a scene that expects something")
        for k, item in enumerate(self.scene.expects):
            if of_run(item):
                source = self.compilation.declared.source
                raise self.wrong(
                    f"expect {k + 1}, '{written(source, item)}', is of a whole run, not of the "
                    "motion; keep what it compares, and judge it in the data set",
                    f"keep = [{', '.join(self.whole(item))}]",
                )
            text = self.settings.watched.compared[k].text
            self.found.append(("x", k, Quantity(f"expect {k + 1}", "", text)))
