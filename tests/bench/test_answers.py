"""`python -m bench answers`: what it says of a chart's answers, and of worse ones."""

import math
from dataclasses import replace
from pathlib import Path

from bench import answers
from pkgen.analysis.chart import chart as charts


def test_worse_answers_are_found(tmp_path: Path, monkeypatch) -> None:
    path = tmp_path / "oscillator.lag"
    path.write_text("model oscillator\ncoord x\nkinetic x'^2/2\npotential x^4/4\nstart x = 1\n")
    every = charts.methods
    monkeypatch.setattr(charts, "methods", lambda _: every(["rk4", "dop853", "verlet"]))
    case = answers.Case("oscillator", str(path), ("--until", "3"))
    found = answers.judged(case, 3.0)
    assert len(found) == 8 and all(one.scanned > 100 and one.ratio >= 1 for one in found)
    assert all(one.well for one in found if one.answer.axis == "work")

    # The answer at 1e-3 is 32 evaluations, the scan's best 40: half as many again are 1.2 of that.
    measured = answers.measured

    def spoiled(*given: object):
        """Each answer with half as many evaluations again; the last is none."""
        chart, *rest = measured(*given)
        points = [replace(a.point, work=a.point.work * 3 // 2) for a in chart.answers]
        told = [replace(a, point=p) for a, p in zip(chart.answers, points, strict=True)]
        told[-1] = replace(told[-1], point=None, method=None)
        return replace(chart, answers=told), *rest

    monkeypatch.setattr(answers, "measured", spoiled)
    for one in answers.judged(case, 3.0):
        if one.answer.axis == "work":
            assert not one.well and one.rival is not None
            assert one.ratio == math.inf if one.answer.point is None else one.ratio > 1.1
    assert "by evaluations 0 of 4 within 10%" in answers.summary(
        [one for one in answers.judged(case, 1.0) if one.answer.axis == "work"]
    )
