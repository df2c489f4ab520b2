"""The documentation is true: its examples compile and run, its tables are the code's."""

import doctest
import re
import shlex
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

import conftest
import pkgen
from conftest import ROOT, ran, run_pkgen
from pkgen import limits
from pkgen.back.wasm.build import missing
from pkgen.cli.commands import commands, overview
from pkgen.front.check import check
from pkgen.middle.derive import derive
from pkgen.run import build
from pkgen.source import Source
from pkgen.system import toolchain
from pkgen.system.addons import points

TUTORIAL = ROOT / "docs/tutorial.md"  # has a test of its own, test_tutorial.py
PAGES = [page for page in conftest.PAGES if page != TUTORIAL]
HERE = pytest.mark.skipif(bool(conftest.gone()), reason="add-ons have commands and pictures there")


def blocks(page: Path, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", page.read_text(), re.MULTILINE | re.DOTALL)


def beside(page: Path, folder: Path) -> None:
    """Writes the files of a page, blocks that begin with ```csv NAME."""
    found = re.findall(r"^```csv (\S+)\n(.*?)^```", page.read_text(), re.MULTILINE | re.DOTALL)
    for name, text in found:
        (folder / name).write_text(text)


def named(language: str) -> list:
    found = [(page, i, b) for page in PAGES for i, b in enumerate(blocks(page, language))]
    return [
        pytest.param(
            page,
            b,
            id=f"{page.relative_to(ROOT)}-{i}",
            marks=[pytest.mark.needs_addon]
            * (page.parent.parent.name == "addons" or _of_addons(b)),
        )
        for page, i, b in found
    ]


def _of_addons(text: str) -> bool:
    """Whether a command or an option in it is of an add-on."""
    options = {name.partition(".")[2] for kind in ("options", "pages") for name in points(kind)}
    names = {*points("commands"), "export", *(f"--{name}" for name in options if name)}
    return any(
        name in names
        for pair in re.findall(r"^\$ pkgen (\w+)|(--\w+)", text, re.M)
        for name in pair
    )


@pytest.mark.parametrize(("page", "text"), named("lag"))
def test_models_in_the_docs_run(page: Path, text: str, tmp_path: Path) -> None:
    path = tmp_path / "example.lag"
    path.write_text(text)
    beside(page, tmp_path)
    how = ("--step", "1e-3") if "\nnoise " in text else ("--rtol", "1e-8")
    ran("run", path, "--until", "0.5", *how, "-o", tmp_path / "rows.csv")
    assert len((tmp_path / "rows.csv").read_text().splitlines()) > 100


# What takes a minute is run as written but with these.
SHORTER = {
    "chart": ["--quick", "--seconds", "1", "--methods", "rk4,gauss"],
    "stability": ["--quick", "--points", "3x2", "--methods", "rk4"],
}


def without(command: list[str]) -> list[str]:
    """What the command needs that is not here, which its page names."""
    if command[0] in points("commands") and command[0] not in commands():
        return ["the add-on"]
    if command[0] == "sweep":
        return [name for name in ("pyarrow", "scipy") if find_spec(name) is None]
    live = command[0] in ("show", "site") or (command[0] == "export" and "js" in command)
    return missing() if live else []


@pytest.mark.parametrize(("page", "text"), named("console"))
def test_commands_in_the_docs_run(page: Path, text: str, tmp_path: Path) -> None:
    shutil.copytree(ROOT / "models", tmp_path / "models")
    for model in blocks(page, "lag"):
        (tmp_path / f"{model.split()[1]}.lag").write_text(model)
    beside(page, tmp_path)
    for line in text.splitlines():
        if line.startswith("$ pkgen "):
            command = shlex.split(line.removeprefix("$ pkgen "), comments=True)
            if lacking := without(command):
                pytest.skip(f"pkgen {command[0]}: not here: {', '.join(lacking)}")
            done = run_pkgen(*command, *SHORTER.get(command[0], []), cwd=tmp_path)
            assert done.returncode == 0, f"{line}\n{done.stderr}"


def test_the_ensemble_in_the_docs_runs(tmp_path: Path) -> None:
    (table,) = blocks(ROOT / "docs/commands.md", "csv")
    (tmp_path / "members.csv").write_text(table)
    model = ROOT / "models/double_pendulum.lag"
    done = ran("run", model, "--ensemble", tmp_path / "members.csv", "--until", "0.5")
    assert [row.split(",")[:2] for row in done.stdout.splitlines()[1:]] == [
        ["1", "0.5"],
        ["2", "0.5"],
    ]


def test_the_embedding_example_runs(tmp_path: Path) -> None:
    run_pkgen(ROOT / "models/double_pendulum.lag", "-o", tmp_path)
    program = tmp_path / "embed"
    flags = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", f"-I{tmp_path}"]
    sources = [ROOT / "docs/embed.c", tmp_path / "double_pendulum.c"]
    subprocess.run(["gcc", *flags, *sources, "-o", program, "-lm"], check=True)
    said = subprocess.run([program], capture_output=True, text=True, check=True).stdout.split()
    # The same motion by a method three orders better.
    done = run_pkgen(
        *("run", ROOT / "models/double_pendulum.lag", "--set", "l2=0.5", "--until", "1"),
        *("--every", "1", "--rtol", "1e-12"),
    )
    exact = [float(x) for x in done.stdout.splitlines()[-1].split(",")]
    assert [float(x) for x in said] == pytest.approx([*exact[1:3], exact[-1]], abs=5e-6)


def test_the_scenes_in_the_docs_run(tmp_path: Path) -> None:
    (text,) = [b for b in blocks(ROOT / "docs/language.md", "lag") if "scene section" in b]
    path = tmp_path / "swing.lag"
    path.write_text(text)
    rows = {}
    for scene in ("slow", "section", "all_amplitudes"):
        done = ran("run", path, "--scene", scene)
        assert re.search(r"expected: (\d) of \1 met", done.stderr)
        rows[scene] = done.stdout.splitlines()
    assert rows["slow"][0] == "t,theta,theta',T,energy" and len(rows["slow"]) == 510
    # Released at 3 rad the period is 2.5708 that of small swings, 5.157 s.
    assert rows["section"][0] == "t,theta',p_theta" and len(rows["section"]) == 1 + 19
    assert (
        rows["all_amplitudes"][-1].startswith("10000,10,") and len(rows["all_amplitudes"]) == 30001
    )


def test_the_false_claim_in_the_docs_is_refuted_as_shown(tmp_path: Path) -> None:
    page = ROOT / "docs/language.md"
    (text,) = [b for b in blocks(page, "lag") if "conserve A" in b]
    path = tmp_path / "kepler.lag"
    path.write_text(text.replace("-mu/r\n", "-mu/r + 1/(9*r^3)\n"))
    done = run_pkgen("check", "kepler.lag", cwd=tmp_path)
    assert done.returncode == 1 and done.stderr in page.read_text()


def test_the_example_of_events_runs(tmp_path: Path) -> None:
    page = ROOT / "docs/events.md"
    model = ROOT / "models/particles/thrown_stone.lag"
    (text, section, trampoline, stairs), (program,) = blocks(page, "lag"), blocks(page, "c")
    assert model.read_text().startswith(text)
    (tmp_path / "section.lag").write_text(section)
    done = run_pkgen("run", tmp_path / "section.lag", "--scene", "at_a_twelfth")
    assert done.returncode == 0 and "expected: 2 of 2 met" in done.stderr
    assert done.stdout.splitlines()[-1].startswith("40,")
    (tmp_path / "stairs.lag").write_text(stairs)
    done = run_pkgen("run", tmp_path / "stairs.lag", "--scene", "climbs")
    assert done.returncode == 0 and "expected: 2 of 2 met" in done.stderr
    equations = derive.derive(check.check_text(Source("m.lag", trampoline))[0])
    assert [x.quantity.name for x in equations.switches] == ["x"]
    run_pkgen(model, "--runtime", "-o", tmp_path)
    (tmp_path / "main.c").write_text(program)
    library = build.runtime_library(toolchain.find_toolchain()) / "libpk.a"
    flags = ["-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-DPK_RUNTIME"]
    command = ["gcc", *flags, f"-I{ROOT}/runtime/include", "main.c", "thrown_stone.c", library]
    if toolchain.find_toolchain().has_gsl:
        command += toolchain.find_toolchain().gsl_libs
    subprocess.run([*command, "-lm", "-o", "main"], cwd=tmp_path, check=True)
    said = subprocess.run([tmp_path / "main"], capture_output=True, text=True, check=True).stdout
    assert blocks(page, "text") == [said]


def test_the_readme_shows_the_c_that_its_model_becomes(tmp_path: Path) -> None:
    (tmp_path / "pendulum.lag").write_text(blocks(ROOT / "README.md", "lag")[0])
    assert run_pkgen(tmp_path / "pendulum.lag", "-o", tmp_path).returncode == 0
    assert blocks(ROOT / "README.md", "c")[0] in (tmp_path / "pendulum.c").read_text()


def test_the_embedding_example_is_shown_as_it_is() -> None:
    for name in ("embed.c", "embed_controller.c"):
        assert (ROOT / "docs" / name).read_text() in (ROOT / "docs/embedding.md").read_text()


def test_the_controller_for_firmware_is_that_of_a_run(tmp_path: Path) -> None:
    model, program = ROOT / "models/controlled/two_joint_pid.lag", tmp_path / "firmware"
    run_pkgen(model, "-o", tmp_path)
    flags = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", f"-I{tmp_path}"]
    sources = [ROOT / "docs/embed_controller.c", tmp_path / "two_joint_pid.c"]
    subprocess.run(["gcc", *flags, *sources, "-o", program, "-lm"], check=True)
    said = subprocess.run([program], capture_output=True, text=True, check=True).stdout.split()
    done = run_pkgen("run", model, "--until", "2", "--every", "2", "--record", "a,b")
    exact = [float(x) for x in done.stdout.splitlines()[-1].split(",")]
    assert [float(x) for x in said] == pytest.approx(exact[1:], abs=1e-3)  # steps of order 1
    assert abs(exact[1] - 1) > 3e-3  # and it has not arrived


def test_the_readme_is_short_and_its_python_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    text = (ROOT / "README.md").read_text()
    assert len(text.splitlines()) <= 110 and text.count("](docs/pictures/") == 1
    monkeypatch.chdir(ROOT)
    (code,) = blocks(ROOT / "README.md", "python")
    names: dict = {}
    exec(code, names)
    assert names["a"].shape == (1, 2) and names["r"]["theta1"].shape == (2001,)


@pytest.mark.needs_addon("linear")
def test_linear_models_in_the_docs_are_designed_with(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("scipy")
    monkeypatch.chdir(ROOT)

    def ran_block(page: str) -> dict:
        (code,) = blocks(ROOT / page, "python")
        names: dict = {}
        exec(code, names)
        return names

    of = ran_block("addons/linear/README.md")
    assert -of["gains"][0] == pytest.approx([of["model"].params[f"f{k}"] for k in (1, 2, 3, 4)])
    of = ran_block("docs/control.md")
    assert of["error"] == pytest.approx(of["told"], rel=0.05) and of["told"][0] < 0.01
    of = ran_block("docs/reductions.md")
    assert of["V"](0.7) == pytest.approx(92.06185109)


def test_the_controller_in_the_docs_balances(tmp_path: Path) -> None:
    sampled, model, _ = blocks(ROOT / "docs/control.md", "lag")
    (tmp_path / "position.lag").write_text(sampled)
    for period in ("0.6", "0.7"):  # 2 m/kd is 0.667 s
        run = "run", tmp_path / "position.lag", "--until", "200", "--every", "200"
        x = run_pkgen(*run, "--set", f"T={period}").stdout.splitlines()[-1].split(",")[1]
        assert (abs(float(x) - 1) < 1e-6) == (period == "0.6")
    (tmp_path / "cart_pole.lag").write_text(model)
    done = run_pkgen("run", tmp_path / "cart_pole.lag", "--scene", "balances")
    assert done.returncode == 0 and "expected: 1 of 1 met" in done.stderr
    falling = model.replace("param kp = 60 [N]", "param kp = 0 [N]")
    (tmp_path / "cart_pole.lag").write_text(falling)
    done = run_pkgen("run", tmp_path / "cart_pole.lag", "--scene", "balances")
    assert done.returncode != 0


@pytest.mark.needs_addon
def test_a_first_run_takes_one_time_in_all_pages() -> None:
    for page in (*PAGES, TUTORIAL):
        for said in re.findall(r"first run [^.;]*?(\d+ s[^,.;)]*)", page.read_text()):
            assert said == "10 s on four cores", page


def test_limits_table() -> None:
    rows = re.findall(r"^\| `(\w+)` \| ([\d,]+) \|", (ROOT / "docs/language.md").read_text(), re.M)
    documented = {name: int(value.replace(",", "")) for name, value in rows}
    assert documented == {k: v for k, v in vars(limits).items() if k.isupper()}


def test_the_page_of_errors_is_that_of_the_tests() -> None:
    text = (ROOT / "docs/dev/results/errors.md").read_text()
    cases = sorted((ROOT / "tests/generator/wrong").glob("*.txt"))
    assert len(cases) > 50
    for case in cases:
        assert case.read_text().rstrip() in text, f"{case.name}: run tools/errors_page.py"


@pytest.mark.needs_addon
@HERE
def test_the_page_of_commands_begins_with_them() -> None:
    first = blocks(ROOT / "docs/commands.md", "console")[0]
    assert first == f"$ pkgen help\n{overview()}\n"


@HERE
@pytest.mark.needs_addon
def test_links_lead_somewhere() -> None:
    for page in PAGES:
        for target in re.findall(r"\]\(([^)#]+)(?:#[^)]*)?\)", page.read_text()):
            if not target.startswith(("http:", "https:")):
                assert (page.parent / target).exists(), f"{page.name}: {target}"


@pytest.mark.parametrize("page", ["python", "derivatives"])
def test_a_page_of_python_is_what_happens(
    page: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "models").symlink_to(ROOT / "models")
    monkeypatch.chdir(tmp_path)
    name, flags = str(ROOT / f"docs/{page}.md"), doctest.ELLIPSIS
    failed, tried = doctest.testfile(name, module_relative=False, optionflags=flags)
    assert tried > 4 and not failed
    failed, tried = doctest.testmod(pkgen)
    assert tried > 4 and not failed


@pytest.mark.parametrize("library", ["jax", "torch"])
def test_gradients_in_other_libraries(
    library: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip(library)
    monkeypatch.chdir(ROOT)
    exec(next(x for x in blocks(ROOT / "docs/derivatives.md", "python") if library in x), {})
    assert "-0.0417" in capsys.readouterr().out


@pytest.mark.needs_addon
@HERE
def test_every_picture_is_shown_and_has_what_makes_it() -> None:
    done = subprocess.run(
        [sys.executable, ROOT / "tools/pictures", "no.png"], capture_output=True, text=True
    )
    assert done.returncode == 2 and "there is no no.png" in done.stdout
    made = set(done.stdout.partition("there are ")[2].strip().split(", "))
    there = {path.name for path in (ROOT / "docs/pictures").iterdir()}
    texts = "".join(page.read_text() for page in conftest.PAGES)
    shown = set(re.findall(r"pictures/(\w+\.\w+)\)", texts))
    charts = {f"chart_{m.stem}.svg" for m in (ROOT / "models").glob("*.lag")}  # of the site
    assert made == there and shown <= there <= shown | charts
