"""Loud pulses and bursts have the command's numbers bit for bit."""
import math

import pytest
from common import SOURCE, command, equal, raised, table

import sonopack

DISKS = SOURCE / "packings/reference/packing_N200_p1e-4.txt"


def chain():
    command("pack", "--set", "packing.kind=chain", "--set", "packing.grains=60", "--set", "packing.pressure=1e-6", "-o",
            "chain.h5", "--quiet", "--force")
    return sonopack.Packing.read("chain.h5")


def test_fronts():
    read = table("amplitude", DISKS, "--amplitudes", "0.001,0.3", "--source", "velocity")
    found = sonopack.Packing.read(DISKS).loud_fronts([0.001, 0.3], source="velocity")
    equal(read, "speed_ratio", [front.speed.value for front in found])
    equal(read, "width_ratio_err", [front.width.error for front in found])
    equal(read, "slid", [front.slid for front in found])
    equal(read, "rubbed", [front.energy.slid / front.energy.input for front in found])


def test_planes():
    packing = chain()
    heights = [packing.height * k / 4 for k in (1, 2, 3)]
    read = table("amplitude", "chain.h5", "--amplitudes", "2", "--planes", "3")
    found = packing.loud_planes(2, heights)
    equal(read, "speed_peak", [plane.speed_peak.value for plane in found])
    equal(read, "overpressure_err", [plane.overpressure.error for plane in found])


def test_bursts():
    packing = chain()
    read = table("amplitude", "chain.h5", "--amplitudes", "0.01", "--omega", "0.1", "--cycles", "3")
    planes, second = packing.loud_burst(0.01, 0.1, 3)
    equal(read, "beta", [second.beta.value])
    equal(read, "balance", [second.energy.defect])
    read = table("amplitude", "chain.h5", "--amplitudes", "0.01", "--omega", "0.1", "--cycles", "3", "--planes", "10")
    equal(read, "F2", [plane.second.value for plane in planes])
    again, _ = packing.loud_burst(0.01, 0.1, 3, heights=[5, 10, 15])
    assert len(again) == 3 and abs(again[1].height - 10) < 0.6, again


def test_solitary():
    read = table("chain", "soliton", "--peaks", "0.1,inf")
    found = [sonopack.solitary(0.1), sonopack.solitary(math.inf)]
    for column, field in (("speed", "speed"), ("width", "width"), ("velocity_at_peak", "velocity_at_peak")):
        equal(read, column, [getattr(wave, field) for wave in found])


@pytest.mark.parametrize("call", [
    lambda packing: packing.loud_fronts([0.1, -1]), lambda packing: packing.loud_fronts([0.1], tolerance=1),
    lambda packing: packing.loud_planes(0.1, [2, 2.01]), lambda packing: packing.loud_burst(0.1, -1),
    lambda packing: sonopack.solitary(0)])
def test_refusals(call):
    fault = raised(sonopack.InvalidInput, call, sonopack.Packing.read(DISKS))
    assert str(fault) and fault.key
