"""The table of all scenes: what a row says of what a run told, and that it is run."""

from bench import systems


def told(*expects: tuple, **report) -> dict:
    keys = ("text", "met", "value", "bound", "within")
    rest = {"method": "gauss", "step": None, "rtol": 1e-13, "seconds": 2e-3}
    return {
        "settings": {"step": None},
        "report": rest | report,
        "expects": [dict(zip(keys, e, strict=True)) for e in expects],
    }


def test_a_row_shows_what_came_nearest_to_its_bound() -> None:
    found = told(
        ("expect x = 1 within 1e-3", True, 1.0005, 1, 1e-3),
        ("expect drift(energy) < 1e-9", True, 9e-10, 1e-9, None),
        ("expect x < 7", True, 6.99, 7, None),  # no measure of an error
        ("expect y = 2 within 1", False, None, None, None),  # never compared
        drifts=[{"name": "h", "max": 1}, {"name": "energy", "max": 9e-10}],
    )
    row = systems.Row("orbit", "year", 3, 1, found)
    expected = ("orbit", "year", "3 → 1", "gauss 1e-13", "9.0e-10", "3 of 4", "9e-10 of 1e-09", "2")
    assert row.cells() == expected


def test_a_swarm_and_parts_and_nothing_expected() -> None:
    many = told(
        ("expect drift(energy) < 1e-8", True, 2e-9, 1e-8, None),
        members=7, method="verlet", step=0.25,
    )  # fmt: skip
    cells = systems.Row("a", "b", 2, 2, many).cells()
    assert cells[2:5] == ("2, 7 times", "verlet h = 0.25", "2.0e-09")
    parts = [{"method": "gauss", "rtol": 1e-9}, {"method": "exponential"}]
    cells = systems.Row("a", "b", 2, 2, told(parts=parts)).cells()
    assert cells[3:7] == ("gauss 1e-09, exponential", "–", "–", "–")


def test_a_model_is_run_scene_by_scene(capsys) -> None:
    assert systems.main(["--only", "beats"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "Scenes: 3, of models: 1, expectations met: 6 of 6."
    assert [line.split(" | ")[1].strip() for line in lines[4:7]] == ["beat", "in_phase", "against"]
