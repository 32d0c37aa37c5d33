"""The material of the grains: where it is given, what it changes and what it does not, and what is refused.

usage: test_material.py COMMAND SOURCE_DIR
"""
import math
import pathlib
import subprocess
import sys
import tempfile

from common import names_all

COMMAND = pathlib.Path(sys.argv[1]).resolve()
GROUP = "material = { E = 70e9; nu = 0.22; rho = 2500; d = 1e-3; };\n"
OPTION = "--material=E=70e9,nu=0.22,rho=2500,d=1e-3"
MODULUS = 70e9 / (1 - 0.22 * 0.22)
CHAIN = "packing = { kind = \"chain\"; grains = 20; pressure = \"100 kPa\"; };\n"


def sonopack(*arguments, status=0, cwd=None):
    done = subprocess.run([COMMAND, *map(str, arguments)], text=True, capture_output=True, cwd=cwd, stdin=subprocess.DEVNULL)
    assert done.returncode == status, f"sonopack {arguments}: {done.returncode}, not {status}: {done.stderr}"
    return done


def row(text, name):
    """The number of a column in the first row."""
    lines = [line.split("\t") for line in text.splitlines() if not line.startswith("#")]
    return float(lines[1][lines[0].index(name)])


def scene(folder, text, name="s.cfg"):
    (folder / name).write_text(text)
    return name


def check_units_of_keys(folder):
    """A quoted number with a unit is the number in our unit, in a file, in --set, in lists, ranges and sweeps."""
    for value, pascal in (("100 kPa", 1e5), ("100kPa", 1e5), ("0.1 MPa", 1e5), ("1 bar", 1e5), ("1e5 Pa", 1e5), ("1e-4 GPa", 1e5),
                          ("1e5 N/m^2", 1e5), ("0.0001 E*", None)):
        name = scene(folder, GROUP + CHAIN.replace("100 kPa", value))
        p = row(sonopack("pack", name, "-o", "x.h5", "--force", "-q", cwd=folder).stdout, "p")
        assert abs(p / (1e-4 if pascal is None else pascal / MODULUS) - 1) < 3e-16, (value, p)
        again = sonopack("pack", name, "--set", f"packing.pressure={value}", "-o", "x.h5", "--force", "-q", cwd=folder).stdout
        assert row(again, "p") == p
    # the material may stand behind, and comes from the option where the scene has none
    for text, more in ((CHAIN + GROUP, ()), (CHAIN, (OPTION,)), (CHAIN, ("--material=E=70 GPa,nu=0.22,rho=2.5 g/cm^3,d=1mm",))):
        assert row(sonopack("pack", scene(folder, text), *more, "-o", "x.h5", "--force", "-q", cwd=folder).stdout, "p") == 1e5 / MODULUS
    text = GROUP + """packing = { kind = "chain"; grains = 30; pressure = { from = "1 kPa"; to = "100 kPa"; count = 3; spacing = "log"; }; };
signal = { planes = ["10 mm", "20 mm"]; };
study = { samples = 1; want = ["planes"]; };\n"""
    out = sonopack("study", scene(folder, text), "--store=range", "--units=si", "-q", cwd=folder).stdout
    rows = [line.split("\t") for line in out.splitlines() if line and not line.startswith("#")]
    pressures = sorted({round(float(line[rows[0].index("p")]), 9) for line in rows[1:]})
    assert pressures == [1, 10, 100] and len(rows) == 7, rows
    for p in ("1 kPa", "10 kPa", "100 kPa"):
        sonopack("table", "planes", "--store=range", f"--pressure={p}", cwd=folder)
    sonopack("table", "planes", "--store=range", "--pressure=11 kPa", status=1, cwd=folder)


def check_poisson(folder):
    """The ratio of a scene's material is that of the contacts, unless the scene says otherwise, which is noted."""
    def made(text, *more):
        done = sonopack("pack", scene(folder, text), "-o", "x.h5", "--force", *more, cwd=folder)
        sonopack("convert", "x.h5", "g.tsv", "--contact-table=c.tsv", "--force", cwd=folder)
        lines = (folder / "g.tsv").read_text().splitlines()
        return [float(line.split("=")[1]) for line in lines if line.startswith("# poisson")], done.stderr
    assert made(GROUP + CHAIN) == ([0.22], "")
    poisson, note = made(GROUP + CHAIN, "--set=packing.poisson=0.1")
    assert poisson == [0.1] and names_all(note, "material.nu 0.22 packing.poisson 0.1")
    # the option is a matter of units alone
    poisson, note = made(CHAIN, OPTION)
    assert poisson == [0] and names_all(note, "material.nu packing.poisson")


def check_by_hand(folder):
    """Hertz's law with a pocket calculator: a row of beads, and the load on the floor of a layer."""
    d, force = 1e-3, 1e5 * 1e-6
    overlap = (3 * force / (4 * MODULUS / 2 * math.sqrt(d / 4))) ** (2 / 3)
    rate = math.sqrt(MODULUS * math.sqrt(d / 4 * overlap) / (math.pi / 6 * 2500 * d**3))
    sonopack("pack", scene(folder, GROUP + CHAIN.replace("20", "100")), "-o", "row.h5", "-q", cwd=folder)
    speed = row(sonopack("moduli", "row.h5", "--units=si", cwd=folder).stdout, "c_l")
    # the density is that of the bulk, whose ends cut beads
    assert abs(speed / ((100 * d - 101 * overlap) * rate / math.sqrt(100 * 101)) - 1) < 2e-5, speed
    last = sonopack("modes", "row.h5", "--frequencies-only", "--units=si", cwd=folder).stdout.splitlines()[-1]
    assert abs(float(last.split("\t")[1]) / (2 * rate * math.sin(50 * math.pi / 101)) - 1) < 1e-9, last
    # two dimensions: the pressure times the width times d
    text = "packing = { protocol = \"quick\"; grains = 60; width = \"8 mm\"; pressure = \"100 kPa\"; };\n"
    sonopack("pack", scene(folder, GROUP + text), "-o", "layer.h5", "-q", cwd=folder)
    sonopack("convert", "layer.h5", "layer.tsv", "--contact-table=load.tsv", cwd=folder)
    rows = [line.split("\t") for line in (folder / "load.tsv").read_text().splitlines() if not line.startswith("#")]
    load = sum(float(line[rows[0].index("Fn")]) for line in rows[1:] if line[1] == "bottom") * MODULUS * d**2
    assert abs(load / (1e5 * 8e-3 * d) - 1) < 1e-5, load


def check_stored(folder):
    """A packing keeps its material; numbers and names of samples do not depend on it."""
    sonopack("pack", scene(folder, GROUP + CHAIN), "-o", "a.h5", "--force", "-q", cwd=folder)
    sonopack("convert", "a.h5", "--grain-table=ga.tsv", "--contact-table=ca.tsv", cwd=folder)
    sonopack("convert", "-", "b.h5", "--grain-table=ga.tsv", "--contact-table=ca.tsv", cwd=folder)
    one, two = (sonopack("moduli", name, "--units=si", cwd=folder).stdout.replace(name, "") for name in ("a.h5", "b.h5"))
    assert one == two and "material = E=70000000000,nu=0.22,rho=2500,d=0.001" in one
    # a packing without gets it, and one with is told from another material
    text = "packing = { kind = \"chain\"; grains = 20; pressure = 1e-6; };\n"
    sonopack("pack", scene(folder, text), "-o", "c.h5", "-q", cwd=folder)
    assert names_all(sonopack("moduli", "c.h5", "--units=si", status=1, cwd=folder).stderr, "--units --material c.h5")
    sonopack("convert", "c.h5", "d.h5", OPTION.replace("d=1e-3", "d=2e-3"), cwd=folder)
    speeds = [row(sonopack("moduli", *words, cwd=folder).stdout, "c_l") for words in (("c.h5",), ("c.h5", "--units=si", OPTION), ("d.h5", "--units=si"))]
    assert abs(speeds[1] / speeds[0] / math.sqrt(MODULUS / 2500) - 1) < 1e-15 and speeds[1] == speeds[2]
    assert names_all(sonopack("moduli", "a.h5", "d.h5", "--units=si", status=1, cwd=folder).stderr, "a.h5 d.h5 --material")
    assert "material" not in sonopack("moduli", "a.h5", "d.h5", cwd=folder).stdout
    assert names_all(sonopack("moduli", "d.h5", "--units=si", OPTION, cwd=folder).stderr, "d.h5 --material d=0.002")


def check_names(folder):
    """Studies of two materials share the samples that are equal in our units."""
    text = "packing = { kind = \"chain\"; grains = [20, 40]; pressure = 1e-6; poisson = 0.22; };\nstudy = { samples = 2; want = [\"ctof\"]; };\n"
    for more in ("", GROUP, GROUP.replace("1e-3", "2e-3")):
        sonopack("study", scene(folder, more + text), "--store=names", "-q", cwd=folder)
        names = sorted(path.name for path in (folder / "names").glob("*.h5"))
        assert len(names) == 4 and (not more or names == before), "the material changes a sample's name"
        before = names
    # they were made without material: a scene or an option gives it
    sonopack("table", "ctof", "--store=names", "--units=si", status=2, cwd=folder)
    one = row(sonopack("table", "ctof", "--store=names", "--units=si", "s.cfg", cwd=folder).stdout, "c_tof")
    own = row(sonopack("table", "ctof", "--store=names", cwd=folder).stdout, "c_tof")
    assert abs(one / own / math.sqrt(MODULUS / 2500) - 1) < 1e-15


def check_options(folder):
    """Options take a number with a unit, with the material of the file."""
    time = 1e-3 / math.sqrt(MODULUS / 2500)
    own = sonopack("signal", "a.h5", f"--until={50e-6 / time:.17g}", "--points=5", cwd=folder).stdout
    si = sonopack("signal", "a.h5", "--until=50 us", "--points=5", cwd=folder).stdout
    last = [float(text.splitlines()[-1].split("\t")[0]) for text in (own, si)]
    assert abs(last[1] / last[0] - 1) < 1e-15
    for word in ("50 kPa", "50 ux", "-3 us", "50us us"):
        assert names_all(sonopack("signal", "a.h5", f"--until={word}", status=2, cwd=folder).stderr, "--until")
    assert names_all(sonopack("signal", "c.h5", "--until=50 us", status=2, cwd=folder).stderr, "--until --material")
    sonopack("signal", "c.h5", "--until=50 us", OPTION, cwd=folder)
    assert names_all(sonopack("statics", "a.h5", "d.h5", "--margin=1 mm", status=1, cwd=folder).stderr, "a.h5 d.h5 --material")
    # fronts of a table: its material, or one that is given
    for more, name in (((), "own.tsv"), (("--units=si",), "si.tsv")):
        sonopack("signal", "a.h5", *more, "-o", name, cwd=folder)
    one, two = (sonopack("front", name, "--units=si", cwd=folder).stdout for name in ("own.tsv", "si.tsv"))
    for name in ("distance", "t10", "t_peak", "t_zero", "amplitude", "width"):
        assert abs(row(one, name) / row(two, name) - 1) < 1e-14, name
    assert "distance [mm] t10 [us]" in two and "amplitude [N]" in two
    (folder / "bare.tsv").write_text("\n".join(line for line in (folder / "own.tsv").read_text().splitlines() if "material" not in line))
    sonopack("front", "bare.tsv", "--units=si", status=1, cwd=folder)
    assert row(sonopack("front", "bare.tsv", "--units=si", OPTION, cwd=folder).stdout, "t10") == row(one, "t10")
    # a window and a distance with units hold for packings and for tables in any unit; a number is in the unit of the file
    (folder / "lab.tsv").write_text("# units: t [ms] F [V]\nt\tF\n" + "".join(f"{k / 1000}\t{math.exp(-(k - 50)**2 / 50)}\n" for k in range(100)))
    for name in ("a.h5", "own.tsv", "si.tsv"):
        late = sonopack("front", name, "--units=si", "--window=60 us", "--distance=2 cm", cwd=folder)
        assert row(late.stdout, "distance") == 20 and abs(row(late.stdout, "t10") / row(one, "t10") - 1) < 1e-3, name
        sonopack("front", name, "--units=si", "--window=5 us", status=1, cwd=folder)
    assert row(sonopack("front", "lab.tsv", "--window=0.08 ms", "--distance=3 mm", cwd=folder).stdout, "distance") == 3
    assert sonopack("front", "lab.tsv", "--window=80 us", cwd=folder).stdout == sonopack("front", "lab.tsv", "--window=0.08", cwd=folder).stdout
    sonopack("front", "lab.tsv", "--window=10 us", status=1, cwd=folder)
    for words in (("--window=10 kPa",), ("--distance=-1 mm",), ("--window=1 m",), ("--distance=0 mm",)):
        assert names_all(sonopack("front", "lab.tsv", *words, status=2, cwd=folder).stderr, words[0].split("=")[0]), words
    both = sonopack("front", "own.tsv", "si.tsv", "--units=si", cwd=folder).stdout
    assert "t10 [us]" in both, "tables in both kinds of units have one unit in SI"


def main():
    with tempfile.TemporaryDirectory(prefix="sonopack-material-") as name:
        folder = pathlib.Path(name)
        for check in (check_units_of_keys, check_poisson, check_by_hand, check_stored, check_names, check_options):
            check(folder)
    print("the material holds")


if __name__ == "__main__":
    main()
