#!/usr/bin/env python3
"""sonopack coda: changes of one grain are found, also from signals in files; what it refuses.
Usage: test_coda.py COMMAND SOURCE_DIR"""
import os
import shutil
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


def test_one():
    rows, comments = table("coda", N200, "--grain=78", "--change=0.01", "--noise=0.001", "--rows=5")
    assert len(rows) == 5 and int(rows[0]["grain"]) == 78 and float(rows[0]["probability"]) > 0.99
    assert abs(float(rows[0]["change"]) / 0.01 - 1) < 0.1 and float(comments["distance"]) == 0
    assert float(rows[0]["misfit"]) < float(rows[1]["misfit"])


def test_trials():
    """Noise hides places, and detectors find them again."""
    found = {}
    for name, words in (("quiet", []), ("loud", ["--noise=0.2"]),
                        ("many", ["--noise=0.2", *(f"--detector=part:{x}:{x + 6}" for x in range(0, 24, 6))])):
        rows, comments = table("coda", N200, "--trials=40", *words)
        assert len(rows) == 40
        found[name] = float(comments["found"])
        assert (float(comments["distance"]) == 0) == (found[name] == 1)
        assert float(comments["found_err"]) > 0.01
        if name == "quiet":  # without noise the error is that of first order
            off = [(float(row["change"]) - 0.01) / float(row["change_err"]) for row in rows]
            assert max(map(abs, off)) < 2 and max(map(abs, off)) > 0.5, off
    assert found["quiet"] == 1 and found["loud"] < 0.7 and found["many"] > found["loud"], found


def test_files():
    """Signals of two packings of which one has changed: the contacts of grain 50 are 2% stiffer."""
    run("convert", N200, "p.h5")
    run("design", N200, "--goal=delay", "--vary=modulus", "--limits=0.999999999:1.000000001", "--iterations=0", "--packing=before.h5")
    shutil.copy(os.path.join(FOLDER.name, "before.h5"), os.path.join(FOLDER.name, "after.h5"))
    with h5py.File(os.path.join(FOLDER.name, "after.h5"), "r+") as file:
        pairs, walls = file["/connectivity/contacts"][:], file["/sonopack/walls/contacts"][:] if "/sonopack/walls" in file else []
        ends = np.concatenate([pairs, walls]) if len(walls) else pairs
        mine = (ends == 50).any(axis=1)
        names = []
        file["/sonopack/contacts"].visit(names.append)
        for name in names:
            if "stiffness" in name:
                values = file["/sonopack/contacts/" + name][:]
                values[mine] *= 1.02
                file["/sonopack/contacts/" + name][:] = values
    places = ["--detector=part:0:12", "--detector=part:12:24"]
    for name in ("before", "after"):
        run("signal", f"{name}.h5", "--until=400", "--points=1000", *places, "-o", f"{name}.tsv")
    rows, comments = table("coda", "before.h5", "--before=before.tsv", "--after=after.tsv", "--window=50:400", *places)
    assert int(rows[0]["grain"]) == 50 and abs(float(rows[0]["change"]) / 0.02 - 1) < 0.1, rows[0]
    assert comments["pairs"] == "2"
    run("coda", "before.h5", "--before=before.tsv", "--after=after.tsv", "--window=500:600", *places, status=2)
    run("coda", "before.h5", "--before=before.tsv", "--after=before.tsv", *places, status=1)
    run("signal", "after.h5", "--until=400", "--points=900", *places, "-o", "other.tsv")
    run("coda", "before.h5", "--before=before.tsv", "--after=other.tsv", *places, status=2)
    run("coda", "before.h5", "--before=before.tsv", "--after=after.tsv", *places, "--detector=top", status=1)
    run("coda", "before.h5", "--before=before.tsv", "--after=after.tsv", *places[:1], status=1)  # a column without a place
    run("coda", "before.h5", "--before=before.tsv", "--after=after.tsv", status=1)


def test_doubt():
    """What no grain explains is no white noise: signals of other packings, also with a noise that is far too small, and
    changes beyond the first order leave doubt. White noise as given leaves probabilities as they are."""
    run("signal", N200, "--set=signal.until=230", "--set=signal.points=900", "-o", "s0.tsv")
    for seed in (2, 3, 4, 5):
        run("pack", os.path.join(SOURCE, "packings/single.cfg"), "--set=packing.grains=200", f"--set=packing.seed={seed}",
            '--set=packing.protocol="quick"', "-o", f"other{seed}.h5")
        run("signal", f"other{seed}.h5", "--set=signal.until=230", "--set=signal.points=900", "-o", f"s{seed}.tsv")
    for noise in ([], ["--noise=0.01"]):
        best = [float(table("coda", N200, f"--before={b}.tsv", f"--after={a}.tsv", *noise)[0][0]["probability"])
                for b, a in (("s0", "s2"), ("s0", "s3"), ("s0", "s4"), ("s0", "s5"), ("s2", "s3"), ("s4", "s5"))]
        assert max(best) < 0.95, best
    rows, comments = table("coda", N200, "--trials=40", "--change=1")
    assert float(comments["found"]) < 0.3 and np.mean([float(row["probability"]) for row in rows]) < 0.8
    one, _ = table("coda", N200, "--grain=78", "--noise=0.01", "--points=200")
    two, _ = table("coda", N200, "--grain=78", "--noise=0.01", "--points=400")
    ratio = float(one[0]["change_err"]) / float(two[0]["change_err"])
    assert abs(ratio / 2**0.5 - 1) < 0.05, ratio


for test in (test_one, test_trials, test_files, test_doubt):
    test()
print("changes are found again")
