"""signal and moduli: signals as the packings brought them, defaults, chains. tests/oracle compares all numbers.

usage: test_signal.py COMMAND SOURCE_DIR
"""
import json
import pathlib

import numpy as np

from command import N200, N600, REFERENCE, main, pack, refused, run, sets, table, tried
from common import names_all


def published():
    """The signals that came with the packings."""
    for path in (N200, N600):
        reference = np.loadtxt(REFERENCE / path.name.replace("packing_", "signal_"))
        for column, source in ((1, "velocity"), (2, "impulse")):
            found = table("signal", path, "--until", 400, "--points", 801, "--source", source)
            assert np.allclose(found["t"], reference[:, 0], rtol=1e-14)
            assert np.abs(found["F"] - reference[:, column]).max() < 1e-9 * np.abs(reference[:, column]).max()


def symmetry():
    """What needs a symmetric stiffness refuses with prestress and friction, in the same words."""
    for line in ("modes {} --damping 0.1", "respond {} --swell 7", "signal {} --method dense", "signal {} --method sparse", "signal {} --method verlet",
                 "signal {} --method lax-wendroff", "signal {} --damping 0.1", "spectrum dos {}", "spectrum transmission {}",
                 "spectrum dispersion {}", "spectrum harmonic {}", "spectrum participation {}", "spectrum continuum {}"):
        assert "symmetric stiffness" in refused("", *line.format(N200).split(), "--prestress", status=1), line


def moduli():
    found = table("moduli", N200, N600)
    assert found.names == ["file", "p", "C11", "C12", "C22", "C33", "c_l", "c_t", "C_err", "c_l_err", "c_t_err"]
    assert found.words("file") == [str(N200), str(N600)] and list(found["p"]) == [1e-4, 1e-4]
    assert np.allclose(found["c_l"] / found["c_t"], np.sqrt(found["C22"] / found["C33"]), rtol=1e-12)
    # a chain has C22 and c_l only; c_l is l sqrt(K/m) (C3) but for its ends
    row = table("moduli", pack("chain.h5", kind="chain", grains=1000))
    overlap = 3e-4 ** (2 / 3)  # (A1) with E12 = 1/2, R12 = 1/4
    k = np.sqrt(overlap / 4)
    assert np.isclose(row["c_l"][0], (1 - overlap) * np.sqrt(k / (np.pi / 6)), rtol=1e-3)
    assert np.isclose(row["C22"][0], (1 - overlap) * k, rtol=2e-3) and np.isnan(row["C11"][0])
    # a file that is no good does not take the others along, but the exit status tells
    done = tried("moduli", "no_such_file", N200)
    assert done.returncode == 1 and names_all(done.stderr, "no_such_file") and str(N200) in done.stdout


def defaults():
    found = table("signal", N200)
    assert len(found) == 801 and np.isclose(found["t"][-1], 8 * found.note("height") + 40, rtol=1e-14)
    assert found.notes["source"] == "impulse"
    by_key = run("signal", N200, *sets("signal.points=11", 'signal.source="velocity"'), "--until", 20).stdout
    assert by_key == run("signal", N200, "--points", 11, "--source", "velocity", "--until", 20).stdout
    run("signal", N200, "--points", 5, "-o", "s.json")
    assert "F" in json.loads(pathlib.Path("s.json").read_text())["columns"]
    refused("s.json", "signal", N200, "--points", 5, "-o", "s.json")
    run("signal", N200, "--points", 5, "-o", "s.json", "--force")


main(published, symmetry, moduli, defaults)
