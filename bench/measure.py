"""Rounds: every contender takes its turn at every setting and start, again and again.

The machine drifts (clock, neighbours), so nothing is timed in one go: a round visits all, the next
one in another order, and ratios are formed within a round. Rounds go on until the quartiles of
each time are close, or the budget is used up.
"""

from __future__ import annotations

import random
import statistics
import time
from dataclasses import dataclass, field

from . import matching
from .builds import BUILDS, QUICK_BUILDS, Broken, Build, Refused, Unavailable
from .contender import Contender, Failed, Inapplicable, Session
from .models import Model, error

CLOSE = 0.04  # quartile distance over median, the median of it over a contender's times
FEWEST_ROUNDS = 3
SLOW_ROUNDS = 3
# Tighter settings are left out once one integration takes longer.
# "steps": of methods that solve equations in each of many.
LONGEST = {"C": 0.03, "pkgen": 0.03, "Python": 0.4, "steps": 0.3}


@dataclass(frozen=True)
class Effort:
    """How long to measure."""

    starts: int
    rounds: int
    seconds: float  # a model's budget of rounds
    each: float  # seconds a time is averaged over
    builds: tuple[Build, ...]  # of pkgen and of the peers in C that are given as source


FULL = Effort(starts=10, rounds=9, seconds=110, each=0.002, builds=BUILDS)
QUICK = Effort(starts=2, rounds=3, seconds=8, each=0.0005, builds=QUICK_BUILDS)
# For the tests, of pkgen's methods alone.
ALONE = Effort(starts=1, rounds=2, seconds=2, each=0.0, builds=QUICK_BUILDS[:1])


@dataclass
class Track:
    """What a contender did on one model: seconds[round][setting][start]."""

    contender: Contender
    session: Session
    settings: list[float]
    trials: dict[str, float]  # seconds of each build that was tried
    errors: list[list[float]] = field(default_factory=list)
    seconds: list[list[list[float]]] = field(default_factory=list)

    @property
    def name(self) -> str:
        return self.contender.name

    def curve(self) -> list[matching.Point]:
        """With the median of each time over the rounds."""
        count = len(self.errors[0])
        typical = [
            [statistics.median(r[i][k] for r in self.seconds) for k in range(count)]
            for i in range(len(self.settings))
        ]
        return matching.curve(self.settings, self.errors, typical)

    def matched(self, target: float) -> list[matching.Match | None]:
        """Round by round: the brackets are those of every round, since errors do not vary."""
        return [
            matching.seconds_at(matching.curve(self.settings, self.errors, r), target)
            for r in self.seconds
        ]

    def unrest(self) -> float:
        """The typical quartile distance of its times, relative to their medians."""
        if len(self.seconds) < 2:
            return float("inf")
        return statistics.median(
            matching.spread([r[i][k] for r in self.seconds])
            for i in range(len(self.settings))
            for k in range(len(self.errors[i]))
        )


@dataclass(frozen=True)
class Comparison:
    """All of one model: the tracks, and who could not take part, with the reason."""

    model: Model
    tracks: list[Track]
    refused: Refused


def compare(model: Model, contenders: list[Contender], exact, effort: Effort, say) -> Comparison:
    starts = model.starts(effort.starts)
    tracks, refused = [], {}
    for contender in contenders:
        try:
            tracks.append(_enter(contender, model, exact[0], effort))
        except (Unavailable, Failed) as reason:
            broken = (
                contender.group == "pkgen"
                and isinstance(reason, Failed)
                and not isinstance(reason, Inapplicable)
            )
            refused[contender.name] = Broken(str(reason)) if broken else reason
    say(f"{model.name}: {len(tracks)} contenders ready, {len(refused)} refused")
    order = random.Random(2385)
    begin = time.monotonic()
    for count in range(effort.rounds):
        turns = [t for t in tracks if not t.contender.slow or count < SLOW_ROUNDS]
        order.shuffle(turns)
        for track in turns:
            _round(track, model, starts, exact, effort)
        restless = max(t.unrest() for t in turns)
        spent = time.monotonic() - begin
        say(f"{model.name}: round {count + 1}, {spent:.0f} s, quartiles within {restless:.1%}")
        if count + 1 >= FEWEST_ROUNDS and (restless < CLOSE or spent > effort.seconds):
            break
    for track in tracks:
        track.session.close()
    return Comparison(model, [t for t in tracks if t.settings], refused)


def _enter(contender: Contender, model: Model, exact, effort: Effort) -> Track:
    """Leave out settings that fail or take too long, then choose the fastest of the builds."""
    sessions = contender.open(model, effort.builds)
    settings = contender.settings(model)
    usable, trouble = [], Failed("every setting takes too long")
    for setting in settings:  # also what compiles at its first call does so now
        try:
            sessions[0].integrate(setting, model.start, model.t_end, 0.0)
            took, _ = sessions[0].integrate(setting, model.start, model.t_end, 0.0)
        except Failed as reason:
            trouble = reason
            continue
        if took > LONGEST[contender.group]:
            break
        usable.append(setting)
    if not usable:
        for session in sessions:
            session.close()
        raise trouble
    trials = _trials(sessions, usable, model, effort)
    best = min(sessions, key=lambda s: trials[s.flags])
    for session in sessions:
        if session is not best:
            session.close()
    return Track(contender, best, usable, trials)


def _trials(sessions, settings, model: Model, effort: Effort) -> dict[str, float]:
    """Median seconds of each build at a middle setting, in turns."""
    if len(sessions) == 1:
        return {sessions[0].flags: 0.0}
    middle = settings[len(settings) // 2]
    found: dict[str, list[float]] = {s.flags: [] for s in sessions}
    for _ in range(3):
        for session in sessions:
            took, _ = session.integrate(middle, model.start, model.t_end, effort.each)
            found[session.flags].append(took)
    return {flags: statistics.median(times) for flags, times in found.items()}


def _round(track: Track, model: Model, starts, exact, effort: Effort) -> None:
    each = 0.0 if track.contender.slow else effort.each
    first = not track.errors
    found, failing = [], []
    for setting in track.settings:
        times, errors = [], []
        for start, final in zip(starts, exact, strict=True):
            try:
                took, state = track.session.integrate(setting, start, model.t_end, each)
            except Failed:
                took, state = float("nan"), [float("nan")] * len(final)
                failing.append(setting)
            times.append(took)
            errors.append(error(state, final))
        found.append(times)
        if first:
            track.errors.append(errors)
    if first and failing:  # a setting that fails at one start is none
        keep = [i for i, s in enumerate(track.settings) if s not in failing]
        track.settings = [track.settings[i] for i in keep]
        track.errors = [track.errors[i] for i in keep]
        found = [found[i] for i in keep]
    track.seconds.append(found)
