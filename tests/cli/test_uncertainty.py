#!/usr/bin/env python3
"""sonopack uncertainty: its table against the command's own signals, units, and what it refuses.
Usage: test_uncertainty.py COMMAND SOURCE_DIR"""
import json
import math
import os
import subprocess
import sys
import tempfile

COMMAND, SOURCE = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])
N200 = os.path.join(SOURCE, "packings/reference/packing_N200_p1e-4.txt")
FOLDER = tempfile.TemporaryDirectory()


def run(*words, status=0):
    done = subprocess.run([COMMAND, *map(str, words)], capture_output=True, text=True, cwd=FOLDER.name, timeout=1200)
    assert done.returncode == status, (words, done.returncode, done.stderr)
    return done


def table(*words):
    """{quantity: row}, {comment: value}"""
    lines = run("uncertainty", *words).stdout.splitlines()
    comments = dict(line[2:].split(" = ", 1) for line in lines if line.startswith("# ") and " = " in line)
    rows = [line.split("\t") for line in lines if not line.startswith("#")]
    return {row[0]: dict(zip(rows[0], row)) for row in rows[1:]}, comments


def test_values():
    """The values without errors are those of front and moduli."""
    rows, _ = table(N200, "--force=0.01", "--samples=10")
    front = [line.split("\t") for line in run("front", N200).stdout.splitlines() if not line.startswith("#")]
    moduli = [line.split("\t") for line in run("moduli", N200).stdout.splitlines() if not line.startswith("#")]
    for name, column, values in (("t10", "t10", front), ("t_peak", "t_peak", front), ("peak", "amplitude", front),
                                 ("width", "width", front), ("C22", "C22", moduli), ("c_t", "c_t", moduli)):
        expected = float(values[1][[head.split("[")[0].strip() for head in values[0]].index(column)])
        assert abs(float(rows[name]["value"]) / expected - 1) < 1e-9, name


def test_photoelastic():
    """A measured packing whose contacts are not where its positions say: pixels, and oblique forces on walls."""
    samples = os.path.join(SOURCE, "tests/foreign/samples/photoelastic")
    run("convert", f"{samples}/particles.csv", "disks.h5", "--frame=1", f"--contacts={samples}/contacts.csv",
        "--material=E=4e6,nu=0.5,rho=1060", "--length-unit=0.05e-3", "--kn=5e4", "--kt-ratio=0.5", "--thickness=6e-3",
        "--walls=balance", "--set=friction=0.5")
    rows, _ = table("disks.h5", "--position=0.003", "--force=0.1", "--samples=40")
    for command, names in (("front", {"t10": "t10", "peak": "amplitude"}), ("moduli", {"C22": "C22", "c_l": "c_l"})):
        lines = [line.split("\t") for line in run(command, "disks.h5").stdout.splitlines() if not line.startswith("#")]
        for name, column in names.items():
            expected = float(lines[1][lines[0].index(column)])
            assert abs(float(rows[name]["value"]) / expected - 1) < 1e-9, (name, rows[name], expected)
            assert rows[name]["linear"] == "yes", rows[name]


def test_first_order():
    """All stiffnesses together by 1%: t10 by 0.5%, moduli by 1%, and shares that add up."""
    rows, _ = table(N200, "--calibration=0.01", "--samples=0", "--modes=2")
    for name, power in (("t10", 0.5), ("C11", 1), ("c_l", 0.5), ("omega_2", 0.5)):
        assert abs(float(rows[name]["sd_first"]) / float(rows[name]["value"]) / (0.01 * power) - 1) < 5e-3, name
        assert rows[name]["sd"] == "nan" and rows[name]["linear"] == "unknown"
    rows, _ = table(N200, "--force=0.1", "--radius=0.01", "--position=0.01", "--false=0.01", "--samples=0")
    for name, row in rows.items():
        assert abs(sum(float(row[key]) for key in row if key.startswith("share_")) - 1) < 1e-9, name
        assert float(row["shift_first"]) != 0


def test_samples():
    rows, comments = table(N200, "--from=overlaps", "--position=0.003", "--samples=30", "--seed=4")
    again, _ = table(N200, "--from=overlaps", "--position=0.003", "--samples=30", "--seed=4", "--threads=1")
    assert rows == again
    assert rows["t10"]["linear"] == "no" and int(rows["t10"]["samples"]) <= 30
    assert comments["measured"] == "overlaps" and float(comments["overlap"]) > 1e-3
    assert float(comments["contacts_ratio"]) < 1
    rows, comments = table(N200, "--from=overlaps", "--position=0.05", "--samples=10", "--front-only")
    few = rows["t10"]  # most draws have no sound: of few samples the standard deviation has a large error, and not none
    assert 2 <= int(few["samples"]) <= 5 and few["linear"] == "no", few
    assert float(few["sd_err"]) > 0.2 * float(few["sd"]), few
    assert not any(row["shift_first"].startswith("-") for row in rows.values())
    rows, comments = table(N200, "--missing=0.2", "--samples=20", "--front-only")
    assert rows["t10"]["sd_first"] == "nan" and float(rows["t10"]["sd"]) > 0
    assert int(comments["candidates"]) > 10 and "C11" not in rows and float(comments["contacts_ratio"]) > 1


def test_units():
    material = "--material=E=70e9,nu=0.2,rho=2500,d=2e-3"
    own, own_comments = table(N200, material, "--position=0.02 mm", "--samples=10")
    si, si_comments = table(N200, material, "--position=0.01", "--samples=10", "--units=si")
    modulus = 70e9 / (1 - 0.2**2)
    speed = math.sqrt(modulus / 2500)
    for name, unit, factor in (("t10", "us", 2e-3 / speed * 1e6), ("C22", "kPa", modulus * 1e-3), ("c_l", "m/s", speed),
                               ("peak", "N", modulus * 4e-6)):
        assert si[name]["unit"] == unit, si[name]
        for key in ("value", "sd", "bias_err", "sd_first"):
            assert abs(float(si[name][key]) / float(own[name][key]) / factor - 1) < 1e-9, (name, key)
        assert si[name]["share_position"] == own[name]["share_position"]
    assert si_comments["position"] == "0.02 mm" and float(own_comments["position"]) == 0.01


def test_formats():
    run("uncertainty", N200, "--force=0.1", "--samples=10", "-o", "u.json")
    with open(os.path.join(FOLDER.name, "u.json")) as file:
        assert "t10" in json.dumps(json.load(file))
    run("uncertainty", N200, "--force=0.1", "--samples=10", "-o", "u.csv")


for test in (test_values, test_photoelastic, test_first_order, test_samples, test_units, test_formats):
    test()
print("errors of measured packings are told")
