"""design: its packing, made again and heard, against its own table. Gradients and optima are in
tests/unit/test_inference_design.c.

usage: test_design.py COMMAND SOURCE_DIR
"""
import h5py
import numpy as np

from command import N200, N600, main, pack, run, table


def heard(rows, path):
    """The front that the last step tells is the one that `front' finds."""
    assert abs(table("front", path)["t10"][0] / rows["t10"][-1] - 1) < 1e-4, path


def read(path, key):
    with h5py.File(path) as file:
        return file["/particles/grains/" + key][:]


def mass():
    words = ["design", N200, "--goal=delay", "--iterations=6"]
    rows = table(*words, "--packing=heavy.h5")
    assert rows.notes["vary"] == "mass" and rows.note("t10_ratio") > 1.05
    heard(rows, "heavy.h5")
    factor = table(*words, "--rows=grains")["factor"]
    assert np.allclose(read("heavy.h5", "mass"), factor * np.pi / 6 * (2 * read("heavy.h5", "radius"))**3, rtol=1e-12)
    assert factor.min() >= 0.5 and factor.max() <= 2 and np.ptp(factor) > 0.5
    run("check", "heavy.h5")  # its forces are still in balance


def precursor():
    """Light grains send a precursor ahead, with a zero crossing of its own. It is no front, and gains nothing: the design
    and the sensitivities take the front that `front` takes."""
    heard(table("design", N600, "--goal=advance", "--limits=0.5:2", "--packing=early.h5"), "early.h5")
    assert abs(table("front", "early.h5")["t10"][0] / table("sensitivity", "early.h5").note("value") - 1) < 1e-4


def modulus():
    rows = table("design", N200, "--goal=advance", "--vary=modulus", "--limits=0.8:1.25", "--iterations=4", "--packing=stiff.h5")
    heard(rows, "stiff.h5")
    assert rows["t10"][-1] < rows["t10"][0]


def radius():
    """The packing of other radii is at rest under the same load, and the gradient has told its front."""
    pack("p.h5", "--seed=4", grains=120, width=10)
    rows = table("design", "p.h5", "--goal=delay", "--vary=radius", "--limits=0.9995:1.0005", "--iterations=1", "--packing=r.h5")
    run("check", "r.h5")
    assert not np.allclose(read("p.h5", "radius"), read("r.h5", "radius"), rtol=1e-5)
    real, promised = (rows.note(key) - 1 for key in ("linear_ratio", "linear_predicted_ratio"))
    assert promised > 0.005 and abs(real / promised - 1) < 0.5, (real, promised)
    heard(rows, "r.h5")


def all_frequencies():
    """The energy over all frequencies is the same wherever the band ends above the spectrum: a sampled signal has no
    frequencies that its points cannot tell."""
    high, higher = (table("design", N200, f"--goal=band:0:{end}", "--iterations=1").rows[-1] for end in ("40", "1e9"))
    assert high == higher, (high, higher)


main(mass, precursor, modulus, radius, all_frequencies)
