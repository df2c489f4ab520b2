"""Numbers in rows and reports: the fewest digits that read back as the same double."""

import ctypes
import random
import struct
import subprocess
from pathlib import Path
from sys import float_info

from conftest import ROOT


def test_the_fewest_digits_that_read_back(tmp_path: Path) -> None:
    library = tmp_path / "numbers.so"
    flags = ["-std=c11", "-O1", "-shared", "-fPIC", f"-I{ROOT / 'runtime/include'}"]
    subprocess.run(["gcc", *flags, ROOT / "runtime/run/base/numbers.c", "-o", library], check=True)
    write = ctypes.CDLL(str(library)).numbers_text
    write.argtypes, write.restype = [ctypes.c_char_p, ctypes.c_double], ctypes.c_size_t
    draw = random.Random(1)
    values = [0.1, 0.3, 1e22, 1e23, 5e-324, 2.2250738585072014e-308, 1.7976931348623157e308]
    values += [9.5, 99.99999999999999, 999999999999999.9, 2.0**53 + 2, 1e16, 1e17, 1.5e300]
    values += [0.0, 1e-4, 1e-5, 9.999999999999999e-5, 0.001, 1 / 3, 2 / 3 * 1e-9, 100.0, 1e15]
    values += [struct.unpack("d", draw.randbytes(8))[0] for _ in range(20000)]
    values += [draw.uniform(-10, 10) for _ in range(20000)]
    values += [draw.randrange(10**6) / 10 ** draw.randrange(9) for _ in range(20000)]
    values += [round(draw.random(), draw.randrange(1, 18)) for _ in range(20000)]
    text = ctypes.create_string_buffer(32)
    lengths = set()
    for x in values:
        for y in (x, -x):
            if y - y != 0:
                continue
            length = write(text, y)
            found = text.value.decode()
            assert len(found) == length and float(found) == y
            digits = [c for c in found.partition("e")[0] if c.isdigit()]
            shortest = [c for c in repr(y).partition("e")[0] if c.isdigit()]
            count = [len("".join(d).strip("0")) for d in (digits, shortest)]
            assert count[0] == count[1] or abs(y) < float_info.min, (found, repr(y))
            assert len(found) <= len(f"{y:.17g}")
            lengths.add(count[0])
    assert set(range(1, 18)) <= lengths, lengths
