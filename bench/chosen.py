"""`--only TEXT` of the benchmarks: the cases whose name has it; an error where there are none."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TypeVar

Case = TypeVar("Case")


def chosen(cases: Iterable[Case], text: str, name: Callable[[Case], str]) -> list[Case]:
    """Raises SystemExit with what there is."""
    cases = list(cases)
    found = [case for case in cases if text in name(case)]
    if not found:
        raise SystemExit(
            f"bench: --only {text}: no such case; there are: {', '.join(map(name, cases))}"
        )
    return found
