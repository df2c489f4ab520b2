"""Whole choices, of motions that are made up: what is tried, given up, left out and said."""

import math
from dataclasses import dataclass, field, replace
from types import SimpleNamespace

import pytest
from test_accuracy_search import ADAPTIVE, method, trial

from conftest import case
from pkgen.analysis.chart import wide
from pkgen.analysis.chart.measure import Program
from pkgen.analysis.choose import lines, parts, record, reference, search
from pkgen.analysis.choose.candidates import Candidate
from pkgen.analysis.choose.choice import Choice
from pkgen.analysis.choose.choose import choose
from pkgen.analysis.choose.reference import Check, Task
from pkgen.analysis.choose.search import Found
from pkgen.analysis.choose.trials import Trial
from pkgen.analysis.choose.whole import Whole
from pkgen.compiler import compile_model
from pkgen.run.build import build_library
from pkgen.run.settings import NOTHING, Settings, Shown
from pkgen.source import Source
from pkgen.system.exits import BuildError

GAUSS = Candidate(method("gauss", 16, "adaptive"), "land", "")
MADE = (trial(GAUSS, 1e-15, 1e-12, 1.0), 500.0, 0.0, 1e-12, 0.0)  # until half of 1000
SETTINGS = Settings(
    method="gauss",
    until=1.0,
    every=0.1,
    step=None,
    rtol=1e-9,
    atol=1e-9,
    iteration="newton",
    max_steps=10,
    max_step=None,
    parameters=(),
    members=(),
    inputs=(),
    start_q=(),
    start_v=(),
)


@dataclass
class Motion:
    """Trials of one that takes so long, and may end; errors are as the tolerance, but of some
    methods, which do not arrive where theirs is infinite."""

    until: float
    rate: float  # seconds of the processor for a unit of time
    ends: float = math.inf
    errors: dict[str, float] = field(default_factory=dict)
    bounds: list[float | None] = field(default_factory=list)  # of steps, of each trial
    spent: float = 0.0
    without: bool = False
    exact: object = None
    between: object = None
    ignored: frozenset[int] = frozenset()

    @property
    def settings(self) -> SimpleNamespace:
        return SimpleNamespace(until=self.until, every=1.0, watched=NOTHING)

    def attempt(
        self,
        name: str,
        setting: float,
        rows: str,
        span: float,
        *,
        cap: float = 0.0,
        max_step: float | None = None,
        **_: float,
    ) -> Trial:
        self.bounds.append(max_step)
        candidate = Candidate(method(name, 8, "adaptive"), rows, "")
        t = min(span, self.ends, cap / self.rate if cap else math.inf)
        slow, own = t < min(span, self.ends), self.errors.get(name, setting)
        error = own if t == span else math.inf
        self.spent += t * self.rate
        return trial(
            candidate,
            setting,
            error,
            t * self.rate,
            arrived=error < math.inf,
            slow=slow,
            t=t,
            max_step=max_step,
            reason="" if slow or t == span else "the step size fell to round-off",
            columns=(error,),
        )

    def keep_as_exact(self) -> tuple[float, ...]:
        return (1.0,)

    def look_between(self, *_: object) -> None:
        pass


def chosen(motion: Motion, **more: float) -> Choice:
    return choose(Task(motion, (ADAPTIVE,), ("dop853", "gauss"), True, 1e-6), **more)


def test_where_one_method_of_another_family_does_not_arrive_the_next_is_asked() -> None:
    stiff = Motion(1.0, 1e-4, errors={"dop853": math.inf, "radau": 1e-3})
    found = reference.find(Task(stiff, (), ("gauss", "radau", "dop853"), True, 1e-6), 1.0)
    assert (found.method, found.against, found.floor) == ("gauss", "radau", 1e-3)
    stiff.errors["radau"] = 1e-10
    found = reference.find(Task(stiff, (), ("gauss", "radau", "dop853"), True, 1e-6), 1.0)
    assert (found.against, found.floor) == ("gauss", 1e-14)


def test_what_round_off_hides_is_asked_of_a_run_in_more_digits() -> None:
    noisy = Motion(1.0, 1e-4, errors={"gauss": 1e-3, "radau": 1e-3})
    words = (noisy, (ADAPTIVE,), ("gauss", "radau"), True, 1e-6)
    assert choose(Task(*words)).horizon is not None
    finer = Motion(1.0, 1e-3, exact="rows of it")
    found = choose(Task(*words, precise=lambda: finer))
    assert (found.method, found.horizon, noisy.exact) == ("dop853", None, "rows of it")
    assert found.check.against == "gauss in more digits" and 0 < found.check.floor < 1e-16
    # One that is no better says nothing; of several that miss the nearest is run.
    noisy.exact = None
    found = choose(Task(*words, precise=lambda: Motion(1.0, 1e-3, errors={"gauss": 1e-2})))
    assert found.horizon is not None and noisy.exact is None
    noisy.errors["dop853"] = 1e-4
    found = choose(Task(*words, precise=lambda: finer))
    assert (found.method, found.horizon, found.expected) == ("dop853", 10.0, 1e-4)
    said = lines(found, "s", brief=False)[1]
    assert "holds until t = 10 s" in said and "off by 1.0e-04 of one in more digits" in said


def test_an_error_of_a_wider_library_is_not_a_missing_type(monkeypatch) -> None:
    def fails(*_: object, **__: object) -> None:
        raise BuildError("undefined reference to pk_own")

    monkeypatch.setattr(wide, "build_library", fails)
    with pytest.raises(BuildError, match="pk_own"):
        wide.library({}, "model", ("gauss",))
    monkeypatch.setattr(wide, "precise_tools", lambda _: None)
    assert wide.library({}, "model", ("gauss",)) is None


def test_a_wider_type_is_one_that_a_program_compiles_with(monkeypatch) -> None:
    tools = wide.precise_tools("long double")
    assert tools is not None and "-DPK_LONG_DOUBLE" in tools.flags
    monkeypatch.setattr(wide, "PROBE", "#include {}\nint main(void) {{ return {}() }}\n")
    assert wide.precise_tools("long double") is None


def test_a_run_is_not_judged_by_itself() -> None:
    """Where no tighter setting is left, the reference's tightest runs are compared."""
    motion = Motion(1000.0, 1e-4, errors={"dop853": 1e-7, "gauss": 1e-4})
    check = Check(*MADE, against="dop853")
    best = Found(ADAPTIVE, trial(ADAPTIVE, search.TIGHTEST, 1e-7, 1.0))
    kept = Whole(Task(motion, (ADAPTIVE,), ("gauss",), True, 1e-6), check, 5.0).verified(
        best, [best]
    )
    assert kept.candidate.name == "gauss" and kept.horizon is not None


def test_an_expectation_that_round_off_blurs_does_not_forbid_what_is_recorded() -> None:
    class Blurred(Motion):
        """Behind what is recorded stands one expectation, known to 1e-3 of itself."""

        ignored: frozenset[int] = frozenset()
        watched = SimpleNamespace(columns=lambda: ["expectation 1"])
        settings = SimpleNamespace(until=1.0, every=1.0, watched=watched)

        def keep_as_exact(self) -> tuple[float, ...]:
            return (1.0, 1.0)

        def attempt(self, *words: object, **more: float) -> Trial:
            made = super().attempt(*words, **more)
            holds = 1.0 if self.ignored else 0.0
            return replace(made, columns=(*made.columns, 1e-3), holds=holds)

    found = reference.find(Task(Blurred(1.0, 1e-4), (), ("gauss", "dop853"), True, 1e-6), 1.0)
    assert (found.ignored, found.unsure) == ((), (1,))
    assert found.floor == 1e-14 and found.holds == 1.0


def test_the_coefficients_of_an_exact_flow_are_rounded_once() -> None:
    flow = Motion(1.0, 1e-4, errors={"exponential": 0.0})
    asked = Task(flow, (), ("exponential", "gauss"), True, 1e-15)
    assert reference.find(asked, 1.0).floor == 2.0**-49
    said = lines(choose(asked), "s", brief=False)
    assert "1e-15 is not kept: for round-off the tightest run is known to 1.8e-15" in said[1]


def test_what_takes_too_long_as_a_whole_is_tried_in_part_and_said_to_be() -> None:
    short = chosen(Motion(1000.0, 1e-4))
    assert short.given_up is None and short.check.span == 270.0 and 1e-7 < short.expected < 1e-6
    assert not any("warning" in line for line in lines(short, "s", brief=False))
    long = chosen(Motion(1000.0, 1e-4), whole_seconds=0.05)
    assert long.given_up.t == pytest.approx(500.0) and long.method == "dop853"
    # It is that of the part, of which errors grow to the accuracy; what it comes to is not known.
    assert 1e-7 < long.setting * 1000 / 270 < 1e-6 and long.expected == math.inf
    assert long.run_seconds == pytest.approx(0.1) and long.horizon is None
    said = lines(long, "s", brief=False)
    assert "expected error" not in said[0]
    assert "tried until t = 270 s alone" in said[1]
    # How far it came in how long, how far the run is to go, in how long, and what can be done.
    assert "given up after 0.05 s at t = 500 s." in said[1]
    assert "goes to t = 1000 s, by the part that was tried in 0.1 s; --until or a" in said[1]
    assert "Ctrl-C keeps" in said[1]
    assert record(long)["unverified_from"] == 270.0


def test_where_time_is_in_the_equations_what_is_exact_has_short_steps() -> None:
    motion = Motion(1000.0, 1e-7)
    asked = Task(motion, (ADAPTIVE,), ("gauss", "dop853"), True, 1e-6, timed=True)
    assert choose(asked).max_step is None
    # Two runs whose steps end at the same times would leap over the same.
    assert motion.bounds[:3] == [1.0, 0.7, 0.7] and set(motion.bounds[3:]) == {None}
    # Where none but the reference keeps it, that is what is run, with its steps.
    motion = Motion(1000.0, 1e-7, errors={"dop853": 1e-5})
    asked = Task(motion, (ADAPTIVE,), ("gauss", "radau"), True, 1e-6, timed=True)
    found = choose(asked)
    assert (found.method, found.max_step, found.horizon) == ("gauss", 1.0, None)
    said = lines(found, "", brief=False)
    assert "gauss, rtol 1e-15, steps of at most 1, expected" in said[0] and len(said) == 1
    assert found.settings(SETTINGS).max_step == 1.0
    assert found.settings(replace(SETTINGS, max_step=0.5)).max_step == 0.5
    both = parts.with_choices(SETTINGS, (found, found)).parts
    assert both[1].max_step == 1.0
    # As over a part of a scene, so over all of it.
    motion = Motion(1000.0, 1e-4, errors={"dop853": 1e-5})
    asked = Task(motion, (ADAPTIVE,), ("gauss", "radau"), True, 1e-6, timed=True)
    assert choose(asked).max_step == 0.7 and motion.bounds[-2:] == [1.0, 0.7]


def test_why_two_runs_differ_is_not_claimed_to_be_known() -> None:
    found = chosen(Motion(1000.0, 1e-7, errors={"gauss": 1e-3}))
    assert found.horizon is not None
    said = lines(found, "s", brief=False)[1]
    assert "differ by 1.0e-03, by round-off that the motion magnifies or by something" in said


@pytest.mark.parametrize("rate", [1e-4, 1e-7])
def test_of_a_motion_that_ends_is_said_no_more_than_that(rate) -> None:
    ended = chosen(Motion(1000.0, rate, ends=900.0))
    assert ended.check.ends == "the step size fell to round-off" and ended.horizon is None
    assert ended.setting == 1e-15 and ended.expected == math.inf
    said = lines(ended, "s", brief=False)
    assert len(said) == 2 and "is not promised: no method arrives" in said[1]


def test_a_part_starts_as_the_whole_does_by_its_own_numbers() -> None:
    part = SimpleNamespace(coordinates=(1, 3, 5))  # the last one a state, phi
    show = (Shown("q", 3, "d"), Shown("v", 0, "a'"), Shown("v", 5, "phi"), Shown("v", 1, "b'"))
    whole = replace(
        SETTINGS,
        parameters=((1, 2.5),),
        start_q=((0, 0.1), (1, 0.2), (3, 0.4)),
        start_v=((2, 3.0), (3, 4.0)),
        show=show,
    )
    alone = parts.alone(part, whole)
    assert alone.start_q == ((0, 0.2), (1, 0.4)) and alone.start_v == ((1, 4.0),)
    assert alone.parameters == whole.parameters
    assert [(c.kind, c.index) for c in alone.show] == [("q", 1), ("v", 2), ("v", 0)]


MEMBERS = case("accuracy_choice_chain")


@pytest.mark.parametrize("size", [20, 3])
def test_the_same_doubles_are_given_to_more_digits(size: int) -> None:
    """Of loops each member of a family, of members written out each as a parameter."""
    compilation = compile_model(Source("chain.lag", MEMBERS), sizes={"N": size}, unroll=16)
    program = build_library(compilation.files, "chain")
    moved = (1, 1, 7.0) if not compilation.equations.dense else None
    settings = replace(SETTINGS, parameters=((0, 3.0),), members=(moved,) if moved else ())
    first = Program(program, settings)
    given = first.given()
    assert Program(program, given).start == first.start
    assert (not compilation.equations.dense) == (size == 20) == bool(given.members)
    values = [*given.parameters, *(x[::2] for x in given.members)]
    assert (0, 3.0) in values and len(values) == size + 2
    assert 9.0 in [x for _, x in values] and (not moved or moved in given.members)
