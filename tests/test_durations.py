"""Which tests are quick, and how shards are made, of stores made up here."""

from durations import LONG_TABLE, of_day, parted, renewed, seconds_of, shard, slow

STORE = {"a.py::f": {"x": 0.2, "y": 0.2, "z": 3.0}, "a.py::g": {"": 2.5}, "a.py::h": {"0": 2.9}}


def test_a_case_of_another_name_takes_as_long_as_the_slowest() -> None:
    assert seconds_of("a.py::f[x]", STORE) == 0.2 and seconds_of("a.py::f[new]", STORE) == 3
    assert seconds_of("a.py::new[x]", STORE) == 0
    assert parted("a.py::f[b[1]]") == ("a.py::f", "b[1]")


def test_the_shortest_cases_within_the_budget_are_quick() -> None:
    names = ["a.py::f[new]", "a.py::f[y]", "a.py::f[x]", "a.py::g", "a.py::new", "a.py::h[0]"]
    assert slow(names, set(), STORE) == {"a.py::f[new]", "a.py::g", "a.py::h[0]"}
    assert slow(names, {"a.py::h[0]"}, STORE) == {"a.py::f[new]", "a.py::g"}


def test_long_tables_run_whole_within_three_days() -> None:
    names = [f"a.py::f[{k}]" for k in range(2 * LONG_TABLE)] + ["a.py::g"]
    days = [of_day(names, day) for day in (5, 6, 7)]
    assert set().union(*days) == set(names) and sum(map(len, days)) == len(names) + 2
    assert of_day(names[1 + LONG_TABLE :], 5) == set(names[1 + LONG_TABLE :])


def test_shards_take_as_long_and_have_each_test_once() -> None:
    store = {"a.py::f": {str(k): float(k) for k in range(40)}}
    groups = {f"a.py::f[{k}]": "site" if k in (3, 39) else str(k) for k in range(40)}
    shards = [shard(groups, store, k, 4) for k in (1, 2, 3, 4)]
    assert sorted(name for names in shards for name in names) == sorted(groups)
    lengths = [sum(seconds_of(name, store) for name in names) for names in shards]
    assert max(lengths) < 1.02 * min(lengths)
    assert [sum({"a.py::f[3]", "a.py::f[39]"} <= names for names in shards)] == [1]


def test_what_was_measured_replaces_and_what_is_quick_leaves() -> None:
    found = {"a.py::g": {"": 0.1}, "a.py::f": {"x": 9.0}, "b.py::f": {"": 0.1}}
    assert renewed(STORE, found) == {
        "a.py::f": {"x": 9.0, "y": 0.2, "z": 3.0},
        "a.py::h": {"0": 2.9},
    }
