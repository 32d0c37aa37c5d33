#!/usr/bin/env python3
"""sonopack design: its packing, made again and heard, against its own table; what it refuses.
Usage: test_design.py COMMAND SOURCE_DIR"""
import os
import subprocess
import sys
import tempfile

import h5py
import numpy as np

COMMAND, SOURCE = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])
N200 = os.path.join(SOURCE, "packings/reference/packing_N200_p1e-4.txt")
FOLDER = tempfile.TemporaryDirectory()


def run(*words, status=0):
    done = subprocess.run([COMMAND, *map(str, words)], capture_output=True, text=True, cwd=FOLDER.name, timeout=1200)
    assert done.returncode == status, (words, done.returncode, done.stderr)
    return done


def table(*words):
    lines = run(*words).stdout.splitlines()
    comments = dict(line[2:].split(" = ", 1) for line in lines if line.startswith("# ") and " = " in line)
    rows = [line.split("\t") for line in lines if not line.startswith("#")]
    return [dict(zip(rows[0], row)) for row in rows[1:]], comments


def read(name):
    with h5py.File(os.path.join(FOLDER.name, name)) as file:
        return {key: file["/particles/grains/" + key][:] for key in ("radius", "mass") if "/particles/grains/" + key in file}


def test_mass():
    rows, comments = table("design", N200, "--goal=delay", "--iterations=6", "--packing=heavy.h5")
    assert comments["vary"] == "mass" and float(comments["t10_ratio"]) > 1.05
    front, _ = table("front", "heavy.h5")
    assert abs(float(front[0]["t10"]) / float(rows[-1]["t10"]) - 1) < 1e-4
    grains, _ = table("design", N200, "--goal=delay", "--iterations=6", "--rows=grains")
    factor = np.array([float(row["factor"]) for row in grains])
    made = read("heavy.h5")
    assert np.allclose(made["mass"], factor * np.pi / 6 * (2 * made["radius"])**3, rtol=1e-12)
    assert factor.min() >= 0.5 and factor.max() <= 2 and np.ptp(factor) > 0.5
    run("check", "heavy.h5")  # its forces are still in balance


def test_precursor():
    """Light grains send a precursor ahead, with a zero crossing of its own. It is no front, and gains nothing: the design
    and the sensitivities take the front that `front` takes."""
    n600 = os.path.join(SOURCE, "packings/reference/packing_N600_p1e-4.txt")
    rows, _ = table("design", n600, "--goal=advance", "--limits=0.5:2", "--packing=early.h5")
    front, _ = table("front", "early.h5")
    _, comments = table("sensitivity", "early.h5")
    for t10 in (rows[-1]["t10"], comments["value"]):
        assert abs(float(front[0]["t10"]) / float(t10) - 1) < 1e-4, (front[0], t10)


def test_modulus():
    rows, _ = table("design", N200, "--goal=advance", "--vary=modulus", "--limits=0.8:1.25", "--iterations=4", "--packing=stiff.h5")
    front, _ = table("front", "stiff.h5")
    assert abs(float(front[0]["t10"]) / float(rows[-1]["t10"]) - 1) < 1e-4
    assert float(rows[-1]["t10"]) < float(rows[0]["t10"])


def test_radius():
    """The packing of other radii is at rest under the same load, and the gradient has told its front."""
    run("pack", "--set", "packing.grains=120", "--set", "packing.width=10.0", "--seed=3", "-o", "p.h5", "-q")
    rows, comments = table("design", "p.h5", "--goal=delay", "--vary=radius", "--limits=0.9995:1.0005", "--iterations=1", "--packing=r.h5")
    run("check", "r.h5")
    assert not np.allclose(read("p.h5")["radius"], read("r.h5")["radius"], rtol=1e-5)
    real, promised = (float(comments[key]) - 1 for key in ("linear_ratio", "linear_predicted_ratio"))
    assert promised > 0.005 and abs(real / promised - 1) < 0.5, (real, promised)
    front, _ = table("front", "r.h5")
    assert abs(float(front[0]["t10"]) / float(rows[-1]["t10"]) - 1) < 1e-4


def test_all_frequencies():
    """The energy over all frequencies is the same wherever the band ends above the spectrum: a sampled signal has no
    frequencies that its points cannot tell."""
    high, higher = (table("design", N200, f"--goal=band:0:{end}", "--iterations=1")[0][-1] for end in ("40", "1e9"))
    assert high == higher, (high, higher)


for test in (test_mass, test_precursor, test_modulus, test_radius, test_all_frequencies):
    test()
print("designs are heard as they were promised")
