"""The command line as a user meets it: what it prints, writes and returns."""

from __future__ import annotations

import json
from pathlib import Path

import numpy
import pytest

from conftest import MODELS, ROOT, case, ran, table, written

DOUBLE = ROOT / "models/double_pendulum.lag"
HOOP = ROOT / "models/bead_on_hoop.lag"


def test_compile_writes_two_files(pkgen, tmp_path: Path) -> None:
    done = pkgen(DOUBLE, "-o", tmp_path / "made" / "here")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    made = sorted(p.name for p in (tmp_path / "made" / "here").iterdir())
    assert made == ["double_pendulum.c", "double_pendulum.h"]


def test_only_some_kernels(pkgen, tmp_path: Path) -> None:
    assert pkgen(DOUBLE, "-o", tmp_path, "--kernels", "mass,force").returncode == 0
    text = (tmp_path / "double_pendulum.c").read_text()
    assert "double_pendulum_mass(" in text and "double_pendulum_jacobian(" not in text


STAGES = {"parse": "File", "check": "", "derive": "%0", "analyze": "Structure", "reduce": ""}


@pytest.mark.parametrize(
    ("stage", "begins"), [*STAGES.items(), ("lower", "program"), ("render", "")]
)
def test_every_stage_can_be_shown(stage: str, begins: str) -> None:
    done = ran(HOOP, f"--dump={stage}")
    assert len(done.stdout.splitlines()) > 5 and done.stdout.startswith(begins)


def test_check_finds_nothing_in_the_models(pkgen) -> None:
    for model in MODELS:
        done = pkgen("check", model)
        assert (done.returncode, done.stdout, done.stderr) == (0, "", ""), model


def test_warnings_come_as_json_with_all_that_is_written(pkgen, tmp_path: Path) -> None:
    model = written(tmp_path, "model a\nparam m = 1\ncoord x\nkinetic x'^2/2\n")
    done = pkgen(model, "-o", tmp_path, "--depfile", tmp_path / "a.d", "--json")
    (found,) = json.loads(done.stdout)["warnings"]
    assert (found["line"], found["column"]) == (2, 7) and (tmp_path / "a.d").exists()


def test_check_reports_as_json(pkgen, tmp_path: Path) -> None:
    wrong = written(tmp_path, "model wrong\ncoord x\nkinetic x'^2/2 + yy\n")
    done = pkgen("check", wrong, "--json")
    assert done.returncode == 1
    (found,) = json.loads(done.stdout)["diagnostics"]
    assert (found["line"], found["column"], found["severity"]) == (3, 18, "error")


def test_explain_shows_what_a_scene_leaves(pkgen) -> None:
    done = pkgen("explain", ROOT / "models/heavy_top.lag", "--scene", "nutation", "--canonical")
    assert done.stdout.startswith("heavy_top_nutation: ")
    assert "\n1 degree of freedom\n" in done.stdout and "Scene " not in done.stdout
    assert "dH/d(p_theta) = p_theta/I1\n" in done.stdout


def test_explain_as_json(pkgen) -> None:
    facts = json.loads(pkgen("explain", HOOP, "--json").stdout)["structure"]
    assert facts["mass_constant"] and facts["separable"] and facts["autonomous"]


def test_run_prints_rows_and_ends_exactly() -> None:
    done = ran("run", DOUBLE, "--until", "0.7", "--every", "0.2")
    names, found = table(done.stdout)
    assert names == ["t", "theta1", "theta2", "theta1'", "theta2'", "energy"]
    assert [row[0] for row in found] == [0, 0.2, 0.4, 0.2 * 3, 0.7]
    assert "energy kept to " in done.stderr


def test_run_writes_settings_beside_the_rows(pkgen, tmp_path: Path) -> None:
    out = tmp_path / "rows.csv"
    done = pkgen("run", DOUBLE, "--until", "1", "--set", "l1=30 [cm]", "-o", out)
    assert done.returncode == 0 and done.stdout == ""
    beside = json.loads(Path(f"{out}.json").read_text())
    assert beside["columns"][3] == {"name": "theta1'", "unit": "rad/s", "description": ""} | {
        "description": beside["columns"][3]["description"]
    }
    assert beside["settings"]["parameters"] == [[2, 0.3]]
    assert beside["report"]["status"] == "PK_DONE"


def test_run_writes_npy(pkgen, tmp_path: Path) -> None:
    out = tmp_path / "rows.npy"
    assert pkgen("run", HOOP, "--until", "1", "--every", "0.25", "-o", out).returncode == 0
    found = numpy.load(out)
    assert found.shape == (5,) and found["t"][-1] == 1
    assert found.dtype.names == ("t", "theta", "theta'", "energy")
    assert 0 < abs(found["theta'"][-1]) < 10
    assert Path(f"{out}.json").exists()


def test_units_in_the_header(tmp_path: Path) -> None:
    out = tmp_path / "rows.csv"
    ran("run", HOOP, "--until", "1", "--every", "0.25", "--units", "-o", out)
    lines = out.read_text().splitlines()
    assert lines[0] == "t [s],theta [rad],theta' [rad/s],energy [J]" and len(lines) == 6
    ran("run", HOOP, "--until", "1", "--every", "0.25", "--units", "-o", f"{out}.npy")
    assert numpy.load(f"{out}.npy").dtype.names[1] == "theta"


def test_units_are_shown_as_they_are_declared(pkgen, tmp_path: Path) -> None:
    path = written(
        tmp_path,
        "model motor\nparam k = 2 [N*m]\nparam c = 3 [ V*s/rad ]\nparam l = 5 [cm]\n"
        "param R = 4 [ohm]\ncoord x [rad]\nstate Q [C]\nkinetic (1 [kg])*l^2*x'^2/2\n"
        "potential k*x^2/2\nrate Q = c*x'/R\nobserve torque = k*x [N*m]\n"
        "observe u = c*x'\nobserve B = c*x'*(1 [s/m^2])\nstart x = 1\n",
    )
    done = ran("run", path, "--until", "1", "--every", "1", "--units")
    header = "t [s],x [rad],x' [rad/s],Q [C],torque [N*m],u [V],B [T],energy [J]"
    assert done.stdout.splitlines()[0] == header
    done = pkgen("explain", path)
    assert "N*m" in done.stdout and "V*s/rad" in done.stdout and "[m]" in done.stdout


def test_run_as_json_has_the_rows(pkgen) -> None:
    result = json.loads(pkgen("run", HOOP, "--until", "1", "--every", "0.5", "--json").stdout)
    assert [row[0] for row in result["rows"]] == [0, 0.5, 1]
    assert [c["name"] for c in result["columns"]] == ["t", "theta", "theta'", "energy"]


def test_starts_of_rates_and_members() -> None:
    chain = ROOT / "models/coupled_oscillators.lag"
    arguments = ["--until", "1", "--every", "1", "--start", "q[4]'=0.25", "--start", "q[1]=3 [mm]"]
    done = ran("run", chain, "--size", "n=4", *arguments)
    names, found = table(done.stdout)
    first = dict(zip(names, found[0], strict=True))
    assert (first["q[1]"], first["q[4]'"], first["q[2]"]) == (0.003, 0.25, -0.2)


def test_a_default_follows_what_is_set(pkgen) -> None:
    # k = 3 m g/l0 follows m; at the resonant k the energy at rest length differs.
    model = ROOT / "models/elastic_pendulum.lag"
    energies = []
    for setting in (["--set", "m=2"], ["--set", "m=2", "--set", "k=58.86"], ["--set", "k=58.86"]):
        done = pkgen("run", model, "--until", "0.1", "--every", "0.1", *setting)
        energies.append(table(done.stdout)[1][0][-1])
    assert energies[0] == pytest.approx(energies[1], rel=1e-14)
    assert energies[1] != pytest.approx(energies[2], rel=1e-3)


KINKED = case("bumper")


def test_the_default_method(pkgen, tmp_path: Path) -> None:
    kinked = written(tmp_path, KINKED)

    def method(*arguments: object) -> str:
        done = ran("run", *arguments, "--until", "1", "--json")
        return json.loads(done.stdout)["report"]["method"]

    assert method(DOUBLE) == "gauss" and method(DOUBLE, "--rtol", "1e-5") == "gauss"
    assert method(DOUBLE, "--rtol", "1.1e-5") == "dop853"
    assert method(kinked) == "gauss"  # its kinks are located
    chain = written(
        tmp_path,
        "model chain\nsize N = 20\ncoord q[1..N]\nkinetic sum(q[i]'^2/2, i = 1..N)\n"
        "potential sum(max(q[i] - i, 0)^2, i = 1..N)\n",
    )
    assert method(chain) == "dop853"  # of a loop they are not
    done = pkgen("run", chain, "--method", "gauss")
    assert done.returncode == 4
    assert "abs, min, max or step" in done.stderr and "dop853" in done.stderr


def test_many_rows_do_not_shorten_the_steps_of_gauss(pkgen) -> None:
    def report(every: float) -> dict:
        done = pkgen("run", DOUBLE, "--until", "5", "--every", every, "--json")
        return json.loads(done.stdout)

    few, many = report(5), report(0.001)
    assert len(many["rows"]) == 5001 and many["report"]["steps"] == few["report"]["steps"]
    assert many["rows"][-1] == few["rows"][-1]


def test_methods(pkgen) -> None:
    listed = {m["name"]: m for m in json.loads(pkgen("methods", "--json").stdout)}
    wanted = (
        "euler rk2 rk3 rk4 symplectic_euler verlet yoshida4 yoshida6 yoshida8 suzuki4 kahan_li6 "
    )
    wanted += "kahan_li8 blanes_moan4 blanes_moan6 mclachlan4 adaptive_verlet dopri5 dop853 gauss "
    wanted += "gauss1 gauss4 gauss8 lie_midpoint lie_midpoint6 rattle rattle4 rkmk4 rkmk8"
    assert set(wanted.split()) <= set(listed)
    gsl = {f"gsl_{name}" for name in ("rkf45", "rk8pd", "msadams", "msbdf", "bsimp")}
    assert gsl == {name for name in listed if name.startswith("gsl_")}
    assert (listed["gauss4"]["order"], listed["verlet"]["order"]) == (8, 2)
    assert listed["verlet"]["requires"]
    assert listed["yoshida4"]["limits"]["imaginary"] == pytest.approx(1.5734019474, abs=1e-10)
    assert listed["gauss"]["limits"] == {"imaginary": "infinite", "real": "infinite"}
    assert listed["rk2"]["growth"] == [[0, None]]
    assert listed["lie_midpoint"]["limits"] == listed["gauss"]["limits"]
    # |((1 - a z/2)/(1 + a z/2))^4 (1 - b z/2)/(1 + b z/2)| = 1 with Suzuki's a, and b = 1 - 4 a
    assert listed["rattle4"]["limits"]["real"] == pytest.approx(3.0228187908, abs=1e-6)
    assert listed["rattle4"]["limits"]["imaginary"] == pytest.approx(2.72097607, abs=1e-5)
    first, second = listed["blanes_moan6"]["growth"][:2]
    assert 3.1414 < first[0] < first[1] < 3.1424 < 6.3 < second[0] < second[1]


def test_methods_as_a_table(pkgen) -> None:
    lines = pkgen("methods").stdout.splitlines()
    rows = {words[0]: words[1:] for words in map(str.split, lines[2:]) if words}
    assert "1.7320508" in next(line for line in lines if line.startswith("rk3"))
    assert any(
        line.split()[:9] == ["verlet", "2", "1", "yes", "yes", "fixed", "2", "any", "separable"]
        for line in lines
    )
    assert any("gauss2" in line and line.count("any") == 2 for line in lines)
    assert any("euler " in line and "none" in line for line in lines)
    assert "SIAM" in " ".join(rows["mclachlan4"])


def test_longest_step(pkgen) -> None:
    def steps(*more: str) -> int:
        done = pkgen("run", DOUBLE, "--until", "1", "--every", "1", "--json", *more)
        return json.loads(done.stdout)["report"]["steps"]

    assert steps("--rtol", "1e-3", "--max-step", "0.01") == 100 > 2 * steps("--rtol", "1e-3")
