"""The progress of a sweep, read from the files in its folder only."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

from pkgen.system.exits import UsageError

from .shards import Folder, added, failures_of, head, known, part_is_whole
from .store import NOW, at_work, listed, read_json
from .sweep import LEVELS, PLAN


def status(path: Path) -> dict:
    """Returns the progress. Raises UsageError if the folder has no sweep, or damaged files."""
    said = known(path)
    if said is None:
        raise UsageError(f"--status {path}: no sweep lies there: it has no {PLAN}")
    try:
        return _status(path, said)
    except (LookupError, TypeError, ValueError, AttributeError, OverflowError) as error:
        raise UsageError(f"{path}: a file in it is not as it was written: {error}") from None


def _status(path: Path, said: dict) -> dict:
    numbers = [said[key] for key in ("members", "shard", "part")]
    folder = Folder(path, said["digest"], *numbers, bool(said["rows"]))
    name = said["name"]
    failures: dict[str, dict] = {}
    levels = (read_json(path / LEVELS) or {}).get("members") or [folder.members]
    each = [replace(folder, members=n, level=k) for k, n in enumerate(levels) if n]
    found = [_of_level(one, failures) for one in each]
    done, parts, shards_done = (sum(x) for x in zip(*found, strict=True))
    members = sum(one.members for one in each)
    given_up = [read_json(file) for file in listed(path / "failed")]
    now = read_json(path / NOW) or {}
    running = at_work(path)
    found = {
        "name": name,
        "folder": str(path),
        "members": members,
        "done": done,
        "failed": sum(one["count"] for one in failures.values()),
        "failures": sorted(failures.values(), key=lambda one: one["member"]),
        "shards": sum(len(one.shards) for one in each),
        "shards_done": shards_done,
        "shards_failed": [one for one in given_up if one],
        "parts": sum(len(one.parts) for one in each),
        "parts_done": parts,
        "running": running,
    }
    if running and now:
        seconds = time.time() - now["began"]
        flying = min(now["flying"], members - done)
        rate = (done + flying - now["before"]) / seconds if seconds > 0 else 0.0
        left = (members - done - flying) / rate if rate > 0 else None
        found |= {"engine": now["engine"], "workers": now["workers"], "host": now["host"]}
        found |= {"flying": flying, "rate": rate, "left": left}
    return found


def _of_level(folder: Folder, failures: dict[str, dict]) -> tuple[int, int, int]:
    """Returns the numbers of completed members, files and shards of a level; adds its failures."""
    done, parts, shards = 0, 0, set()
    for part in folder.parts:
        first, count = folder.of_part(part)
        if part_is_whole(folder, part, False):
            parts += 1
            done += count
            shards |= set(folder.shards_of(part))
            added(failures, read_json(folder.part_file(part))["failures"])
            continue
        for k in folder.shards_of(part):
            if (said := head(folder, k)) is None:
                shards.discard(k)
                continue
            begin, of = folder.of_shard(k)
            done += min(first + count, begin + of) - max(first, begin)
            if k not in shards:
                shards.add(k)
                added(failures, failures_of(said))
    return done, parts, len(shards)


def lines(found: dict) -> list[str]:
    """Returns the progress as text."""
    members, done = found["members"], found["done"] + found.get("flying", 0)
    said = [f"{found['name']}: {done:,} of {members:,} members ({100 * done / members:.4g}%)"]
    if found["running"] and "rate" in found:
        left = "" if found["left"] is None else f", {duration(found['left'])} left"
        workers = found["workers"]
        at = f"{workers} worker{'s' if workers != 1 else ''} on {found['host']}"
        said.append(f"running, {found['engine']}, {at}: {found['rate']:,.4g} members/s{left}")
    elif found["running"]:
        said.append("running")
    elif found["parts_done"] < found["parts"]:
        said.append(f"not running: pkgen sweep --resume {found['folder']}")
    missing = found["shards"] - found["shards_done"]
    given_up = len(found["shards_failed"])
    said.append(
        f"shards: {found['shards_done']} done, {missing - given_up} missing, {given_up} failed"
    )
    said += [
        f"  shard {one['shard']}, tried {one['tried']} times: {one['why']}"
        for one in found["shards_failed"][:10]
    ]
    said += failed(found)
    whole = found["parts_done"] == found["parts"]
    parts = "" if whole else f", {found['parts_done']} of {found['parts']} files"
    said.append(f"data set: {found['folder']}/data{parts}")
    return said


def failed(found: dict) -> list[str]:
    """Lists the failed members by status, with the reason why the first of them failed."""
    if not found["failed"]:
        return []
    said = [f"{found['failed']:,} of {found['members']:,} members failed"]
    for one in found["failures"]:
        reason = one["reason"] or f"at t = {one['t']:.9g}"
        said.append(f"  {one['count']:,} {one['status']}, first member {one['member']}: {reason}")
    return said


def duration(seconds: float) -> str:
    if seconds < 100:
        return f"{seconds:.3g} s"
    minutes = round(seconds / 60)
    if minutes < 100:
        return f"{minutes} min"
    return f"{minutes // 60} h {minutes % 60:02d}" if minutes < 6000 else f"{minutes // 1440} days"
