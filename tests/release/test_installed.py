"""pkgen as its user has it: of a wheel, or of a Debian package, in a root with a C compiler and
nothing else of ours, without GSL and without a network."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from conftest import ROOT, case

pytestmark = pytest.mark.long
# Debian's python3-venv and pip for the wheel; what the package needs comes with it.
WITH_PIP = ("python3", "python3-venv", "gcc", "libc6-dev")
MODEL = case("installed_swing")


class Root:
    """A minimal Debian; commands run in it as in a machine of its own."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def run(self, command: str) -> subprocess.CompletedProcess[str]:
        env = {"PATH": "/usr/bin:/bin:/usr/sbin:/sbin", "HOME": "/root", "LANG": "C.UTF-8"}
        # No network: pip and apt must have all they need.
        inside = ["unshare", "--net", "chroot", self.folder, "sh", "-c", f"cd /root && {command}"]
        return subprocess.run(inside, env=env, capture_output=True, text=True, timeout=1200)

    def ran(self, command: str) -> str:
        done = self.run(command)
        assert done.returncode == 0, f"{command}\n{done.stdout[-2000:]}{done.stderr[-2000:]}"
        return done.stdout

    def put(self, *files: Path) -> None:
        for file in files:
            shutil.copy(file, self.folder / "root")


def bare(folder: Path, *packages: str) -> Root:
    command = ["sh", ROOT / "tools/release/bare_root.sh", folder, *packages]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode == 77:
        pytest.skip(done.stderr.strip().splitlines()[-1])
    assert done.returncode == 0, done.stderr[-2000:]
    (folder / "root/swing.lag").write_text(MODEL)
    return Root(folder)


def works(root: Root, pkgen: str) -> None:
    """A model is checked, run, built and exported; what needs GSL says so."""
    assert root.ran(f"{pkgen} -V").startswith("pkgen ")
    assert root.ran(f"{pkgen} check swing.lag") == ""
    rows = root.ran(f"{pkgen} run swing.lag --until 10 --every 0.1").splitlines()
    assert rows[0] == "t,theta,theta',energy" and len(rows) == 102
    first, last = (float(row.split(",")[3]) for row in (rows[1], rows[-1]))
    assert first == pytest.approx(last, rel=1e-8) and first < -10
    root.ran(f"{pkgen} swing.lag -o c && cc -c c/swing.c -o swing.o")
    root.ran(f"{pkgen} build swing.lag -o swing && ./swing > rows.csv && test -s rows.csv")
    root.ran(f"{pkgen} export swing.lag --as single --method verlet --step 0.01")
    root.ran(f"{pkgen} export swing.lag --as fmu")
    done = root.run(f"{pkgen} plot swing.lag --until 5 -o swing.svg")  # matplotlib is an extra
    assert done.returncode == 2 and "install matplotlib" in done.stderr, done.stderr
    root.ran(f"{pkgen} fmt --check swing.lag && {pkgen} explain swing.lag")
    assert "gauss" in root.ran(f"{pkgen} methods")
    for words, code in (("run swing.lag --method gsl_rk8pd", 2), ("stability swing.lag", 3)):
        done = root.run(f"{pkgen} {words}")
        assert done.returncode == code and "libgsl-dev" in done.stderr, done.stderr
    # It says what is missing where there is no compiler, no ar, or no extra.
    for hidden, said in (("cc gcc", "install gcc"), ("ar", "install binutils")):
        places = " ".join(f"$(readlink -f $(command -v {word}))" for word in hidden.split())
        root.ran(f"for f in {places}; do mv $f $f.away; done; rm -rf .cache")
        done = root.run(f"{pkgen} run swing.lag")
        root.ran("for f in /usr/bin/*.away; do mv $f ${f%.away}; done")
        assert done.returncode == 3 and said in done.stderr, done.stderr
        assert done.stderr.count("\n") < 4
    done = root.run(f"{pkgen} show swing.lag")
    assert done.returncode != 0 and "Traceback" not in done.stderr and "install" in done.stderr


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the wheel."""
    folder = tmp_path_factory.mktemp("wheel")
    done = subprocess.run(
        [sys.executable, ROOT / "tools/release", folder],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return next(folder.glob("*.whl"))


def test_a_wheel_on_a_machine_with_a_c_compiler(made: Path, tmp_path: Path) -> None:
    root = bare(tmp_path / "root", *WITH_PIP)
    version = root.ran("python3 -c 'import sys; print(\"%d.%d\" % sys.version_info[:2])'").strip()
    wheels = root.folder / "root/wheels"
    fetched = subprocess.run(
        [
            *(sys.executable, "-m", "pip", "download", "-q", "-d", wheels, "--only-binary=:all:"),
            *("--python-version", version, made),
        ],
        capture_output=True,
        text=True,
    )
    if fetched.returncode:
        pytest.skip(f"what pkgen needs cannot be had: {fetched.stderr[-300:]}")
    root.ran("python3 -m venv here")
    root.ran("here/bin/pip install -q --no-index --find-links wheels pkgen-lag")
    works(root, "here/bin/pkgen")
    assert "pip install" in root.run("here/bin/pkgen lsp").stderr


def test_a_debian_package(tmp_path: Path) -> None:
    done = subprocess.run(["make", "-s", "deb"], cwd=ROOT, capture_output=True, text=True)
    if "please run" in done.stderr or "on Debian alone" in done.stderr:
        pytest.skip(done.stderr.strip())
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    package = ROOT / done.stdout.split()[-1]
    field = ["dpkg-deb", "-f", package, "Depends"]
    needs = subprocess.run(field, capture_output=True, text=True, check=True).stdout
    names = [one.split("|")[0].split("(")[0].split(":")[0].strip() for one in needs.split(",")]
    root = bare(tmp_path / "root", *names)
    root.put(package)
    root.ran(f"dpkg -i {package.name}")
    works(root, "pkgen")
    root.ran("pkgen check /usr/share/doc/pkgen/examples/models/double_pendulum.lag")
    assert root.ran("zcat /usr/share/man/man1/pkgen-run.1.gz").startswith(".TH PKGEN")
    for file in ("bash-completion/completions/pkgen", "zsh/vendor-completions/_pkgen"):
        assert "explain" in root.ran(f"cat /usr/share/{file}")
    root.ran(
        "dpkg -r pkgen && ! command -v pkgen && ! test -e /usr/lib/python3/dist-packages/pkgen"
    )
