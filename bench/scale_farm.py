"""A farm of workers that die, and a sweep on it, event by event.

A shard is given to a worker that is free; one whose worker dies is given out again, three times
(sweep/sweep.py); workers come back. A worker that is thought dead and is not delivers its shard
late: its file replaces one of the same bytes. What a sweep promises is demanded at the end.
"""

from __future__ import annotations

import heapq
import random
from dataclasses import dataclass

TRIES = 3


@dataclass(frozen=True)
class Farm:
    shards: int
    seconds: float  # of a shard, in the mean; each is between half and twice that
    workers: int
    between: float  # mean seconds between failures of a worker
    back: float = 300.0  # seconds until a worker is back
    late: float = 0.01  # part of dead workers that deliver after all
    bad: float = 1e-5  # part of shards that kill whoever runs them
    seed: int = 1


@dataclass
class Found:
    wall: float
    died: int
    again: int
    given_up: int
    twice: int  # files written twice, of the same bytes
    lost: float  # part of all work


def simulated(farm: Farm) -> Found:
    rng = random.Random(farm.seed)
    waiting = list(range(farm.shards - 1, -1, -1))
    tries = [0] * farm.shards
    done = [0] * farm.shards
    failed: set[int] = set()
    bad = {k for k in range(farm.shards) if rng.random() < farm.bad}
    events: list[tuple[float, int, str, int]] = []
    free, now, count = farm.workers, 0.0, 0
    work = lost = 0.0
    died = again = twice = running = 0

    def push(at: float, what: str, shard: int) -> None:
        nonlocal count
        count += 1
        heapq.heappush(events, (at, count, what, shard))

    while waiting or running:
        while free and waiting:
            shard = waiting.pop()
            if done[shard] or shard in failed:  # delivered late meanwhile
                continue
            tries[shard] += 1
            free -= 1
            running += 1
            takes = farm.seconds * 2 ** rng.uniform(-1, 1)
            ends = rng.expovariate(1 / farm.between)
            if shard in bad:
                ends = min(ends, takes / 2)
            if ends < takes:
                push(now + ends, "dies", shard)
                lost += ends
                if rng.random() < farm.late and shard not in bad:
                    push(now + takes, "late", shard)
            else:
                push(now + takes, "done", shard)
                work += takes
        if not events:
            break
        now, _, what, shard = heapq.heappop(events)
        if what in ("done", "late"):
            twice += done[shard]
            done[shard] = 1
        if what == "done":
            running -= 1
            free += 1
        elif what == "dies":
            running -= 1
            died += 1
            push(now + farm.back, "back", shard)
            if tries[shard] >= TRIES:
                failed.add(shard)
            else:
                again += 1
                waiting.append(shard)
        elif what == "back":
            free += 1
    failed = {k for k in failed if not done[k]}
    # Nothing is lost, nothing counts twice: each shard is in the data set or is named as failed.
    assert all(done[k] + (k in failed) == 1 for k in range(farm.shards))
    return Found(now, died, again, len(failed), twice, lost / (work + lost))
