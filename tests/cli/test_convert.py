"""sonopack convert: every way between HDF5, text and tables, what it refuses, and that no bit is lost."""
import os
import shutil
import subprocess
import sys
import tempfile

from common import names_all

COMMAND, SOURCE = sys.argv[1], sys.argv[2]
FOLDER = tempfile.mkdtemp(prefix="sonopack-convert-")
failures = []


def expect(condition, what):
    if not condition:
        failures.append(what)
        print("FAILED:", what)


def convert(*words, status=0, says=""):
    result = subprocess.run([COMMAND, "convert", *words], capture_output=True, text=True, timeout=1200, cwd=FOLDER)
    what = f"convert {' '.join(words)}: status {result.returncode}, {result.stderr}"
    expect(result.returncode == status, what)
    expect(not says or names_all(result.stderr, says), f"'{says}' in: {what}")
    expect(result.stdout == "", "nothing on stdout: " + what)
    return result


def path(name):
    return os.path.join(FOLDER, name)


def read(name):
    with open(path(name), "rb") as f:
        return f.read()


def write(name, text):
    with open(path(name), "w") as f:
        f.write(text)


def numbers(file):
    """Header, grains, and contacts (sorted) of a text packing, as exact doubles."""
    lines = [line.split() for line in open(file) if line.strip() and not line.startswith("#")]
    n = int(lines[0][1])
    grains = [tuple(map(float, line)) for line in lines[1:1 + n]]
    contacts = sorted(tuple(map(float, line)) for line in lines[1 + n:])
    header = dict(zip(lines[0][::2], map(float, lines[0][1::2])))
    return header, grains, contacts


def test_reference_round_trips():
    for name in ("packing_N200_p1e-4.txt", "packing_N600_p1e-4.txt"):
        original = os.path.join(SOURCE, "packings", "reference", name)
        said = convert(original, "a.h5", says="a.h5").stderr
        expect(said.count("\n") == 1, "one line: " + said)
        convert("a.h5", "b.txt")
        expect(numbers(original) == numbers(path("b.txt")), f"{name}: text -> HDF5 -> text, every number the same")
        convert("b.txt", "c.h5")
        expect(read("a.h5") == read("c.h5"), f"{name}: HDF5 -> text -> HDF5, every byte the same")
        convert("a.h5", "--grains", "g.tsv", "--contacts", "c.tsv", says="g.tsv")
        convert("--grains", "g.tsv", "--contacts", "c.tsv", "d.h5", says="d.h5")
        expect(read("a.h5") == read("d.h5"), f"{name}: HDF5 -> tables -> HDF5, every byte the same")
        convert("d.h5", "d.txt", "--grains", "g2.tsv", "--contacts", "c2.tsv")
        expect(read("g.tsv") == read("g2.tsv") and read("c.tsv") == read("c2.tsv"), f"{name}: both forms at once")
        for file in os.listdir(FOLDER):
            os.remove(path(file))


def test_no_friction_round_trip():
    """A force of zero has no sign: packings without friction survive every way, too."""
    made = subprocess.run([COMMAND, "pack", "--set", "packing.grains=40", "--set", "packing.width=8", "--set",
                           "packing.friction=0", "--quiet", "-o", "a.txt"], capture_output=True, text=True, cwd=FOLDER)
    expect(made.returncode == 0, "pack: " + made.stderr)
    convert("a.txt", "a.h5")
    convert("a.h5", "b.txt")
    expect(read("a.txt") == read("b.txt"), "no friction: text -> HDF5 -> text, every byte the same")
    convert("a.h5", "--grains", "g.tsv", "--contacts", "c.tsv")
    convert("--grains", "g.tsv", "--contacts", "c.tsv", "d.h5")
    expect(read("a.h5") == read("d.h5"), "no friction: HDF5 -> tables -> HDF5, every byte the same")
    convert("d.h5", "--grains", "g2.tsv", "--contacts", "c2.tsv")
    expect(read("c.tsv") == read("c2.tsv") and b"-0\n" not in read("c.tsv"), "no friction: tables, no negative zero")
    for file in os.listdir(FOLDER):
        os.remove(path(file))


GRAINS = """# width = 10
# height = 4
# pressure = 1e-4
# friction = 0.5
id x y radius
a 1 0.5 0.5
b 1.9 0.5 0.5
7 -5 2 0.5
"""
CONTACTS = """i j nx ny overlap Ft
a b 1 0 0.1 1e-3
7 b 0.6 0.8 0.05 -1e-4
a bottom 0 -1 0.001 0
"""


def test_ways():
    write("g.tsv", GRAINS)
    write("c.tsv", CONTACTS)
    convert("new.txt", "--grains", "g.tsv", "--contacts", "c.tsv")  # one packing that is not there: made
    header, grains, contacts = numbers(path("new.txt"))
    expect(header["p"] == 1e-4 and header["nu"] == 0 and grains[2][0] == 5, "header, wrapped position")
    expect(contacts[2][:4] == (1, 2, -0.6, -0.8) and contacts[2][6] == -1e-4, "turned contact")
    hertz = 4 / 3 * 0.5 * 0.25**0.5 * 0.1**1.5
    expect(abs(contacts[1][5] / hertz - 1) < 1e-14, "Hertz' law fills in Fn")
    convert("-o", "o.txt", "--grains", "g.tsv", "--contacts", "c.tsv")
    convert("g.tsv", "i.txt", "--contacts", "c.tsv")
    convert("g.tsv", "j.txt", "--grains", "g.tsv", "--contacts", "c.tsv")
    convert("-", "k.txt", "--grains", "g.tsv", "--contacts", "c.tsv")
    for name in "oijk":
        expect(read(f"{name}.txt") == read("new.txt"), f"{name}.txt like new.txt")
    convert("new.txt", "eg.tsv", "--contacts", "ec.tsv")
    convert("new.txt", "--grains", "fg.tsv", "--contacts", "fc.tsv")
    expect(read("eg.tsv") == read("fg.tsv") and read("ec.tsv") == read("fc.tsv"), "two ways to export")
    convert("g.tsv", "set.txt", "--contacts", "c.tsv", "--set", "pressure=2e-5", "--set", "packing.friction=0.3")
    expect(numbers(path("set.txt"))[0]["p"] == 2e-5 and numbers(path("set.txt"))[0]["mu"] == 0.3, "--set overrides")
    expect(convert("new.txt", "q.h5", "--quiet").stderr == "", "--quiet")


def test_refusals():
    write("g.tsv", GRAINS)
    write("c.tsv", CONTACTS)
    convert("g.tsv", "P.h5", "--contacts", "c.tsv")
    before = read("P.h5")
    convert(status=2, says="")
    convert("P.h5", status=2, says="")
    convert("P.h5", "Q.h5", "R.h5", status=2, says="")
    convert("P.h5", "Q.xyzzy", status=2, says=".h5 .txt")
    convert("P.h5", "Q", status=2, says=".h5 .txt")
    convert("P.h5", "Q.h5", "-o", "R.h5", status=2, says="-o")
    convert("P.h5", "Q.h5", "--grains", "g.tsv", status=2, says="--grains")
    convert("P.h5", "--grains", "g.tsv", "--contacts", "c.tsv", status=2, says="P.h5")
    convert("P.h5", "Q.h5", "--set", "pressure=1", status=2, says="--set")
    convert("g.tsv", "Q.h5", "--contacts", "c.tsv", "--set", "colour=red", status=2, says="colour=red")
    convert("g.tsv", "Q.h5", "--contacts", "c.tsv", "--set", "pressure=x", status=2, says="pressure x")
    convert("P.h5", "--bogus", status=2)
    write("old.h5", "my notes")
    write("notes.txt", "my notes")
    for name in ("old.h5", "notes.txt"):
        convert("P.h5", name, "--force", status=2, says=name)
        expect(read(name) == b"my notes", "a file of another kind stays")
    convert("P.h5", "old.txt")
    old = read("old.txt")
    convert("P.h5", "old.txt", status=2, says="--force")
    expect(read("old.txt") == old, "no overwriting without --force")
    convert("P.h5", "old.txt", "--force")
    convert("old.txt", "P.h5", status=2, says="--force")
    convert("P.h5", "P.h5", "--force")
    expect(read("P.h5") == before, "a file onto itself")
    convert("P.h5", "absent/Q.h5", status=1, says="absent")
    convert("nowhere.h5", "Q.h5", status=1, says="nowhere.h5")
    convert("g.tsv", "Q.h5", "--contacts", "nowhere.tsv", status=1, says="nowhere.tsv")
    write("bad.tsv", GRAINS.replace("1.9", "nan"))
    convert("bad.tsv", "Q.h5", "--contacts", "c.tsv", status=1, says="bad.tsv:7 x nan")
    write("bad.txt", "N 3 Lx 10 Ly 4 p 1e-4 mu 0.5 nu 0 contacts 0 bottom 0 top 0\n1 1 0.5 0\n")
    convert("bad.txt", "Q.h5", status=1, says="bad.txt:1")
    expect(not os.path.exists(path("Q.h5")), "nothing stands under the name of what failed")
    leftovers = [name for name in os.listdir(FOLDER) if name.endswith(".tmp")]
    expect(leftovers == [], f"no temporary files: {leftovers}")


def test_full_device():
    write("g.tsv", GRAINS)
    write("c.tsv", CONTACTS)
    os.symlink("/dev/full", path("full.h5"))
    os.symlink("/dev/full", path("full.txt"))
    for name, says in (("full.h5", "regular file"), ("full.txt", "No space left")):
        convert("g.tsv", name, "--contacts", "c.tsv", status=1, says=says)
        expect(os.path.islink(path(name)), "the device stays")


for name, test in list(globals().items()):
    if name.startswith("test_"):
        before = len(failures)
        for file in os.listdir(FOLDER):
            os.remove(path(file))
        test()
        print("ok" if len(failures) == before else "FAILED", name)
shutil.rmtree(FOLDER)
sys.exit(1 if failures else 0)
