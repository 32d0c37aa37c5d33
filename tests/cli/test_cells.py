"""The command on packings in periodic cells and boxes: columns, notes, units, waves, and what needs walls. The physics of
cells is in tests/unit/test_cells*.c.

usage: test_cells.py COMMAND SOURCE_DIR
"""
import pathlib

import h5py
import numpy as np

from cells import OVERLAP, box_of_disks, lattice, write_packing
from command import MATERIAL, main, pack, refused, run, sets, table, tried

SPACING = 1 - OVERLAP
CELLS = [pathlib.Path(f"{rows}.h5") for rows in (8, 9)]
BOX, PISTON = pathlib.Path("box.h5"), pathlib.Path("piston.h5")


def packings():
    """Triangular lattices, which lean; a box; and a packing under a piston."""
    for path in CELLS:
        write_packing(path, lattice(2, 0.5 * SPACING, cells=int(path.stem)))
    write_packing(BOX, {**box_of_disks(8, 7), "friction": 0.3})
    pack(PISTON, grains=60, width=8, pressure=1e-3)


def moduli():
    k = np.sqrt(0.25 * OVERLAP) * np.sqrt(3) / 4
    pascal = 70e9 / (1 - 0.22**2) / 1e3  # kPa
    for path in CELLS:
        own, si = table("moduli", path), table("moduli", path, "--units=si", MATERIAL)
        for name, value in (("C11", 3 * k), ("C22", 3 * k), ("C12", k), ("C33", k), ("K", 2 * k), ("G", k), ("C13", 0),
                            ("C23", 0)):
            assert abs(own[name][0] - value) < 1e-10 * k, (name, own.row())
            assert np.isclose(si[name][0], own[name][0] * pascal, rtol=1e-9, atol=1e-6), name
        assert abs(own["anisotropy"][0]) < 1e-10 and all(0 < own[name][0] < 1e-10 for name in ("C_err", "K_err", "G_err"))
    assert "K" not in table("moduli", PISTON) and table("moduli", BOX)["K"][0] > 0
    for files in ((PISTON, CELLS[0]), (CELLS[0], PISTON)):  # the columns are those of the first file
        assert tried("moduli", *files).returncode == 1
    refused("piston", "moduli", CELLS[0], "--probe", "sine:1", status=1)


def statics():
    force = 1 / 3 * OVERLAP**1.5
    found = table("statics", *CELLS, PISTON)
    assert np.allclose(found["Phi2"][:2], np.pi / 4 / (SPACING**2 * np.sqrt(0.75)), rtol=1e-12)
    assert list(found["zs"][:2]) == [6, 6] and list(found["f0"][:2]) == [0, 0]
    for name, value in (("s_xx", np.sqrt(3) * force / SPACING), ("s_yy", np.sqrt(3) * force / SPACING), ("s_xy", 0)):
        assert np.all(np.abs(found[name][:2] - value) < 1e-12), name
    assert np.isclose(found["s_yy"][2], 1e-3, rtol=1e-3) and "s_yy" not in table("statics", PISTON, CELLS[0])


def modes():
    for path in CELLS:
        whole = table("modes", path)
        assert [whole.notes[key] for key in ("rigid_motions", "zero_modes", "mechanisms", "source", "detector")] == [
            "2", "2", "0", "none", "none"], whole.notes
        assert list(whole["omega"][:2]) == [0, 0] and whole["omega"][2] > 0
        low = table("modes", path, "--lowest", 3)
        assert low.notes["zero_modes"] == "2" and np.isclose(low["omega"][0], whole["omega"][2], rtol=1e-8)
        assert table("spectrum", "dos", path).notes["rigid_motions"] == "2"
    assert table("modes", BOX).notes["zero_modes"] == "0"


def waves():
    for path in CELLS:
        speeds = table("moduli", path)
        for direction in ("x", "up"):
            found = table("spectrum", "dispersion", path, "--direction", direction, "--waves", 1)
            assert found.notes["direction"] == direction and "node" not in found.notes
        speed = dict(zip(found.words("polarization"), found["rms"] / found["k"]))  # k is upright in every cell
        assert np.isclose(speed["longitudinal"], speeds["c_l"][0], rtol=0.05)
        assert np.isclose(speed["transverse"], speeds["c_t"][0], rtol=0.05)
    refused("--node", "spectrum", "dispersion", CELLS[0], "--direction", "up", "--node", 0.5)


def signals():
    for path in CELLS:
        for words in ((), ("--from", "plane:2"), ("--detector", "plane:2"), ("--from", "part:0:1")):
            refused("plane:Y", "signal", path, *words, status=1)
        one, two = (table("signal", path, "--source", f"{source}:plane:2", "--detector", "plane:4", "--until", 20)
                    for source in ("velocity", "impulse"))
        assert np.allclose(one["F"], np.pi / 6 * two["F"], rtol=1e-9, atol=1e-12)  # unit velocity, unit momentum
        assert one["F"][0] == 0 and one.notes["cell"] == "periodic"
        run("signal", path, "--from", "plane:2", "--detector", "plane:2.9", "--detector",
            f"plane:{one.note('height') - 0.5}", "--detector", "grain:3", "--until", 60, "-q", "--force", "-o", "planes.tsv")
        distance = table("front", "planes.tsv")["distance"]  # by the shorter way around the cell
        assert np.allclose(distance[:2], [0.9, 2.5]) and np.isnan(distance[2])
    for kind in ("transmission", "harmonic", "continuum"):
        refused("", "spectrum", kind, CELLS[0], status=1)
    linear, nonlinear = (table("signal", BOX, "--until", 30, *words) for words in ((), ("--method=dynamics", "--prestress")))
    assert np.abs(linear["F"]).max() > 0 and len(nonlinear) == len(linear)


def low_cells():
    """A cell without walls is not told that its walls decide; a box is."""
    write_packing("low.h5", lattice(2, 0.5 * SPACING, cells=4))
    write_packing("low_box.h5", box_of_disks(8, 4))
    for path, lines in (("low.h5", 0), ("low_box.h5", 1)):
        assert len(run("modes", path, "--lowest", 3).stderr.splitlines()) == lines, path


def minima():
    """Harmonic smooth disks: by pressure in packs and studies, by fraction in packs; near the values of O'Hern et al.
    (2003): jamming at a fraction of 0.842 with four contacts a grain."""
    scene = pathlib.Path("minimum.cfg")
    scene.write_text("""packing = { kind = "minimum"; cell = "periodic"; friction = 0.0; grains = 400; sizes = "bidisperse";
  diameter_min = 0.83333333; diameter_max = 1.16666667; law = { exponent = 1.0; }; pressure = (1e-4, 1e-3); };
network = { prestress = true; threshold = 1e-8; };
study = { want = ["statics", "moduli"]; samples = 3; };
""")
    run("pack", scene, "-o", "minimum.h5", *sets("packing.pressure=1e-4"))
    assert table("check", "minimum.h5").words("ok")[0] == "yes"
    statics, moduli = (table(name, "minimum.h5") for name in ("statics", "moduli"))
    assert 0.838 < statics["Phi2"][0] < 0.852 and 4.0 < statics["zs"][0] < 4.3 and 0 < moduli["G"][0] < 0.3 * moduli["K"][0]
    run("pack", scene, "-o", "dense.h5", *sets("packing.pressure=1e-4", "packing.fraction=0.9"))
    dense = table("statics", "dense.h5")
    assert abs(dense["Phi2"][0] - 0.9) < 1e-9 and dense["p"][0] > 2e-3
    assert table("check", "dense.h5").words("ok")[0] == "yes"
    refused("packing.fraction", "pack", scene, "-o", "loose.h5", *sets("packing.pressure=1e-4", "packing.fraction=0.5"),
            status=1)
    refused("packing.fraction", "study", scene, "--store", "minima", *sets("packing.fraction=0.9"))
    refused("packing.cell", "pack", scene, "-o", "no.h5", *sets("packing.pressure=1e-4", 'packing.cell="box"'))
    refused("packing.law.exponent", "pack", "-o", "no.h5", *sets("packing.law.exponent=1"))
    refused("packing.law packing.law.exponent", "pack", "-o", "no.h5", *sets("packing.law={exponent=1.0;}"))
    refused("packing.law.exponant packing.law.exponent", "pack", "-o", "no.h5", *sets("packing.law.exponant=1"))
    run("study", scene, "--store", "minima")
    means = table("table", "statics", "--store", "minima")
    assert list(means["p"]) == [1e-4, 1e-3] and means["zs"][0] < means["zs"][1]


def paths():
    """A row and a packing for each step, also of a path that goes on after an interruption; each file holds its scene."""
    words = ["pack", *sets("packing.path.strain=[0,0.03,0]", "packing.path.turns=[1,0.5]", "packing.path.lateral=stress",
                           "packing.path.steps=2", grains=60, cell="periodic", seed=2)]
    rows = table(*words, "-o", "path.h5")
    assert list(rows["stage"]) == [1, 2, 3, 4] and np.allclose(rows["strain"], [0, 0.015, 0.03, 0.015])
    assert np.allclose(rows["s_xx"][1:], 1e-4, rtol=1e-5) and rows["s_yy"][2] > 1.2e-4
    assert np.all(np.abs(rows["s_xy"][1:]) < 1e-9)
    files = [f"path.stage{k}.h5" for k in (1, 2, 3)] + ["path.h5"]
    assert np.allclose(table("statics", *files)["p"], (rows["s_xx"] + rows["s_yy"]) / 2, rtol=1e-9)
    assert set(table("check", *files).words("ok")) == {"yes"}
    with h5py.File("path.stage3.h5") as file:
        scene = file["sonopack/scene"][()]
    pathlib.Path("again.cfg").write_bytes(scene if isinstance(scene, bytes) else scene.encode())
    run("pack", "again.cfg", "-o", "again.h5")
    assert (table("statics", "again.h5")["p"] == table("statics", "path.stage3.h5")["p"]).all()
    refused("packing.path.strain", "pack", "-o", "no.h5", *sets("packing.path.strain=[0,0.1,0]"))
    apart = tried("pack", "-o", "apart.h5", *sets("packing.path.strain=[-0.02,-0.02,0]", "packing.path.steps=20", grains=60, cell="periodic"))
    assert apart.returncode == 1 and "packing.path.strain" in apart.stderr and len(apart.stdout.splitlines()) > 3
    refused("packing.path.steps", "pack", "-o", "no.h5", *sets("packing.path.strain=[0,0.1,0]", "packing.path.steps=2", cell="periodic"))


def studies():
    """What needs walls is refused before any packing is made."""
    for cell, wants, status in (("periodic", "ctof scaling signal planes probes", 2), ("box", "probes", 2),
                                ("periodic", "statics moduli spectrum", 0), ("box", "ctof signal moduli", 0)):
        for want in wants.split():
            words = ["study", "--store", "store", *sets(f'study.want=["{want}"]', "study.samples=1", grains=60, cell=cell),
                     *sets(*["signal.planes=2"] * (want == "planes"))]
            if status:
                refused("study.want packing.cell", *words)
            else:
                assert "packings" in run(*words, "--dry-run").stdout, (cell, want)
            assert not pathlib.Path("store").exists(), (cell, want)


main(packings, moduli, statics, modes, waves, signals, low_cells, minima, paths, studies)
