"""Errors of measured packings, designs and places of changes: the command's numbers, and what is refused."""

import numpy as np
from common import SOURCE, command, raised

import sonopack

N200 = str(SOURCE / "packings/reference/packing_N200_p1e-4.txt")


def rows(*words):
    text = command(*words, "--quiet").splitlines()
    cells = [line.split("\t") for line in text if not line.startswith("#")]
    return [dict(zip(cells[0], row)) for row in cells[1:]]


def test_uncertainty():
    packing = sonopack.Packing.read(N200)
    result = sonopack.uncertainty(packing, force=0.1, position=0.01, samples=20, seed=3, modes=2)
    own = rows("uncertainty", N200, "--force=0.1", "--position=0.01", "--samples=20", "--seed=3", "--modes=2")
    assert list(result) == [row["quantity"] for row in own], list(result)
    for row in own:
        one = result[row["quantity"]]
        assert ((one.value, one.sd, one.bias, one.samples) ==
              (float(row["value"]), float(row["sd"]), float(row["bias"]), int(row["samples"]))), row
        assert one.linear == row["linear"] and np.isclose(one.first_order, float(row["sd_first"]), rtol=0, equal_nan=True), row
        assert np.isclose(one.share["force"], float(row["share_force"]), rtol=0, equal_nan=True), one.share
    assert result.overlap > 1e-3 and result.loose == 0 and result.why == ""
    assert raised(sonopack.InvalidInput, sonopack.uncertainty, packing, measured="overlaps", force=0.1).key == "force"
    assert "measured" in str(raised(sonopack.InvalidInput, sonopack.uncertainty, packing, measured="guesses"))


def test_design():
    packing = sonopack.Packing.read(N200)
    result = sonopack.design(packing, "delay", limits=(0.5, 2), iterations=5)
    own = rows("design", N200, "--goal=delay", "--iterations=5")
    assert result.steps == len(own) and [step["value"] for step in result.step] == [float(row["t10"]) for row in own]
    assert result.factor.shape == (200,) and result.packing.mass is not None
    assert np.isclose(result.packing.front().t10, result.step["value"][-1], rtol=1e-4)
    kept = result.packing
    del result
    assert np.isfinite(kept.mass).all(), "the packing outlives the design"
    assert raised(sonopack.InvalidInput, sonopack.design, packing, "band", band=(2, 1)).key == "goal"


def test_coda():
    network = sonopack.Packing.read(N200).network()
    t = np.linspace(60, 300, 200)
    coda = sonopack.Coda(network, t, detectors=["top", "part:0:12"])
    assert (coda.pairs, coda.times, coda.kernel.shape) == (2, 200, (2, network.n, 200))
    grain = int(coda.grain[20])
    change = coda.signal(grain, 1e-3) - coda.signal()
    found = coda.locate(change)
    assert found["grain"][0] == grain and abs(found["change"][0] / 1e-3 - 1) < 0.1, found[:3]
    assert np.isclose(found["probability"].sum(), 1)
    assert abs(coda.first_order(found[:1])["change"][0] - 1e-3) < coda.first_order(found[:1])["error"][0] < 1e-4
    raised(sonopack.Refused, coda.locate, 0 * change)
    raised(sonopack.InvalidInput, coda.locate, change[:1])
    raised(sonopack.InvalidInput, sonopack.Coda, network, t[::-1])
