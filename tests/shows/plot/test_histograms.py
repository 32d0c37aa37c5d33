"""Histograms of contacts: integrals, the fabric of the statics, a lattice, both ends of a contact, and refusals."""
import pathlib

import numpy as np
import pytest

import sonopack
from sonopack.plot._histograms import ContactCounts

REFERENCE = pathlib.Path(__file__).parents[3] / "packings" / "reference" / "packing_N200_p1e-4.txt"


def counted(*packings, margin=3.0):
    counts = ContactCounts()
    for packing in packings:
        counts.add(packing, 1e-4, margin)
    return counts


def test_integrals_and_fabric():
    packing = sonopack.Packing.read(REFERENCE)
    angles, values = counted(packing).angles(), counted(packing).values()
    for name in ("all", "strong", "weak"):
        assert abs(angles[name].mean() - 1) < 1e-12 and np.all(np.isnan(angles[f"{name}_err"]))
    # a contact anywhere within its bin of 5 degrees: sin^2 changes by 0.044 at the most from the middle, at random for
    # hundreds of contacts
    upright = np.sin(np.radians(angles["angle"])) ** 2
    assert abs(np.mean(angles["all"] * upright) - packing.statics().f2) < 0.004
    assert abs(np.mean(angles["strong"] * upright) - packing.statics().f2s) < 0.006
    for name in ("forces", "stiffnesses"):
        assert abs(0.1 * values[name].sum() - 1) < 1e-12
        assert abs(0.1 * (values[name] * values["x"]).sum() - 1) < 0.01  # the mean, to a tenth of a bin


def test_lattice():
    """Bonds lie at 0, 60 and 120 degrees, and no force is above the mean; twice: the same means, errors 0."""
    lattice = sonopack.Packing.make(sonopack.Scene(packing={"kind": "triangular", "width": 8, "grains": 96,
                                                            "friction": 0}))
    angles = counted(lattice, lattice).angles()
    bond = np.min(np.abs(angles["angle"][:, None] - [0, 60, 120, 180]), axis=1) < 3
    assert np.all(angles["all"][~bond] == 0) and abs(angles["all"][bond].sum() - 36) < 1e-9
    assert np.all(np.abs(angles["all_err"]) < 1e-7) and np.all(np.isnan(angles["strong"]))
    assert angles["angle"][12] == 60 and angles.number("packings") == 2


def test_space():
    """Directions spread evenly over a sphere have the density 1 at every elevation."""
    from sonopack.plot import _histograms

    up = (np.arange(20000) + 0.5) / 10000 - 1
    n = np.column_stack([np.sqrt(1 - up * up), np.zeros_like(up), up])
    assert np.all(np.abs(_histograms._directions(3, n) - 1) < 0.01)


def test_refusals():
    packing, counts = sonopack.Packing.read(REFERENCE), ContactCounts()
    chain = sonopack.Packing.make(sonopack.Scene(packing={"kind": "chain", "dimension": 1, "grains": 12}))
    for make in (counts.angles, counts.values):
        with pytest.raises(sonopack.Refused):
            make()
    for threshold, margin, wrong, word in ((1e-4, 30.0, sonopack.Refused, "60"), (1e9, 3.0, sonopack.Refused, "3"),
                                           (1e-4, float("nan"), sonopack.InvalidInput, "nan")):
        with pytest.raises(wrong, match=word):
            counts.add(packing, threshold, margin)
    counts.add(chain, 1e-4, 3.0)
    with pytest.raises(sonopack.InvalidInput, match="2 dimensions"):
        counts.add(packing)
    with pytest.raises(sonopack.Refused, match="2 or 3"):
        counts.angles()
    assert len(counts.values()["x"]) >= 2
