"""Measured times of tests decide which are quick (`make test`) and balance the shards of the rest.

    make durations                        measures all and writes tests/durations.json
    python tests/durations.py TIMES.xml   writes it from JUnit files of other runs

The store holds only functions that take more than `make test` gives one. A case that is not in it
takes as long as the slowest of its function. So a case of another name is never quick by accident.
"""

import json
import sys
import xml.etree.ElementTree as ElementTree
from collections import defaultdict
from collections.abc import Iterable
from math import inf
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
STORE = ROOT / "tests" / "durations.json"
QUICK, BUDGET = 1.0, 0.4  # s: of a case, of a function's cases
SEED, SEEDS = 3.0, 1.0  # s: the same for cases by a fixed seed
LONGEST = 0.6  # s: of a case of these
LONG_TABLE, DAYS = 50, 3  # a function with more long cases runs a third of them each day
KEPT = {
    "tests/test_docs.py": "examples of the docs run",
    "tests/messages/test_pages.py": "messages are read whole",
    "tests/runs/test_runs.py": "each row is a test of its own",
    "test_names_and_comments_are_never_markup_or_script": "no other test covers it",
    "test_models_compile_without_sympy": "no other test covers it",
    "test_a_value_out_of_bounds_is_refused_in_words": "no other test covers it",
    "test_a_communication_step_has_an_end": "an FMU once never returned",
    "test_answers_are_commands_that_keep_their_word": "the answer of a chart is run",
}
Functions = dict[str, dict[str, float]]  # seconds by path::function and by what is in its brackets


def parted(name: str) -> tuple[str, str]:
    """`path::function` and the parameters of a test's id."""
    function, _, parameters = name.partition("[")
    return function, parameters.removesuffix("]")


def read() -> Functions:
    if not STORE.exists():  # `make durations` begins anew
        return {}
    stored = json.loads(STORE.read_text(encoding="utf-8"))
    return {f"{path}::{name}": of for path, names in stored.items() for name, of in names.items()}


def seconds_of(name: str, store: Functions) -> float:
    function, parameters = parted(name)
    of = store.get(function, {"": 0.0})
    return of.get(parameters, max(of.values()))


def slow(names: Iterable[str], seeds: set[str], store: Functions) -> set[str]:
    """The names that `make test` leaves out: the shortest cases within a budget are quick.

    `seeds` are the names of cases by a fixed seed, which have time of their own.
    """
    functions = defaultdict(list)
    for place, name in enumerate(names):
        path, _, function = parted(name)[0].partition("::")
        if parted(name)[0] in store:
            kind = "kept" if KEPT.keys() & {path, function} else name in seeds
            functions[path, function, kind].append((seconds_of(name, store), place, name))
    found = set()
    for (*_, kind), cases in functions.items():
        most, budget = {"kept": (LONGEST, inf), True: (SEED, SEEDS), False: (QUICK, BUDGET)}[kind]
        spent = 0.0
        for number, (seconds, _, name) in enumerate(sorted(cases)):
            if seconds <= most and (number == 0 or spent + seconds <= budget):
                spent += seconds
            else:
                found.add(name)
    return found


def of_day(names: Iterable[str], day: int) -> set[str]:
    """The names that the shards of a day run: each name has its turn within DAYS."""
    functions = defaultdict(list)
    for name in names:
        functions[parted(name)[0]].append(name)
    tables = (x[day % DAYS :: DAYS] if len(x) > LONG_TABLE else x for x in functions.values())
    return {name for table in tables for name in table}


def shard(groups: dict[str, str], store: Functions, number: int, count: int) -> set[str]:
    """The names of one of `count` shards of the same length; names of one group stay together."""
    together = defaultdict(list)
    for name, group in groups.items():
        together[group].append(name)
    lengths = {group: sum(seconds_of(n, store) for n in names) for group, names in together.items()}
    loads, shards = [0.0] * count, [set() for _ in range(count)]
    for group in sorted(together, key=lambda group: (-lengths[group], group)):
        least = loads.index(min(loads))
        loads[least] += lengths[group] + 0.01
        shards[least].update(together[group])
    return shards[number - 1]


def measured(files: Iterable[Path]) -> Functions:
    """The longest times of JUnit files."""
    found: Functions = defaultdict(dict)
    for case in (c for file in files for c in ElementTree.parse(file).getroot().iter("testcase")):
        if case.find("skipped") is None:
            path = case.get("classname", "").replace(".", "/") + ".py"
            function, parameters = parted(f"{path}::{case.get('name', '')}")
            seconds = float(case.get("time", 0))
            found[function][parameters] = max(seconds, found[function].get(parameters, 0.0))
    return found


def kept(cases: dict[str, float]) -> dict[str, float]:
    """Without cases that take as long as the slowest one, which all others are taken to be."""
    name, most = max(cases.items(), key=lambda case: case[1])
    return {n: float(f"{s:.2g}") for n, s in sorted(cases.items()) if n == name or s < 0.8 * most}


def renewed(store: Functions, found: Functions) -> Functions:
    """The store with what was measured; functions that are within the budget leave it."""
    new = dict(store)
    for function, cases in found.items():
        if sum(cases.values()) > BUDGET or function in store:
            new[function] = kept(store.get(function, {}) | cases)
        if max(new.get(function, {"": 0.0}).values()) * len(cases) <= BUDGET:
            new.pop(function, None)
    return new


def write(functions: Functions) -> None:
    stored = defaultdict(dict)
    for function, cases in sorted(functions.items()):
        path, _, name = function.partition("::")
        file = ROOT / path
        if file.exists() and f"def {name}(" in file.read_text(encoding="utf-8"):
            stored[path][name] = cases
    files = [
        json.dumps(path) + ": " + json.dumps(of).replace("{", "{\n", 1).replace("}, ", "},\n")
        for path, of in stored.items()
    ]
    STORE.write_text("{\n" + ",\n".join(files) + "\n}\n", encoding="utf-8")
    print(f"{STORE}: {sum(map(len, stored.values()))} functions")


if __name__ == "__main__":
    write(renewed(read(), measured(map(Path, sys.argv[1:]))))
