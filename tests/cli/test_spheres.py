"""Packings in three dimensions through every command: what they can do, and what they refuse.

usage: test_spheres.py COMMAND SOURCE_DIR
"""
import os
import subprocess
import sys
import tempfile

from common import names_all

COMMAND, SOURCE = sys.argv[1], sys.argv[2]
FOLDER = tempfile.mkdtemp(prefix="sonopack-spheres-")
BOX = ["--set", "packing.dimension=3", "--set", "packing.grains=100", "--set", "packing.width=5", "--set",
       "packing.tolerance=1e-8"]


def run(*words, status=0, says=""):
    result = subprocess.run([COMMAND, *words], capture_output=True, text=True, timeout=1200, cwd=FOLDER)
    assert result.returncode == status, f"{words}: status {result.returncode}, {result.stderr}"
    assert not says or names_all(result.stderr, says), f"'{says}' in: {result.stderr}"
    return result.stdout


def rows(text):
    lines = [line.split("\t") for line in text.splitlines() if line and not line.startswith("#")]
    return [dict(zip(lines[0], line)) for line in lines[1:]]


def read(name):
    with open(os.path.join(FOLDER, name), "rb") as file:
        return file.read()


def test_audit_and_statics():
    made = rows(run("pack", *BOX, "-q", "-o", "P.h5"))[0]
    assert rows(run("check", "--tolerance", "1e-3", "P.h5"))[0]["ok"] == "yes"
    # two bulk layers are left between margins of 3 in a box as high as this
    statics = rows(run("statics", "P.h5"))[0]
    assert statics["Phi2"] == "nan", "an area fraction is for two dimensions"
    assert 0.4 < float(statics["s1_over_s2"]) < 0.9, statics
    assert 3 < float(made["height"]) < 5, made


def test_waves():
    modes = rows(run("modes", "P.h5", "--frequencies-only"))
    assert len(modes) == 6 * 100, "six for each grain"
    chebyshev = rows(run("signal", "P.h5", "--until", "40", "--points", "81"))
    dense = rows(run("signal", "P.h5", "--until", "40", "--points", "81", "--method", "dense"))
    peak = max(abs(float(row["F"])) for row in dense)
    assert peak > 0
    for one, other in zip(chebyshev, dense):
        assert abs(float(one["F"]) - float(other["F"])) < 1e-10 * peak, (one, other)
    front = rows(run("front", "P.h5"))[0]
    assert 0 < float(front["t10"]) < float(front["t_peak"]) < float(front["t_zero"]), front


def test_refusals():
    moduli = rows(run("moduli", "P.h5"))[0]
    assert moduli["c_l"] == "nan" and 0 < float(moduli["C55"]) < float(moduli["C33"]), moduli
    run("pack", "--set", "packing.depth=8", "-o", "no.h5", status=2, says="packing.depth")
    run("pack", *BOX, "--set", "packing.depth=3", "-o", "no.h5", status=2, says="packing.depth 3")
    run("pack", *BOX, "--set", "packing.gas_fraction=0.4", "-o", "no.h5", status=2, says="packing.gas_fraction")


def test_study():
    with open(os.path.join(FOLDER, "study.cfg"), "w", encoding="utf-8") as scene:
        scene.write('packing = { dimension = 3; width = 5; depth = 6; tolerance = 1e-8; };\n'
                    'study = { samples = 2; want = ["ctof", "statics"]; sweep = (\n'
                    '{ key = "packing.grains"; values = [50, 90]; } ); };\n')
    run("study", "study.cfg", "--store", "store", "-q", "-o", "study.tsv")
    speed = rows(run("table", "ctof", "--store", "store"))
    assert len(speed) == 1 and float(speed[0]["c_tof"]) > 0, speed
    samples = rows(run("table", "ensemble", "--store", "store"))
    assert len(samples) == 4 and all(row["dimension"] == "3" for row in samples), samples


def test_scene():
    scene = os.path.join(SOURCE, "packings", "spheres.cfg")
    run("pack", scene, "-q", "--set", "packing.grains=30", "--set", "packing.width=5", "-o", "scene.h5")
    assert rows(run("check", "scene.h5"))[0]["ok"] == "yes"


if __name__ == "__main__":
    for name, test in list(globals().items()):
        if name.startswith("test_"):
            print(name, flush=True)
            test()
