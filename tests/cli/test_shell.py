"""What a shell and `man` have of pkgen: made of the tables of the help."""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from conftest import ROOT, ran, run_pkgen
from pkgen.cli.commands import commands, parser_of

COMMANDS = commands()


def tool(name: str) -> str:
    found = shutil.which(name)
    if found is None:
        pytest.skip(f"{name} is missing")
    return found


def completion(shell: str, folder: Path) -> Path:
    pytest.importorskip("shtab", reason="shtab is missing: pip install shtab")
    done = ran("completion", shell)
    path = folder / f"pkgen.{shell}"
    path.write_text(done.stdout)
    return path


def offered(shell: str, script: Path, *words: str) -> set[str]:
    """What the shell completes behind these words."""
    quoted = " ".join(f"'{word}'" for word in words)
    if shell == "bash":
        text = (
            f"source {script}; COMP_WORDS=({quoted}); COMP_CWORD={len(words) - 1}; "
            "_shtab_pkgen pkgen; printf '%s\\n' \"${COMPREPLY[@]}\""
        )
        command = [tool("bash"), "--norc", "-c", text]
    else:
        line = " ".join(words)
        command = [tool("fish"), "--no-config", "-c", f"source {script}; complete -C '{line}'"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
    return {line.partition("\t")[0] for line in done.stdout.split("\n") if line}


@pytest.mark.needs_addon
@pytest.mark.parametrize("shell", ["bash", "fish"])
def test_completion(shell: str, tmp_path: Path) -> None:
    tool(shell)
    script = completion(shell, tmp_path)
    assert set(COMMANDS) <= offered(shell, script, "pkgen", "")
    assert offered(shell, script, "pkgen", "ex") == {"explain", "export"}
    assert "gauss4" in offered(shell, script, "pkgen", "run", "x.lag", "--method", "gau")
    assert offered(shell, script, "pkgen", "run", "--sce") == {"--scene"}
    assert "README.md" in offered(shell, script, "pkgen", "run", "-o", "README")


@pytest.mark.needs_addon
def test_completion_of_zsh_is_read(tmp_path: Path) -> None:
    zsh = tool("zsh")
    script = completion("zsh", tmp_path)
    done = subprocess.run([zsh, "-f", "-n", script], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "") and "--scene" in script.read_text()


def test_without_shtab_it_is_told(tmp_path: Path) -> None:
    script = (
        "import sys; sys.modules['shtab'] = None\n"
        "from pkgen.__main__ import main; sys.exit(main(['completion', 'bash']))"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.returncode == 2 and "pip install shtab" in done.stderr


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("man1")
    assert run_pkgen("manual", "-o", folder).returncode == 0
    return folder


@pytest.mark.needs_addon
def test_each_command_has_its_page(pages: Path) -> None:
    names = {path.name for path in pages.iterdir()}
    assert names == {"pkgen.1", *(f"pkgen-{name}.1" for name in COMMANDS)}
    for name in COMMANDS:
        text = (pages / f"pkgen-{name}.1").read_text().replace("\\-", "-").replace("\\:", "")
        for action in parser_of(name)._actions:
            assert all(option in text for option in action.option_strings), (name, action)
            if action.help not in (None, argparse.SUPPRESS):
                assert " ".join(action.help.replace("%%", "%").split()) in text, (name, action)
        assert COMMANDS[name].module.EXAMPLES.strip().split("\n")[0] in text


@pytest.mark.needs_addon
def test_man_reads_the_pages(pages: Path) -> None:
    man = tool("man")
    for path in sorted(pages.iterdir()):
        command = [man, "-l", "--warnings", "-Tutf8", path]
        done = subprocess.run(command, capture_output=True, text=True)
        assert (done.returncode, done.stderr) == (0, ""), path.name
        plain = re.sub(r".\x08|\x1b\[[0-9;]*m", "", done.stdout)
        assert "NAME" in plain and len(plain.splitlines()) > 20


@pytest.mark.needs_addon
def test_mandoc_finds_nothing(pages: Path) -> None:
    command = [tool("mandoc"), "-Tlint", "-Wwarning", *sorted(pages.iterdir())]
    done = subprocess.run(command, capture_output=True, text=True)
    found = [x for x in done.stdout.splitlines() if "missing date" not in x]  # bytes stay the same
    assert found == []


def test_they_are_installed(tmp_path: Path) -> None:
    pytest.importorskip("shtab", reason="shtab is missing: pip install shtab")
    pkgen = Path(sys.executable).with_name("pkgen")
    command = ["make", "-s", "install-shell", f"PREFIX={tmp_path}", f"PKGEN={pkgen}"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "share/man/man1/pkgen-run.1").exists()
    share = tmp_path / "share"
    assert "complete" in (share / "bash-completion/completions/pkgen").read_text()
    assert (share / "zsh/site-functions/_pkgen").read_text().startswith("#compdef pkgen")
    assert "complete -c pkgen" in (share / "fish/vendor_completions.d/pkgen.fish").read_text()
