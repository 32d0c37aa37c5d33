"""The material of the grains: where it is given, what it changes and what it does not, and what is refused.

usage: test_material.py COMMAND SOURCE_DIR
"""
import math
import pathlib

import h5py

from command import MATERIAL, N200, main, refused, run, table
from common import names_all

GROUP = "material = { E = 70e9; nu = 0.22; rho = 2500; d = 1e-3; };\n"
MODULUS = 70e9 / (1 - 0.22 * 0.22)
TIME = 1e-3 / math.sqrt(MODULUS / 2500)
CHAIN = "packing = { kind = \"chain\"; grains = 20; pressure = \"100 kPa\"; };\n"


def made(text, name="x.h5", *words):
    pathlib.Path("s.cfg").write_text(text)
    return run("pack", "s.cfg", "-o", name, "--force", *words)


def pressure(text, *words):
    made(text, "x.h5", *words)
    with h5py.File("x.h5") as file:
        return float(file["/sonopack/pressure"][()])


def first(column, *words):
    return table(*words)[column][0]


def units_of_keys():
    """A quoted number with a unit is the number in our unit, in a file, in --set, in ranges and sweeps."""
    for value in ("100 kPa", "100kPa", "0.1 MPa", "1 bar", "1e5 Pa", "1e-4 GPa", "1e5 N/m^2"):
        p = pressure(GROUP + CHAIN.replace("100 kPa", value))
        assert abs(p / (1e5 / MODULUS) - 1) < 3e-16, (value, p)
        assert pressure(GROUP + CHAIN, "--set", f"packing.pressure={value}") == p
    assert pressure(GROUP + CHAIN.replace("100 kPa", "0.0001 E*")) == 1e-4
    # the material may stand behind, and comes from the option where the scene has none
    for text, more in ((CHAIN + GROUP, ()), (CHAIN, (MATERIAL,)), (CHAIN, ("--material=E=70 GPa,nu=0.22,rho=2.5 g/cm^3,d=1mm",))):
        assert pressure(text, *more) == 1e5 / MODULUS
    pathlib.Path("range.cfg").write_text(GROUP + """signal = { planes = ["10 mm", "20 mm"]; };
packing = { kind = "chain"; grains = 30; pressure = { from = "1 kPa"; to = "100 kPa"; count = 3; spacing = "log"; }; };
study = { samples = 1; want = ["planes"]; };\n""")
    found = table("study", "range.cfg", "--store=range", "--units=si", "-q")
    assert sorted({round(p, 9) for p in found["p"]}) == [1, 10, 100] and len(found) == 6
    run("table", "planes", "--store=range", "--pressure=10 kPa")
    refused("", "table", "planes", "--store=range", "--pressure=11 kPa", status=1)


def ratio_of_poisson():
    """The ratio of a scene's material is that of the contacts, unless the scene says otherwise, which is noted."""
    for text, more, expected, note in ((GROUP + CHAIN, (), 0.22, ""),
                                       (GROUP + CHAIN, ("--set=packing.poisson=0.1",), 0.1, "material.nu 0.22 packing.poisson 0.1"),
                                       (CHAIN, (MATERIAL,), 0, "material.nu packing.poisson")):  # a matter of units alone
        said = made(text, "x.h5", *more).stderr
        with h5py.File("x.h5") as file:
            assert file["/sonopack/poisson"][()] == expected, (text, more)
        assert names_all(said, note) if note else not said, said


def unusual():
    """One warning names the values that no grain has, and what another unit would make of them."""
    for given, named in (("E=70,nu=0.22,rho=2.5,d=1e-3", "E 70 GPa 70e9 Pa rho 2.5 g/cm^3 2500 kg/m^3"),
                         ("E=70e9,nu=0.22,rho=2500,d=1", "d mm 0.001"), ("E=1e14,nu=0.22,rho=2500,d=1e-3", "E 2e+12"),
                         ("E=70e9,nu=0.22,rho=2500,d=1e-3", ""), ("E=1e4,nu=0.5,rho=1000,d=0.02", "")):
        words = dict(word.split("=") for word in given.split(","))
        scene = f"material = {{ {' '.join(f'{key} = {value};' for key, value in words.items())} }};\n"
        for said in (made(scene + CHAIN.replace('"100 kPa"', "1e-5")).stderr,
                     run("moduli", N200, "--units=si", f"--material={given}").stderr):
            assert said.count("usual grains") == bool(named) and (not named or names_all(said, named)), (given, said)


def by_hand():
    """Hertz's law with a pocket calculator: a row of beads, and the load on the floor of a layer."""
    d, force = 1e-3, 1e5 * 1e-6
    overlap = (3 * force / (4 * MODULUS / 2 * math.sqrt(d / 4))) ** (2 / 3)
    rate = math.sqrt(MODULUS * math.sqrt(d / 4 * overlap) / (math.pi / 6 * 2500 * d**3))
    made(GROUP + CHAIN.replace("20", "100"), "row.h5")
    speed = first("c_l", "moduli", "row.h5", "--units=si")
    # the density is that of the bulk, whose ends cut beads
    assert abs(speed / ((100 * d - 101 * overlap) * rate / math.sqrt(100 * 101)) - 1) < 2e-5, speed
    last = table("modes", "row.h5", "--frequencies-only", "--units=si")["omega"][-1]
    assert abs(last / (2 * rate * math.sin(50 * math.pi / 101)) - 1) < 1e-9, last
    # two dimensions: the pressure times the width times d
    made(GROUP + "packing = { protocol = \"quick\"; grains = 60; width = \"8 mm\"; pressure = \"100 kPa\"; };\n", "layer.h5")
    with h5py.File("layer.h5") as file:
        walls = file["/sonopack/walls/contacts"][:, 1]
        load = file["/sonopack/contacts/normal_force"][-len(walls):][walls == -1].sum() * MODULUS * d**2
    assert abs(load / (1e5 * 8e-3 * d) - 1) < 1e-5, load


def stored():
    """A packing keeps its material; numbers and names of samples do not depend on it."""
    made(GROUP + CHAIN, "a.h5")
    assert table("moduli", "a.h5", "--units=si").notes["material"] == "E=70000000000,nu=0.22,rho=2500,d=0.001"
    # a packing without gets it, and one with is told from another material
    text = "packing = { kind = \"chain\"; grains = 20; pressure = 1e-6; };\n"
    made(text, "c.h5")
    made(GROUP.replace("1e-3", "2e-3") + text.replace("1e-6;", "1e-6; poisson = 0;"), "d.h5")
    refused("--units --material c.h5", "moduli", "c.h5", "--units=si", status=1)
    own, given, kept = (first("c_l", "moduli", *words) for words in (
        ("c.h5",), ("c.h5", "--units=si", MATERIAL), ("d.h5", "--units=si")))
    assert abs(given / own / math.sqrt(MODULUS / 2500) - 1) < 1e-15 and given == kept
    assert names_all(run("moduli", "a.h5", "d.h5", "--units=si", status=1).stderr, "a.h5 d.h5 --material")
    assert "material" not in run("moduli", "a.h5", "d.h5").stdout
    assert names_all(run("moduli", "d.h5", "--units=si", MATERIAL).stderr, "d.h5 --material d=0.002")


def names():
    """Studies of two materials share the samples that are equal in our units."""
    text = ("packing = { kind = \"chain\"; grains = [20, 40]; pressure = 1e-6; poisson = 0.22; };\n"
            "study = { samples = 2; want = [\"ctof\"]; };\n")
    there = []
    for more in ("", GROUP, GROUP.replace("1e-3", "2e-3")):
        pathlib.Path("s.cfg").write_text(more + text)
        run("study", "s.cfg", "--store=names", "-q")
        there.append(sorted(path.name for path in pathlib.Path("names").glob("*.h5")))
    assert len(there[0]) == 4 and there[0] == there[1] == there[2], "the material changes a sample's name"
    # they were made without material: a scene or an option gives it
    refused("", "table", "ctof", "--store=names", "--units=si")
    si, own = first("c_tof", "table", "ctof", "--store=names", "--units=si", "s.cfg"), first("c_tof", "table", "ctof", "--store=names")
    assert abs(si / own / math.sqrt(MODULUS / 2500) - 1) < 1e-15


def options():
    """They take a number with a unit, with the material of the file."""
    t = table("signal", "a.h5", "--until=50 us", "--points=5")["t"]
    assert abs(t[-1] / (50e-6 / TIME) - 1) < 1e-15
    for word in ("50 kPa", "50 ux", "-3 us", "50us us"):
        refused("--until", "signal", "a.h5", f"--until={word}")
    refused("--until --material", "signal", "c.h5", "--until=50 us")
    assert names_all(run("statics", "a.h5", "d.h5", "--margin=1 mm", status=1).stderr, "a.h5 d.h5 --material")


def fronts():
    """Of a table: its material, or one that is given. A window and a distance with units hold in any unit."""
    for more, name in (((), "own.tsv"), (("--units=si",), "si.tsv")):
        run("signal", "a.h5", *more, "-o", name)
    one, two = (table("front", name, "--units=si") for name in ("own.tsv", "si.tsv"))
    assert all(abs(one[name][0] / two[name][0] - 1) < 1e-14 for name in one.names[1:])
    assert (two.units["distance"], two.units["t10"], two.units["amplitude"]) == ("mm", "us", "N")
    text = pathlib.Path("own.tsv").read_text()
    pathlib.Path("bare.tsv").write_text("\n".join(line for line in text.splitlines() if "material" not in line))
    refused("", "front", "bare.tsv", "--units=si", status=1)
    assert first("t10", "front", "bare.tsv", "--units=si", MATERIAL) == one["t10"][0]
    for name in ("a.h5", "own.tsv", "si.tsv"):
        late = table("front", name, "--units=si", "--window=60 us", "--distance=2 cm")
        assert late["distance"][0] == 20 and abs(late["t10"][0] / one["t10"][0] - 1) < 1e-3, name
        refused("", "front", name, "--units=si", "--window=5 us", status=1)
    pathlib.Path("lab.tsv").write_text("# units: t [ms] F [V]\nt\tF\n" + "".join(
        f"{k / 1000}\t{math.exp(-(k - 50)**2 / 50)}\n" for k in range(100)))
    assert run("front", "lab.tsv", "--window=80 us").stdout == run("front", "lab.tsv", "--window=0.08").stdout
    for word in ("--window=10 kPa", "--distance=-1 mm", "--window=1 m"):
        refused(word.split("=")[0], "front", "lab.tsv", word)
    assert table("front", "own.tsv", "si.tsv", "--units=si").units["t10"] == "us", "one unit for tables in both"


main(units_of_keys, ratio_of_poisson, unusual, by_hand, stored, names, options, fronts)
