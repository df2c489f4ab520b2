"""Evaluates a scene's expectations from the report of a run."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from fractions import Fraction

from ..front.check.expects import calls
from ..front.check.scene_numbers import Values, WrongValue
from ..model import Expect, Model, Scene
from ..record import record
from ..source import Diagnostic, Span
from ..tree import Call, Expr, Number, replaced, within
from .expects import of_run, written


@record
class Verdict:
    """The verdict on one expectation of a scene. `value` and `bound` are the values of the left and
    right side of the relation where it is missed by most."""

    text: str
    span: Span
    met: bool
    said: str  # reason why the expectation is not met
    value: float | None = None
    bound: float | None = None
    within: float | None = None
    t: float | None = None
    member: int | None = None

    def record(self) -> dict[str, object]:
        return {key: x for key, x in vars(self).items() if key != "span"}

    def diagnostic(self) -> Diagnostic:
        return Diagnostic(f"expectation missed: {self.said}", self.span)


class Judge:
    """Evaluates expectations after a run. `values` has parameters, `member(k)` names a member."""

    def __init__(
        self,
        model: Model,
        scene: Scene,
        values: Values,
        report: dict,
        member: Callable[[int], str] | None,
    ):
        self.model, self.scene, self.values = model, scene, values
        self.report, self.member = report, member
        self.constants: dict[Expr, float] = {}  # values that all members share

    def verdicts(self) -> list[Verdict]:
        compared = iter(self.report["expects"])
        drifts = iter(self.report["expect_drifts"])
        return [
            self._of_run(item, drifts) if of_run(item) else self._compared(item, next(compared))
            for item in self.scene.expects
        ]

    def _verdict(self, item: Expect, met: bool, said: str, **found: float | int | None) -> Verdict:
        return Verdict(written(self.model.source, item), item.span, met, said, **found)

    def _compared(self, item: Expect, found: dict) -> Verdict:
        if found["count"] == 0:
            end = self.report.get("t")
            ended = "" if end is None else f": the run ended at t = {_text(end)}"
            said = f"there was no such time{ended}" if item.at is not None else "there was no row"
            said = f"event '{item.event}' did not happen{ended}" if item.event else said
            return self._verdict(item, False, said)
        absent = self._event(item.event).get("never", 0) if item.event else 0
        if absent:
            of = f"in {absent} of {self.report['members']} members"
            return self._verdict(item, False, f"event '{item.event}' did not happen {of}")
        met = found["missed"] == 0
        where = f" at t = {_text(found['t'])}"
        keep = {key: found[key] for key in ("value", "bound", "t")}
        if item.relation == "=":
            keep["within"] = found["within"]
        if self.member is not None:
            keep["member"] = found["member"]
            where += f" of {self.member(found['member'])}"
        said = "" if met else self._miss(item, where=where, **keep)
        if not met and found["count"] > 1:
            said += f"; missed {found['missed']} of {found['count']} times, this the most"
        if said and item.component:
            said = f"{item.component}: {said}"
        return self._verdict(item, met, said, **keep)

    def _of_run(self, item: Expect, drifts: Iterator[dict]) -> Verdict:
        numbers: dict[Call, float | None] = {}
        member = None
        for call in calls(item, "drift"):
            found = next(drifts)
            numbers[call], member = found["max"], found["member"]
        times = {call: self._times(call.arguments[0].id) for call in calls(item, "time")}
        first = self.report.get("first_member", 0)
        rows = enumerate(zip(*times.values(), strict=True), first)
        cases = [(numbers | dict(zip(times, row, strict=True)), k) for k, row in rows]
        cases = cases or [(numbers, member)]
        return self._worst(item, cases if self.member is not None else [(cases[0][0], None)])

    def _worst(self, item: Expect, cases: list[tuple[dict, int | None]]) -> Verdict:
        """Returns the verdict on the run, or on the ensemble member with the largest miss."""
        worst = None
        for numbers, member in cases:
            verdict = self._case(item, numbers, member)
            if verdict.value is None or verdict.bound is None:
                return verdict
            d = verdict.value - verdict.bound
            off = {"<": d, ">": -d, "=": abs(d)}[item.relation]
            if worst is None or off > worst[0]:
                worst = off, verdict
        return worst[1]

    def _case(self, item: Expect, numbers: dict, member: int | None) -> Verdict:
        where = "" if member is None else f" of {self.member(member)}"
        for call, number in numbers.items():
            if number is None and call.function == "time":
                name = call.arguments[0].id
                return self._verdict(item, False, f"event '{name}' did not happen{where}")
            if number is None:
                return self._verdict(item, False, f"{call.function}(…) is not finite")
        try:
            a, b, allowed = (e and self._number(e, numbers) for e in (item.a, item.b, item.within))
        except WrongValue as wrong:
            return self._verdict(item, False, str(wrong))
        met = {"<": a < b, ">": a > b, "=": abs(a - b) <= (allowed or 0.0)}[item.relation]
        keep = {"value": a, "bound": b, "within": allowed, "member": member}
        said = "" if met else self._miss(item, where, a, b, allowed)
        return self._verdict(item, met, said, **keep)

    def _event(self, name: str) -> dict:
        """Returns what the run's report says about an event. If the run refused the initial state,
        the event has no times."""
        return next((e for e in self.report["events"] if e["name"] == name), {"times": []})

    def _times(self, name: str) -> list[float | None]:
        """Returns the first time of an event, in the run or each member; None: it did not occur."""
        event = self._event(name)
        return event["first"] if "first" in event else [*event["times"][:1]] or [None]

    def _number(self, expr: Expr, numbers: dict[Call, float]) -> float:
        def known(part: Expr) -> Expr | None:
            if isinstance(part, Call) and part in numbers:
                return Number(Fraction(numbers[part]), part.span)
            return None

        if expr in numbers:  # fast path for many members
            return numbers[expr]
        if any(isinstance(part, Call) and part in numbers for part in within(expr)):
            return self.values.number("expect", replaced(expr, known))
        if expr not in self.constants:
            self.constants[expr] = self.values.number("expect", expr)
        return self.constants[expr]

    def _miss(
        self,
        item: Expect,
        where: str,
        value: float | None,
        bound: float | None,
        within: float | None = None,
        **_: object,
    ) -> str:
        """Returns a message about an expectation that is not met, with the values of both sides and
        their difference."""
        if value is None or bound is None:
            return f"no finite number{where}"
        off = abs(value - bound)
        shown = f"{_text(value)}{where}"
        if within is not None and within < 0:
            return f"its tolerance is {within:.3g}: it cannot be negative"
        if item.relation == "=":
            return f"{shown} is off {_text(bound)} by {off:.3g}, where {within:.3g} is allowed"
        kind = "below" if item.relation == "<" else "above"
        return f"{shown} is not {kind} {_text(bound)}: off by {off:.3g}"


def _text(x: float) -> str:
    return f"{x:.12g}"
