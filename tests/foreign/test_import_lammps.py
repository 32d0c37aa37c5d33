"""LAMMPS makes packings from the decks of samples/lammps, and sonopack reads what it writes: forces equal to 1e-10 those
that follow from the overlaps. `python3 test_import_lammps.py COMMAND SOURCE_DIR`; 77 without lmp."""
import os
import re
import shutil
import subprocess
import sys
import tempfile

COMMAND, SOURCE = sys.argv[1], sys.argv[2]
SAMPLES = os.path.join(SOURCE, "tests", "foreign", "samples", "lammps")
if not shutil.which("lmp"):
    print("no lmp: skipped")
    sys.exit(77)
folder = tempfile.mkdtemp(prefix="sonopack-lammps-")


def run(*words):
    result = subprocess.run(words, capture_output=True, text=True, cwd=folder, timeout=3000)
    assert result.returncode == 0, f"{words}: {result.stdout[-2000:]} {result.stderr}"
    return result.stdout + result.stderr


def make(deck):
    shutil.copy(os.path.join(SAMPLES, deck), folder)
    shutil.copy(os.path.join(SOURCE, "share", "sonopack", "lammps_dump.in"), folder)
    return run("lmp", "-nocite", "-log", "none", "-in", deck)


def agreement(said):
    """How far the forces are from Hertz's at the overlaps."""
    return float(re.search(r"follow Hertz's law within (\S+)", said).group(1))


def check(deck, data, *words):
    printed = make(deck)
    top = re.findall(r"^top (\S+)", printed, re.M)[-1]
    options = ["--types", "1", "--set", "friction=0.5", *words]
    said = run(COMMAND, "convert", "grains.dump", "a.h5", "--contacts", "contacts.dump", *options, "--force")
    assert agreement(said) < 1e-10, said
    said = run(COMMAND, "convert", data, "b.h5", "--contacts", "contacts.dump", *options, "--set", f"top={top}", "--force")
    assert agreement(said) < 1e-10, said
    # the signal, and the same packing by our own two tables: every number the same
    run(COMMAND, "convert", "a.h5", "g.tsv", "--contacts", "c.tsv", "--force")
    run(COMMAND, "convert", "g.tsv", "c.h5", "--contacts", "c.tsv", "--force")
    rows = []
    for name in ("a.h5", "c.h5"):
        out = run(COMMAND, "signal", name, "--until", "30", "--points", "31", "--quiet")
        rows.append([line for line in out.split("\n") if not line.startswith("#")])
    assert rows[0] == rows[1] and len(rows[0]) > 31 and "nan" not in "".join(rows[0])
    return said


def make_cell(deck):
    shutil.copy(os.path.join(SOURCE, "share", "sonopack", "lammps_dump_periodic.in"), folder)
    return make(deck)


def is_balanced(said, within):
    """The grains, and the pressure: LAMMPS takes the virial of all forces, sonopack normal forces times branches."""
    assert float(re.search(r"largest net force (\S+) of the mean", said).group(1)) < within, said
    return float(re.search(r"at p = (\S+)", said).group(1))


def check_sheared():
    """A tilted cell without walls: by the dump, and by the data file, which has its tilt and no boundaries."""
    printed = make_cell("in.sheared")
    pressure = float(re.findall(r"^\s*\d+ +\S+ +(\S+) *$", printed, re.M)[-1])
    for name in ("grains.dump", "sheared.data"):
        said = run(COMMAND, "convert", name, "s.h5", "--contacts", "contacts.dump", "--set", "friction=0.5", "--force")
        assert agreement(said) < 1e-10 and "periodic along all axes, tilted by" in said, said
        assert abs(is_balanced(said, 1e-6) / pressure - 1) < 1e-5, (said, pressure)


def check_box():
    """Walls on four sides, each with the forces of its fix."""
    make("in.box")
    said = run(COMMAND, "convert", "grains.dump", "w.h5", "--contacts", "contacts.dump", "--set", "friction=0.5", "--force")
    assert agreement(said) < 1e-10 and "walls on all sides" in said and "walls: elastic" in said, said
    is_balanced(said, 1e-6)
    run(COMMAND, "check", "w.h5", "--tolerance", "0.1")


check_sheared()
check_box()
check("in.layer", "layer.data")
check("in.beads", "beads.data", "--material", "E=1e9,nu=0.22,rho=2500")
shutil.rmtree(folder)
print("lammps: forces, tables and signals agree")
