"""bench: columns, methods, errors, and what is refused."""
import subprocess

import pytest
from common import COMMAND, SOURCE

N200 = SOURCE / "packings/reference/packing_N200_p1e-4.txt"


def bench(*arguments, status=0):
    done = subprocess.run([COMMAND, "bench", *map(str, arguments)], capture_output=True, text=True, cwd=SOURCE)
    assert done.returncode == status, done
    return done.stdout, done.stderr


def test_rows():
    text, _ = bench("signal", "modes", "moduli", "--packing", N200, "--until", 20, "--seconds", 0.03)
    assert "# auto = " in text
    header, *rows = [line.split("\t") for line in text.splitlines() if not line.startswith("#")]
    assert header == ["case", "method", "parameter", "seconds", "error", "memory_MB"]
    assert {"auto", "dense", "chebyshev", "verlet", "sparse", "cholesky"} <= {row[1] for row in rows}
    for row in rows:
        seconds, error = float(row[3]), float(row[4])
        assert 0 < seconds < 60 and 0 <= error < (2 if row[1] in ("verlet", "lax-wendroff") else 1e-10), row
    # the expansion is what the program is for: the sum over modes is no match for it
    dense = [float(row[3]) for row in rows if row[0].startswith("signal") and row[1] == "dense"]
    quick = [float(row[3]) for row in rows if row[1] == "chebyshev"]
    assert max(quick) < 0.2 * dense[0], rows


def test_default_networks():
    text, _ = bench("moduli", "--seconds", 0.03)
    assert all(name in text for name in ("packing_N200_p1e-4.txt", "packing_N600_p1e-4.txt", "piston30", "lattice3600"))


@pytest.mark.parametrize("arguments, status, names", [
    (("no_such_case",), 2, "pack"), (("signal", "--packing", "no_such_file"), 1, "no_such_file"),
    (("signal", "--set", "packing.grains=9"), 2, "pack"), (("--units", "si"), 2, "units")])
def test_refusals(arguments, status, names):
    assert names in bench(*arguments, status=status)[1]
