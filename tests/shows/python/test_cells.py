"""Packings in periodic cells, tilted ones, and boxes from arrays: the numbers of the files, and every fault its key."""
import copy
import os
import pickle
import sys

import numpy as np
from common import SOURCE, command, raised

import sonopack

sys.path.insert(0, os.path.join(SOURCE, "tests", "cli"))
from cells import box_of_disks, lattice, write_packing  # noqa: E402

CELLS = {"square": lattice(2), "tilted": lattice(2, 0.3), "sheared": lattice(3, -0.2, cells=4), "box": box_of_disks()}


def made(p, **changes):
    given = {"contacts": {"i": p["pairs"][:, 0], "j": p["pairs"][:, 1]}, "box": p["box"], "cell": p["cell"],
             "tilt": p["tilt"], "pressure": p["pressure"], "friction": 0.0, "gravity": p["gravity"], **changes}
    return sonopack.Packing.from_arrays(p["x"], p["r"], given.pop("contacts"), **given)


def test_arrays():
    """Normals, overlaps and forces follow from the positions, through the faces of a tilted cell too."""
    for name, p in CELLS.items():
        packing = made(p)
        assert (packing.cell, packing.tilt) == (p["cell"], tuple(p["tilt"])), (name, packing.cell, packing.tilt)
        assert np.array_equal(packing.contacts["j"], p["pairs"][:, 1]), (name, "contacts")
        assert np.allclose(packing.contacts["n"][:, :p["dim"]], p["normal"], atol=1e-12), (name, "normals")
        assert np.allclose(packing.contacts["overlap"], p["overlap"], atol=1e-12), (name, "overlaps")
        audit = packing.audit()
        assert max(audit.force_residual, audit.wall_residual, audit.geometry_residual) < 1e-6, (name, audit)
        assert np.isclose(packing.volume, np.prod(p["box"])), (name, "volume")


def test_elasticity():
    """The whole tensor is that of the command; plane waves along all axes, and planes as sources, in these cells."""
    for name in ("tilted", "sheared"):
        p = CELLS[name]
        write_packing("C.h5", {**p, "friction": 0.3})
        network = sonopack.Packing.read("C.h5").network()
        lines = [line for line in command("moduli", "C.h5").splitlines() if not line.startswith("#")]
        row = dict(zip(lines[0].split("\t"), lines[1].split("\t")))
        e = network.elasticity()
        for key, value in (("K", e.bulk), ("G_err", e.shear_error), ("anisotropy", e.anisotropy), ("C12", e.c[0, 1]),
                           ("C_err", e.error.max())):
            assert float(row[key]) == value, (name, key, row[key], value)
        assert network.cell == "periodic" and e.c.shape == (3 * (p["dim"] - 1),) * 2, (name, e.c.shape)
        for along in ({}, {"up": True}, {"along_y": True})[:p["dim"]]:
            assert (network.dispersion(waves=1, **along).wave["rms"] > 0).all(), (name, along)
        assert network.signal(sources=["plane:1"], detectors=["plane:2"], until=5.0, points=5).f.size == 5, name


def test_repeated():
    """A supercell is at rest as its cell is, and has its moduli; its axes with walls cannot be repeated."""
    for name, times in (("square", (2, 3)), ("tilted", (3, 2)), ("sheared", (2, 1, 2))):
        packing = made(CELLS[name])
        whole = packing.repeated(*times)
        assert whole.n == np.prod(times) * packing.n and len(whole.contacts) == np.prod(times) * len(packing.contacts), name
        assert max(whole.audit().force_residual, whole.audit().geometry_residual) < 1e-6, (name, whole.audit())
        one, many = packing.network().elasticity(), whole.network().elasticity()
        assert np.allclose(one.c, many.c, rtol=0, atol=(one.error + many.error).max() + 1e-12), (name, one.c - many.c)
    piston = sonopack.Packing.read(os.path.join(SOURCE, "packings", "reference", "packing_N200_p1e-4.txt"))
    wide = piston.repeated(3, 1)
    assert (wide.box[0], wide.height, wide.n) == (3 * piston.box[0], piston.height, 600)
    one, many = (p.network().signal(until=40.0, points=41) for p in (piston, wide))
    assert np.allclose(3 * one.f, many.f, rtol=0, atol=1e-12 * np.abs(many.f).max()), "the wall's force is three times that"
    for times in ((1, 2), (0, 1), (2,)):
        assert raised(sonopack.InvalidInput, piston.repeated, *times).key == "times", times


def test_files():
    """What a file says, and what is written again, is the same to the bit; so are copies."""
    for name, p in CELLS.items():
        write_packing("C.h5", {**p, "gravity": 1e-6})
        packing = sonopack.Packing.read("C.h5")
        assert (packing.cell, packing.gravity) == (p["cell"], 1e-6), (name, packing.cell, packing.gravity)
        packing.save("D.h5")
        command("convert", "C.h5", "E.h5", "--force")
        assert open("D.h5", "rb").read() == open("E.h5", "rb").read(), (name, "not the file of the command")
        for twin in (pickle.loads(pickle.dumps(packing)), copy.deepcopy(packing)):
            twin.save("F.h5")
            assert open("D.h5", "rb").read() == open("F.h5", "rb").read(), (name, "a copy differs")


def test_faults():
    p, box = CELLS["tilted"], CELLS["box"]
    walls = {"i": [0], "j": [sonopack.BOTTOM]}
    for key, packing, changes in (("cell", p, {"cell": "round"}), ("tilt", p, {"tilt": [1.0]}),
                                  ("contacts", p, {"contacts": walls}),
                                  ("contacts", box, {"contacts": {"i": [0], "j": [sonopack.BACK]}}),
                                  ("contacts", {**box, "cell": "piston"},
                                   {"contacts": {"i": [0], "j": [sonopack.LEFT]}})):
        error = raised(sonopack.InvalidInput, made, packing, **changes)
        assert error.key == key, (key, error)
    empty = {"i": np.zeros(0, int), "j": np.zeros(0, int)}
    for changes in ({"tilt": (40.0, 0, 0)}, {"tilt": (0.0, 1.0, 0)}, {"cell": "piston"}, {"gravity": float("nan")}):
        error = raised(sonopack.SonopackError, made, p, contacts=empty, **changes)
        assert error.status == sonopack.Status.EFORMAT, (changes, error)
