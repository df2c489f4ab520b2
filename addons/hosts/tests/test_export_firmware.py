"""Firmware: sizes and times on Cortex-M in QEMU are those of the page, the results those of this
machine; the sketch compiles with the Arduino core and runs."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from conftest import ROOT, run_pkgen, table

HERE = ROOT / "addons/hosts/tests/firmware"
PAGE = (ROOT / "addons/hosts/export-firmware.md").read_text()
MODEL = ROOT / "models/double_pendulum.lag"
FREE = [
    "-std=c11",
    "-ffp-contract=off",
    "-fno-math-errno",
    "-ffunction-sections",
    "-fdata-sections",
]
# By the page's words for it: flags, the board, whether it has fused multiply-add.
CORES = {
    "M0+": (["-mcpu=cortex-m0plus", "-mfloat-abi=soft"], "mps2-an385", False),
    "M4F": (["-mcpu=cortex-m4", "-mfpu=fpv4-sp-d16", "-mfloat-abi=hard"], "mps2-an386", True),
    "M7": (["-mcpu=cortex-m7", "-mfpu=fpv5-d16", "-mfloat-abi=hard"], "mps2-an500", True),
}
ROW = r"^\| (M\S+) \| (float|double) \| (.*?) \| (-O\w) \| ([\d,]+) \| ([\d,]+) \| ([\d,]+) \|$"
ROWS = re.findall(ROW, PAGE, re.M)


def run(*words: object, cwd: Path) -> str:
    done = subprocess.run(
        list(map(str, words)), cwd=cwd, capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode == 0, f"{words}\n{done.stdout[-1000:]}{done.stderr[-2000:]}"
    return done.stdout + done.stderr


def flash(image: Path) -> int:
    text, data, *_ = run("arm-none-eabi-size", image, cwd=HERE).splitlines()[1].split()
    return int(text) + int(data)


@pytest.mark.long
@pytest.mark.skipif(
    not (shutil.which("arm-none-eabi-gcc") and shutil.which("qemu-system-arm")),
    reason="no gcc-arm-none-eabi, libnewlib-arm-none-eabi and qemu-system-arm here",
)
@pytest.mark.parametrize(("core", "scalar", "libm", "level", "size", "least", "most"), ROWS)
def test_sizes_and_times_are_those_of_the_page(
    core: str, scalar: str, libm: str, level: str, size: str, least: str, most: str, tmp_path: Path
) -> None:
    words = ["--method", "rk4", "--step", "1e-3", "--scalar", scalar]
    words += ["--no-libm"] if libm == "none" else []
    done = run_pkgen("export", MODEL, "--as", "freestanding", "-o", tmp_path / "f", *words)
    assert done.returncode == 0, done.stderr
    flags, board, fused = CORES[core]
    sources = [HERE / "thousand.c", *sorted((tmp_path / "f").glob("*.c"))]
    include = [f"-I{HERE}", f"-I{tmp_path}/f"]
    links = ["-nostartfiles", "--specs=nano.specs", "-Wl,--gc-sections", "-T", HERE / "board.ld"]
    compiler = ["arm-none-eabi-gcc", level, "-mthumb", *flags, *FREE, *include]
    libraries = [] if libm == "none" else ["-lm"]
    board_c = HERE / "board.c"
    run(*compiler, *links, board_c, *sources, "-o", "all.elf", *libraries, cwd=tmp_path)
    run(*compiler, *links, board_c, HERE / "nothing.c", "-o", "none.elf", cwd=tmp_path)
    if scalar == "float":
        assert "__aeabi_d" not in run("arm-none-eabi-nm", "all.elf", cwd=tmp_path)
    emulator = ["qemu-system-arm", "-M", board, "-nographic", "-semihosting", "-icount", "shift=6"]
    said = run(*emulator, "-kernel", "all.elf", cwd=tmp_path).split()
    # The same numbers on this machine.
    fma = ["-mfma"] if fused else []
    run(
        "gcc",
        "-O2",
        *fma,
        *FREE,
        *include,
        HERE / "host.c",
        *sources,
        "-o",
        "here",
        "-lm",
        cwd=tmp_path,
    )
    assert said[2:] == run(tmp_path / "here", cwd=tmp_path).split()[2:]
    taken = [int(word, 16) * 5 / 8 for word in said[:2]]
    found = (flash(tmp_path / "all.elf") - flash(tmp_path / "none.elf"), *taken)
    shown = [int(word.replace(",", "")) for word in (size, least, most)]
    print(core, scalar, libm, level, *map(round, found))
    for value, expected in zip(found, shown, strict=True):
        assert value == pytest.approx(expected, rel=0.05)  # compilers differ a little


CORE = Path("/usr/share/arduino/hardware/arduino/avr")  # where Debian has it
UNO = ["-mmcu=atmega328p", "-DF_CPU=16000000L", "-DARDUINO=10819", "-DARDUINO_AVR_UNO", "-Os"]


@pytest.mark.long
@pytest.mark.skipif(
    not (CORE.exists() and shutil.which("avr-gcc") and shutil.which("simavr")),
    reason="no arduino-core-avr, gcc-avr, avr-libc and simavr here",
)
def test_the_sketch_runs_on_an_uno(tmp_path: Path) -> None:
    words = ["--method", "rk4", "--step", "5e-3", "--no-libm"]
    done = run_pkgen("export", MODEL, "--as", "arduino", "-o", tmp_path / "lib", *words)
    assert done.returncode == 0, done.stderr
    core = CORE / "cores/arduino"
    sketch = tmp_path / "lib/examples/double_pendulum/double_pendulum.ino"
    c = [*core.glob("*.c"), *(tmp_path / "lib/src").glob("*.c")]
    # Debian's compiler does not take the String of that core, which the sketch does not use.
    cpp = [path for path in (*core.glob("*.cpp"), sketch) if path.stem != "WString"]
    include = [f"-I{core}", f"-I{CORE}/variants/standard", f"-I{tmp_path}/lib/src"]
    for path in (*c, *cpp):
        language = (
            ["-std=gnu11"] if path in c else ["-std=gnu++11", "-fpermissive", "-fno-exceptions"]
        )
        language += [] if path in c else ["-include", "Arduino.h", "-x", "c++"]
        compiler = "avr-gcc" if path in c else "avr-g++"
        sections = ["-ffunction-sections", "-fdata-sections", "-fno-threadsafe-statics"]
        sections = sections[: 2 if path in c else 3]
        run(
            compiler,
            *UNO,
            *language,
            *sections,
            *include,
            "-c",
            path,
            "-o",
            f"{path.name}.o",
            cwd=tmp_path,
        )
    objects = [path.name for path in tmp_path.glob("*.o")]
    run(
        "avr-gcc",
        "-mmcu=atmega328p",
        "-Os",
        "-Wl,--gc-sections",
        *objects,
        "-o",
        "uno.elf",
        "-lm",
        cwd=tmp_path,
    )
    text, data, bss, *_ = run("avr-size", "uno.elf", cwd=tmp_path).splitlines()[1].split()
    assert int(text) + int(data) < 16_000 and int(data) + int(bss) < 600
    emulator = ["timeout", "20", "simavr", "-m", "atmega328p", "-f", "16000000", "uno.elf"]
    said = subprocess.run(emulator, cwd=tmp_path, capture_output=True, text=True, check=False)
    said = re.findall(r"(?<!\d)(\d\.\d{3}) (-?\d\.\d{4})", said.stdout + said.stderr)
    rows = [row for row in said if float(row[0]) <= 1]  # it goes as far as this machine is fast
    assert len(rows) > 3
    again = run_pkgen("run", MODEL, "--until", "1", "--every", "0.005")
    motion = {f"{row[0]:.3f}": row[1] for row in table(again.stdout)[1]}
    for t, theta in rows:
        assert float(theta) == pytest.approx(motion[t], abs=2e-3)
