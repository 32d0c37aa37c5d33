"""sonopack convert on files of other programs: the samples of tests/foreign/samples, and everything that can be wrong."""
import math
import os
import subprocess
import sys
import tempfile

from common import names_all

COMMAND, SOURCE = sys.argv[1], sys.argv[2]
SAMPLES = os.path.join(SOURCE, "tests", "foreign", "samples")
FOLDER = tempfile.mkdtemp(prefix="sonopack-import-")
FRICTION = ("--set", "friction=0.5")
TOP = 8.8661880014055292  # the upper wall that the deck in.layer printed
failures = []


def expect(condition, what):
    if not condition:
        failures.append(what)
        print("FAILED:", what)


def path(name):
    return os.path.join(FOLDER, name)


def sample(name):
    return os.path.join(SAMPLES, name)


def write(name, text):
    with open(path(name), "w", newline="") as f:
        f.write(text)
    return path(name)


def convert(*words, status=0, says=""):
    result = subprocess.run([COMMAND, "convert", *words, "--force"], capture_output=True, text=True, timeout=1200,
                            cwd=FOLDER)
    what = f"convert {' '.join(words)}: status {result.returncode}, {result.stderr}"
    expect(result.returncode == status, what)
    expect(not says or names_all(result.stderr, says), f"'{says}' in: {what}")
    return result.stderr


def refuse(*words, status=1, says=""):
    """The import fails, says all of these words, and writes nothing."""
    said = convert(*words, "-o", "no.h5", status=status, says=says)
    expect(not os.path.exists(path("no.h5")), f"nothing written: {words}")
    if os.path.exists(path("no.h5")):
        os.remove(path("no.h5"))
    return said


def numbers(file):
    lines = [line.split() for line in open(path(file)) if line.strip() and not line.startswith("#")]
    n = int(lines[0][1])
    head = dict(zip(lines[0][::2], lines[0][1::2]))
    return head, [tuple(map(float, line)) for line in lines[1:1 + n]], [tuple(map(float, line)) for line in lines[1 + n:]]


def dump(name):
    lines = open(sample(name)).read().split("\n")
    at = next(k for k, line in enumerate(lines) if line.startswith(("ITEM: ATOMS", "ITEM: ENTRIES")))
    names = lines[at].split()[2:]
    return [dict(zip(names, line.split())) for line in lines[at + 1:] if line]


def close(a, b, tolerance):
    return abs(a - b) <= tolerance * max(abs(a), abs(b))


# ---- LAMMPS --------------------------------------------------------------------------------------------------------

def test_lammps_layer():
    said = convert(sample("lammps/layer_grains.dump"), "a.txt", "--contacts", sample("lammps/layer_contacts.dump"),
                   "--types", "1", *FRICTION, says="elastic")
    head, grains, contacts = numbers("a.txt")
    there = {int(g["id"]): g for g in dump("lammps/layer_grains.dump") if g["type"] == "1"}
    order = sorted(there)
    expect(len(grains) == 72 and head["wall"] == "elastic", "72 grains between elastic walls")
    for k, g in enumerate(grains):
        own = there[order[k]]
        expect(g[:3] == (float(own["x"]), float(own["y"]), float(own["radius"])), f"grain {k}: every bit of LAMMPS'")
    pairs = {(int(c[0]), int(c[1])): c for c in contacts}
    listed = 0
    for c in dump("lammps/layer_contacts.dump"):
        i, j, fn = int(c["c_sp_id[1]"]), int(c["c_sp_id[2]"]), float(c["c_sp_contact[2]"])
        if fn == 0 or i not in there or j not in there:
            continue
        listed += 1
        swap = i > j
        ours = pairs[order.index(min(i, j)), order.index(max(i, j))]
        r1, r2 = float(there[i]["radius"]), float(there[j]["radius"])
        overlap = r1 + r2 - float(c["c_sp_contact[1]"])
        hertz = 4 / 3 * 0.5 * math.sqrt(r1 * r2 / (r1 + r2)) * overlap**1.5
        expect(close(ours[5], fn, 1e-15), f"Fn of {i} {j} is LAMMPS'")
        expect(close(ours[4], overlap, 1e-10) and close(hertz, fn, 1e-10), f"overlap of {i} {j} gives LAMMPS' force")
        ft = [float(c["c_sp_contact[3]"]), float(c["c_sp_contact[4]"])]
        along = (-ft[0] if swap else ft[0]) * -ours[3] + (-ft[1] if swap else ft[1]) * ours[2]
        expect(abs(ours[6] - along) < 1e-15, f"Ft of {i} {j} acts on the first grain")
    walls = [c for c in contacts if c[1] < 0]
    expect(len(pairs) - len(walls) == listed and len(walls) == 11, "as many contacts as in LAMMPS")
    for side, fix in ((-1, "f_floor"), (-2, "f_roof")):
        own = sum(abs(float(g[fix + "[3]"])) for g in there.values())
        expect(close(sum(c[5] for c in walls if c[1] == side), own, 1e-12), f"the force on {fix}")
        expect(close(own / 8, float(head["p"]), 1e-8), "the pressure is that of the walls")
    expect("net force" in said, "the balance is reported")


def test_same_in_every_form():
    """The files of every form hold the same packing: every number the same, within the rounding of derived ones."""
    ways = {
        "lammps": [sample("lammps/layer_grains.dump"), "--contacts", sample("lammps/layer_contacts.dump"), "--types", "1"],
        "data": [sample("lammps/layer.data"), "--contacts", sample("lammps/layer_contacts.dump"), "--types", "1",
                 "--walls", sample("csv/walls.csv"), "--set", f"top={TOP!r}"],
        "liggghts": [sample("liggghts/grains.dump"), "--from", "liggghts", "--contacts", sample("liggghts/contacts.dump"),
                     "--walls", sample("liggghts/walls.dump")],
        "mercury": [sample("mercury/layer.data"), "--contacts", sample("mercury/layer.fstat")],
        "xyz": [sample("xyz/layer.xyz"), "--contacts", sample("csv/contacts.csv"), "--walls", sample("csv/walls.csv")],
        "csv": [sample("csv/grains.csv"), "--contacts", sample("csv/contacts.csv"), "--walls", sample("csv/walls.csv"),
                "--set", "width=8", "--set", "bottom=0", "--set", f"top={TOP!r}"],
    }
    first = None
    for name, words in ways.items():
        convert(*words, name + ".txt", *FRICTION)
        head, grains, contacts = numbers(name + ".txt")
        first = first or (head, grains, contacts)
        expect(close(float(head["p"]), float(first[0]["p"]), 1e-14) and head["wall"] == "elastic", f"{name}: header")
        expect(len(grains) == len(first[1]) and len(contacts) == len(first[2]), f"{name}: sizes")
        for a, b in zip(grains, first[1]):
            expect(all(close(x, y, 1e-15) for x, y in zip(a, b)), f"{name}: grain {a} {b}")
        for a, b in zip(contacts, first[2]):
            expect(a[:2] == b[:2] and all(abs(x - y) <= 1e-13 for x, y in zip(a[2:], b[2:])), f"{name}: contact {a} {b}")


def test_own_tables_are_the_same():
    """What was imported goes through our own two tables with every bit."""
    convert(sample("lammps/layer_grains.dump"), "a.h5", "--contacts", sample("lammps/layer_contacts.dump"), "--types",
            "1", *FRICTION)
    convert("a.h5", "--grain-table", "g.tsv", "--contact-table", "c.tsv")
    convert("g.tsv", "b.h5", "--contact-table", "c.tsv")
    expect(open(path("a.h5"), "rb").read() == open(path("b.h5"), "rb").read(), "HDF5 -> tables -> HDF5")
    signals = [subprocess.run([COMMAND, "signal", name, "--until", "40", "--points", "5"], capture_output=True,
                              text=True, cwd=FOLDER) for name in ("a.h5", "b.h5")]
    rows = [[line for line in s.stdout.split("\n") if not line.startswith("#")] for s in signals]
    expect(signals[0].returncode == 0 and rows[0] == rows[1] and len(rows[0]) > 5, "the same signal")


def test_si():
    """Beads in SI: walls of this LAMMPS are 1 + nu times as stiff as elastic ones, and keep their own stiffness."""
    words = [sample("lammps/beads_grains.dump"), "--contacts", sample("lammps/beads_contacts.dump"), "--types", "1",
             *FRICTION, "--material", "E=1e9,nu=0.22,rho=2500"]
    said = convert(*words, "a.h5", says="1.22 times kPa")
    expect("replaces" not in said and "warning" not in said, "the material is the file's, with its diameter: " + said)
    import h5py  # as the other tests of files do
    with h5py.File(path("a.h5")) as f:
        m = f["sonopack/material"]
        diameters = [2 * float(g["radius"]) for g in dump("lammps/beads_grains.dump") if g["type"] == "1"]
        mean = sum(diameters) / len(diameters)
        expect(close(m["diameter"][()], mean, 1e-14) and m["young"][()] == 1e9, "the material is in the file")
        kn, fn = f["sonopack/contacts/normal_stiffness"][:], f["sonopack/contacts/normal_force"][:]
        overlap, pair = f["sonopack/contacts/overlap"][:], f["connectivity/contacts"][:] if "contacts" in f["connectivity"] else None
        own = kn > 0
        expect(own.sum() == 17, "17 contacts with walls have a stiffness of their own")
        expect(abs(kn[own] / (1.5 * fn[own] / overlap[own]) - 1).max() < 1e-14, "3/2 Fn/overlap")
        e_star = 1e9 / (1 - 0.22**2)
        expect(close(f["sonopack/pressure"][()] * e_star, 1e5, 1e-5), "100 kPa")
    convert(*words, "b.h5", "--set", "wall=elastic")
    half = convert(*words[:-2], "--material", "E=0.5e9,nu=0.22,rho=2500", "-o", "c.h5", status=1, says="2 times Hertz")
    expect("E" in half, half)
    refuse(*words[:-2], says="0.2 .. 5 --material", status=2)
    convert(*words[:-2], "--material", "E=1e9,nu=0.22,rho=2500,d=1", "-o", "c.h5", status=2, says="length-unit")


def test_digits():
    six, contacts = sample("lammps/layer_grains6.dump"), sample("lammps/layer_contacts6.dump")
    convert(six, "a.txt", "--contacts", contacts, "--types", "1", *FRICTION, says="%.17g")
    convert(sample("lammps/layer_grains.dump"), "b.txt", "--contacts", sample("lammps/layer_contacts.dump"), "--types",
            "1", *FRICTION)
    for a, b in zip(numbers("a.txt")[2], numbers("b.txt")[2]):
        expect(a[:2] == b[:2] and close(a[4], b[4], 1e-5), f"overlaps come from the forces: {a} {b}")
    # overlaps of 1e-4 in a box of 1000: six digits are worth nothing, ten are
    for digits, status in ((6, 1), (12, 0)):
        rows = [(k + 1, 500 + 2 / 3 + 0.9999 * k + 1e-6 * math.sin(k), 0.49995, 0.5) for k in range(8)]
        text = "id,x,y,radius\n" + "".join("%d,%s,%s,%s\n" % (i, *(f"{v:.{digits}g}" for v in (x, y, r))) for i, x, y, r in rows)
        write("row.csv", text)
        words = ["row.csv", "--contacts", "overlap", "--set", "sides=open", "--set", "bottom=0", "--set", "top=5", *FRICTION]
        if status:
            refuse(*words, says="digits %.17g")
        else:
            convert(*words, "row.h5")


# ---- other forms ---------------------------------------------------------------------------------------------------

def test_yade():
    convert(sample("yade/grains.tsv"), "a.txt", "--contact-table", sample("yade/contacts.tsv"))
    head, grains, contacts = numbers("a.txt")
    expect(len(grains) == 63 and head["wall"] == "grain", "Yade's walls respond like grains")
    for c in contacts:  # Hertz' law in our units, by hand
        r = grains[int(c[0])][3] / 2 if c[1] < 0 else 1 / (1 / grains[int(c[0])][3] + 1 / grains[int(c[1])][3])
        expect(abs(c[6] / (4 / 3 * 0.5 * math.sqrt(r) * c[5]**1.5) - 1) < 1e-4, f"Fn of {c[:2]}")
    words = ["--set", "width=4", "--set", "depth=4", "--set", "bottom=5", "--set", "top=8.92966", *FRICTION]
    convert(sample("yade/packing_id.txt"), "b.txt", *words, says="overlap grain")
    convert(sample("yade/packing.xyzr"), "c.txt", *words)
    expect(numbers("b.txt") == numbers("c.txt"), "with ids and without")
    expect([c[:2] for c in numbers("b.txt")[2]] == [c[:2] for c in contacts], "the same contacts, by overlap")
    refuse(sample("yade/packing.xyzr"), *FRICTION, status=2, says="width sides=open")


def test_photoelastic():
    words = [sample("photoelastic/particles.csv"), "--contacts", sample("photoelastic/contacts.csv"), "--frame", "1",
             "--material", "E=4e6,nu=0.5,rho=1060", "--length-unit", "0.05e-3", "--kn", "5e4", "--kt-ratio", "0.5",
             "--thickness", "6e-3", *FRICTION]
    said = convert(*words, "a.h5", says="photoelastic no period")
    convert(*words, "--walls", "balance", "b.h5")
    import csv
    import h5py
    grains = [g for g in csv.DictReader(open(sample("photoelastic/particles.csv"))) if g["frame"] == "1"]
    listed = [c for c in csv.DictReader(open(sample("photoelastic/contacts.csv"))) if c["frame"] == "1"]
    d = 2 * sum(float(g["radius"]) for g in grains) / len(grains) * 0.05e-3
    modulus = 4e6 / (1 - 0.25)
    with h5py.File(path("a.h5")) as f:
        fn, kn, kt = (f["sonopack/contacts/" + k][:] for k in ("normal_force", "normal_stiffness", "tangential_stiffness"))
        expect(len(fn) == len(listed), "no contact with a wall is listed")
        expect(close(fn.sum() * modulus * d * d, sum(float(c["Fn"]) for c in listed), 1e-12), "forces in N")
        expect(abs(kn * modulus * d / 5e4 - 1).max() < 1e-12 and abs(kt / kn - 0.5).max() < 1e-12, "stiffnesses in N/m")
        radius = float(grains[0]["radius"]) * 0.05e-3
        mass, inertia = f["particles/grains/mass"][:].ravel()[0], f["particles/grains/inertia"][:].ravel()[0]
        expect(close(mass * 1060 * d**3, math.pi * radius**2 * 6e-3 * 1060, 1e-12), "the mass of a disk")
        expect(close(inertia / mass * d * d, radius**2 / 2, 1e-12), "its moment of inertia")
    signal = subprocess.run([COMMAND, "signal", "b.h5", "--until", "30", "--points", "4"], capture_output=True, text=True,
                            cwd=FOLDER)
    expect(signal.returncode == 0 and "nan" not in signal.stdout, "a signal through the disks: " + signal.stderr)
    refuse(*words[:5], *FRICTION, status=2, says="material")
    refuse(*words[:7], *FRICTION, status=2, says="kn")
    refuse(*words[:1], *words[3:], status=2, says="contacts")
    refuse(*words[:3], "--frame", "3", *words[5:], status=2, says="frame 3 2")


def test_mirror():
    """An image with y downwards is mirrored: Ft, which is a number along t, changes its sign with the axis."""
    words = [sample("photoelastic/particles.csv"), "--contacts", sample("photoelastic/contacts.csv"), "--frame", "1",
             "--material", "E=4e6,nu=0.5,rho=1060", "--length-unit", "0.05e-3", "--kn", "5e4", "--kt-ratio", "0.5",
             "--thickness", "6e-3", *FRICTION]
    balance = [float(convert(*words, *columns, "-o", name).split("net force ")[1].split()[0]) for name, columns in (
        ("a.h5", ()), ("b.h5", ("--columns", "y=-y")), ("c.h5", ("--columns", "y=-y,ft=-Ft")),
        ("d.h5", ("--columns", "y=-y,ft=Ft")))]
    expect(balance[0] == balance[1] == balance[2] < balance[3], f"net forces {balance}")
    expect(open(path("b.h5"), "rb").read() == open(path("c.h5"), "rb").read(), "a sign that is given for Ft is the one taken")
    # vectors
    rows = [sample("csv/grains.csv"), "--contacts", sample("csv/contacts.csv"), "--walls", sample("csv/walls.csv"),
            "--set", "width=8", *FRICTION]
    convert(*rows, "-o", "a.txt", "--set", "bottom=0", "--set", f"top={TOP!r}")
    convert(*rows, "-o", "b.txt", "--columns", "y=-y", "--set", f"bottom={-TOP!r}", "--set", "top=0")
    a, b = numbers("a.txt"), numbers("b.txt")
    expect(close(float(a[0]["p"]), float(b[0]["p"]), 1e-14) and len(a[2]) == len(b[2]), "the same pressure")
    other = {(int(c[0]), int(c[1])): c for c in b[2]}
    for c in a[2]:
        m = other[int(c[0]), int(c[1]) if c[1] >= 0 else -3 - int(c[1])]
        expect(abs(c[2] - m[2]) < 1e-9 and abs(c[3] + m[3]) < 1e-9 and close(c[5], m[5], 1e-9) and
               abs(c[6] + m[6]) < 1e-13, f"mirrored: {c} {m}")


def test_rest():
    said = convert(sample("lammps/layer.data"), "a.h5", "--contacts", "overlap", "--types", "1", "--set", f"top={TOP!r}",
                   *FRICTION, "--rest", says="at rest rigid height")
    convert(sample("lammps/layer.data"), "b.h5", "--contacts", "overlap", "--types", "1", "--set", f"top={TOP!r}",
            *FRICTION, "--rest", "--material", "E=1e9,nu=0,rho=1,d=1", says="E* kPa mm")
    check = subprocess.run([COMMAND, "check", "a.h5"], capture_output=True, text=True, cwd=FOLDER)
    expect(check.returncode == 0, "the packing at rest is right: " + check.stdout + said)


def test_axes():
    """A layer that stands in another plane, or upside down, is the same packing."""
    words = ["--walls", "none", *FRICTION, "--set", "pressure=1e-4"]
    convert(sample("csv/grains.csv"), "a.txt", *words, "--set", "width=8", "--set", "bottom=0", "--set", "height=8.9")
    text = open(sample("csv/grains.csv")).read().split("\n")
    turned = ["id,z,x,y,radius"] + [f"{g[0]},{g[1]},{g[2]},7.5,{g[3]}" for g in (line.split(",") for line in text[1:] if line)]
    write("t.csv", "\n".join(turned))
    convert("t.csv", "b.txt", *words, "--set", "up=x", "--set", "width=8", "--set", "bottom=0", "--set", "height=8.9")
    expect(numbers("a.txt") == numbers("b.txt"), "up=x")
    convert(sample("csv/grains.csv"), "c.txt", *words, "--columns", "y=-y", "--set", "width=8", "--set", "bottom=-8.9",
            "--set", "top=0")
    for a, b in zip(numbers("a.txt")[1], numbers("c.txt")[1]):
        expect(a[0] == b[0] and abs(a[1] + b[1] - 8.9) < 1e-12, "y downwards")
    write("own.tsv", "# width = 8\n# friction = 0.5\n# pressure = 1e-4\n# height = 8.9\n# bottom = 0\n"
          + open(sample("csv/grains.csv")).read().replace(",", "\t"))
    convert("own.tsv", "d.txt", "--contacts", "overlap", "--walls", "none", says="friction=0.5")
    expect(numbers("a.txt") == numbers("d.txt"), "a table of ours alone, with its keys, and contacts by overlap")
    refuse("t.csv", *words, "--set", "up=y", "--set", "width=8", status=2, says="up")


def test_own_stiffnesses_and_masses():
    write("g.csv", "id,x,y,radius,mass,inertia\n1,1,0.499,0.5,0.5,0.05\n2,1.99,0.5,0.5,0.6,0.04\n# a comment\n\n")
    write("c.csv", "id1,id2,fn,kn,kt,ft\n2,1,0.003,0.3,0.1,-0.0005\n")
    convert("g.csv", "a.h5", "--contacts", "c.csv", "--walls", "none", *FRICTION, *EXACT, "--set", "sides=open", "--set",
            "bottom=0", "--set", "top=1", "--set", "pressure=1e-3")
    import h5py
    with h5py.File(path("a.h5")) as f:
        c = f["sonopack/contacts"]
        expect(c["normal_stiffness"][0] == 0.3 and c["tangential_stiffness"][0] == 0.1, "kn and kt")
        expect(c["normal_force"][0] == 0.003 and close(c["overlap"][0], 0.01, 1e-14), "overlap = Fn/kn")
        expect(list(f["particles/grains/mass"][:].ravel()) == [0.5, 0.6], "masses")
        expect(list(f["particles/grains/inertia"][:].ravel()) == [0.05, 0.04], "moments of inertia")
    convert("a.h5", "--grain-table", "gg.tsv", "--contact-table", "cc.tsv")
    row = dict(zip(*(line.split("\t") for line in open(path("cc.tsv")).read().split("\n")[-3:-1])))
    # the force on grain 2 along t of n from 2 to 1 is that on grain 1 along t of n from 1 to 2
    expect(float(row["Ft"]) == -0.0005, f"Ft turns with n: {row}")
    convert("g.csv", "a.h5", "--contacts", "overlap", "--kn", "0.2", "--kt-ratio", "0", *FRICTION, *EXACT, "--set",
            "sides=open", "--set", "bottom=0", "--set", "top=1")
    with h5py.File(path("a.h5")) as f:
        c = f["sonopack/contacts"]
        overlap, fn = c["overlap"][:], c["normal_force"][:]
        found = sorted(overlap)
        expect(len(found) == 2 and close(found[0], 0.001, 1e-12), f"springs by overlap, at the wall too: {found}")
        expect(close(found[1], 1 - math.hypot(0.99, 0.001), 1e-12) and abs(fn / overlap - 0.2).max() < 1e-14, "F = kn overlap")
    write("c.csv", "id1,id2,fn,ft_x,ft_y\n1,2,0.003,0,0\ntop,1,0.002,0.0001,0\n2,bottom,0.001,0,0\n")
    convert("g.csv", "w.h5", "--contacts", "c.csv", "--kn", "0.2", *FRICTION, *EXACT, "--set", "sides=open", "--set",
            "bottom=0", "--set", "top=1")
    convert("w.h5", "--grain-table", "gw.tsv", "--contact-table", "cw.tsv")
    walls = [line.split("\t") for line in open(path("cw.tsv")).read().split("\n") if "bottom" in line or "top" in line]
    expect([w[:4] for w in walls] == [["1", "bottom", "0", "-1"], ["0", "top", "0", "1"]], f"walls by name: {walls}")
    write("c.csv", "id1,id2,fn\nbottom,top,0.003\n")
    refuse("g.csv", "--contacts", "c.csv", "--kn", "1", *FRICTION, *EXACT, "--set", "sides=open", says="c.csv:2 top")
    write("c.csv", "id1,id2,fn,kn\n1,2,0.003,-1\n")
    refuse("g.csv", "--contacts", "c.csv", *FRICTION, *EXACT, "--set", "sides=open", says="stiffness -1")


# ---- what can be wrong ---------------------------------------------------------------------------------------------

ROW = "ITEM: TIMESTEP\n7\nITEM: NUMBER OF ATOMS\n3\nITEM: BOX BOUNDS pp ff pp\n0 4\n0 1\n-0.5 0.5\n"
ATOMS = ROW + "ITEM: ATOMS id type x y z radius\n1 1 0.5 0.4999 0 0.5\n2 1 1.4999 0.5001 0 0.5\n3 1 2.4998 0.5 0 0.5\n"
LINKS = ("ITEM: TIMESTEP\n7\nITEM: NUMBER OF ENTRIES\n2\nITEM: ENTRIES c_1[1] c_1[2] c_2[1]\n1 2 1e-7\n2 3 1e-7\n")
EXACT = ("--set", "digits=exact")
COLUMNS = ("--columns", "id1=c_1[1],id2=c_1[2],fn=c_2[1]")


def test_bad_dumps():
    words = ["a.dump", *FRICTION, *EXACT]
    write("a.dump", ATOMS)
    convert(*words, "a.h5")
    write("a.dump", ATOMS.replace("\n", "\r\n"))
    convert(*words, "b.h5")
    expect(open(path("a.h5"), "rb").read() == open(path("b.h5"), "rb").read(), "CRLF")
    for text, says in (
            (ATOMS[:ATOMS.index("3 1 2.4998")], "a.dump:11 2 of 3"),  # truncated between rows
            (ATOMS[:-8], "a.dump:12 cells 6"),  # and within one
            (ATOMS[:-2], "a.dump:12 ends"),  # and within the last number
            (ROW, "a.dump:8"),
            (ATOMS.replace("1.4999 ", "nan "), "a.dump:11 x nan"),
            (ATOMS.replace("1.4999 ", "1.49.99 "), "a.dump:11 x 1.49.99"),
            (ATOMS.replace("2 1 1.4999", "1 1 1.4999"), "a.dump:11 1 line 10"),  # an id twice
            (ATOMS.replace("2 1 1.4999", "2.5 1 1.4999"), "a.dump:11 id 2.5"),
            (ATOMS.replace("radius", "q"), "a.dump radius columns"),
            (ATOMS.replace(" 0.5\n2", " -0.5\n2"), "a.dump:10 radius -0.5 positive"),
            (ATOMS.replace("0 4\n", "4 0\n"), "a.dump:6 4 0"),
            (ATOMS.replace("pp ff pp", "xy xz yz pp ff pp").replace("0 4\n", "0 4 0\n"), "a.dump:7 tilt"),
            (ATOMS.replace("pp ff pp", "abc origin pp ff pp"), "a.dump:5 xy xz yz"),
            (ATOMS.replace("NUMBER OF ATOMS\n3", "NUMBER OF ATOMS\n1000000000"), "a.dump:12 3 of 1000000000"),
            (ATOMS.replace(" 1 0.5 0.4999", ",1,0.5,0.4999"), "a.dump:10 commas"),
            (ATOMS.replace("0.4999 0 0.5", "1.7 0 0.5"), "a.dump:10 between the walls"),
    ):
        write("a.dump", text)
        refuse(*words, says=says)
    write("a.dump", ATOMS.replace("pp ff pp", "pp pp pp"))
    refuse(*words, status=2, says="height two")  # a period that is too small
    refuse(*words, "--set", "cell=piston", status=2, says="periodic across=drop")
    write("a.dump", "\x00\x01\x02")
    refuse("a.dump", says="a.dump")
    write("a.dump", ATOMS)
    refuse("a.dump", status=2, says="friction")
    refuse(*words, "--types", "2", says="type 2")
    refuse(*words, "--frame", "8", status=2, says="8 7")
    refuse(*words, "--set", "colour=red", status=2, says="colour")
    refuse(*words, "--set", "top=high", status=2, says="top high")
    refuse(*words, "--set", "poisson=0.7", status=2, says="poisson 0.7")
    refuse(*words, "--columns", "idd=id", status=2, says="idd role")
    refuse(*words, "--columns", "mass=weight", status=2, says="weight columns")
    refuse(*words, "--from", "vtk", status=2, says="vtk lammps-data")
    refuse(*words, "--material", "E=1e9", status=2, says="nu")


def test_loose_grains():
    """Nothing touches the walls of fix wall/gran: their points of contact, zeros, are no places of walls."""
    names = " ".join(f"f_{fix}[{k}]" for fix in ("floor", "roof") for k in range(1, 8))
    none, floor = " 0" * 7, " 1 0 1e-5 0 0.5 0 0"
    text = ATOMS.replace("radius\n", f"radius {names}\n").replace("ff", "pp")
    lines = text.split("\n")
    for flags in ((none + none,) * 3, (floor + none, none + none, none + none)):
        at = next(k for k, line in enumerate(lines) if line.startswith("ITEM: ATOMS"))
        rows = lines[:at + 1] + [line + flag for line, flag in zip(lines[at + 1:at + 4], flags)]
        write("l.dump", "\n".join(rows).replace("pp pp pp", "pp ff pp") + "\n")
        said = convert("l.dump", "-o", "l.h5", *FRICTION, *EXACT, "--set", "wall=rigid", says="upper")
        expect("inf" not in said and "outside" not in said, "the box gives the place of the wall: " + said)
    write("a.dump", ATOMS.replace("1 1 0.5 0.4999 0 0.5", "1 1 0.5 1.6999 0 0.5"))
    refuse("a.dump", *FRICTION, *EXACT, says="a.dump:10 y 1.6999 between the walls 0 1 1 of 3 touch")


def test_help():
    """Options stand under the heading of their direction."""
    text = subprocess.run([COMMAND, "help", "convert"], capture_output=True, text=True).stdout
    before, after = text.index("Packings of other programs:"), text.index("Files for other programs:")
    for option in ("--from", "--walls", "--columns", "--rest", "--thickness"):
        expect(before < text.index(f" {option}", before) < after, f"{option} is of the import")
    for option in ("--to", "--vectors", "--times"):
        expect(after < text.index(f" {option} ", after), f"{option} is of the export")


def test_bad_contacts():
    write("a.dump", ATOMS)
    words = ["a.dump", "--contacts", "c.dump", *FRICTION, *EXACT, "--set", "wall=rigid"]
    write("c.dump", LINKS)
    refuse(*words, says="id1 c_1[1] --columns")
    refuse(*words, *COLUMNS, says="times Hertz")  # the overlaps ask for other forces
    hertz = 4 / 3 * 0.5 * 0.5 * (1 - math.hypot(0.9999, 0.0002))**1.5, 4 / 3 * 0.5 * 0.5 * (1 - math.hypot(0.9999, 0.0001))**1.5
    good = LINKS.replace("1 2 1e-7", f"1 2 {hertz[0]!r}").replace("2 3 1e-7", f"2 3 {hertz[1]!r}")
    write("c.dump", good)
    convert(*words, *COLUMNS, "a.h5")
    write("c.dump", good.replace("1 2 ", "2 1 "))
    convert(*words, *COLUMNS, "b.h5")
    expect(open(path("a.h5"), "rb").read() == open(path("b.h5"), "rb").read(), "the order of a pair does not matter")
    for text, says in (
            (good.replace("2 3 ", "2 9 "), "c.dump:7 9 id"),
            (good.replace("2 3 ", "2 2 "), "c.dump:7 2"),
            (good.replace("2 3 ", "2 1 ").replace("ENTRIES\n2", "ENTRIES\n2"), "c.dump:7 line 6"),
            (good.replace(f"{hertz[1]!r}", "-1e-7"), "c.dump:7 attraction"),
            (good.replace(f"{hertz[1]!r}", "inf"), "c.dump:7 c_2[1] inf"),
            (good.replace("TIMESTEP\n7", "TIMESTEP\n8"), "c.dump 7"),
    ):
        write("c.dump", text)
        refuse(*words, *COLUMNS, status=2 if "TIMESTEP\n8" in text else 1, says=says)
    refuse("a.dump", "--contacts", "none.dump", *FRICTION, says="none.dump")


def test_lists_that_cannot_be():
    """Columns of an axis that a plane does not have may be named; lists without pairs, or with far too few, are refused."""
    grains, contacts = sample("lammps/layer_grains.dump"), sample("lammps/layer_contacts.dump")
    words = (grains, "--types", "1", *FRICTION)
    named = "id1=c_sp_id[1],id2=c_sp_id[2],fn=c_sp_contact[2]," + ",".join(
        f"ft_{axis}=c_sp_contact[{k}]" for axis, k in zip("xyz", (3, 4, 5)))
    convert(*words, "--contacts", contacts, "--columns", named, "-o", "named.txt")
    convert(*words, "--contacts", contacts, "-o", "usual.txt")
    expect(numbers("named.txt") == numbers("usual.txt"), "columns by name and by usual names")
    text = open(contacts).read()
    head = text[:text.index("\n", text.index("ITEM: ENTRIES")) + 1]
    rows = text[len(head):].splitlines(keepends=True)
    few = head.replace(f"\n{len(rows)}\n", "\n40\n") + "".join(rows[:40])
    none = head.replace(f"\n{len(rows)}\n", "\n0\n")
    refuse(*words, "--contacts", write("few.dump", few), says="few.dump pairs")
    refuse(*words, "--contacts", write("none_listed.dump", none), says="none_listed.dump overlap")
    said = convert(grains, "--types", "1", "--set", "friction=0", "--contacts", contacts, "-o", "smooth.h5")
    expect(names_all(said, "nan rattlers"), f"no balance where all grains are rattlers: {said}")


def test_own_csv():
    """What convert writes as CSV comes back with the contacts of the walls."""
    convert(sample("lammps/layer_grains.dump"), "--contacts", sample("lammps/layer_contacts.dump"), "--types", "1",
            *FRICTION, "-o", "P.h5")
    convert("P.h5", "-o", "q.csv")
    convert("P.h5", "-o", "P.txt")
    edge = numbers("P.txt")[0]
    convert("q.csv", "--contacts", "q-contacts.csv", *FRICTION, "--set", f"width={edge['Lx']}", "--set", "bottom=0", "--set",
            f"top={edge['Ly']}", "--set", "wall=elastic", "-o", "Q.h5")
    tables = []
    for name in ("P", "Q"):
        convert(f"{name}.h5", "--grain-table", path(f"{name}-g.tsv"), "--contact-table", path(f"{name}-c.tsv"))
        tables.append([line.split("\t")[:2] for line in open(path(f"{name}-c.tsv")) if not line.startswith("#")])
    expect(tables[0] == tables[1], "contacts of our own CSV are those of the packing")
    columns = [line.split() for line in open(path("Q-c.tsv")) if not line.startswith("#")][0]
    expect("kn" not in columns, "Hertz's stiffnesses are no stiffnesses of their own")


def test_sense():
    """Force vectors on the second grain are turned by the positions; turned tangential forces are pointed out."""
    contacts = open(sample("csv/contacts.csv")).read().split("\n")
    grains = {g[0]: g for g in (line.split(",") for line in open(sample("csv/grains.csv")).read().split("\n")[1:] if line)}
    lines, turned = ["id1,id2,f_x,f_y"], [contacts[0]]
    for line in contacts[1:-1]:
        i, j, fn, fx, fy = line.split(",")
        d = [float(grains[j][1]) - float(grains[i][1]), float(grains[j][2]) - float(grains[i][2])]
        d[0] -= 8 * round(d[0] / 8)
        r = math.hypot(*d)
        lines.append(f"{i},{j},{float(fn) * d[0] / r - float(fx)!r},{float(fn) * d[1] / r - float(fy)!r}")
        turned.append(f"{i},{j},{fn},{-float(fx)!r},{-float(fy)!r}")
    write("on_second.csv", "\n".join(lines) + "\n")
    write("turned.csv", "\n".join(turned) + "\n")
    words = [sample("csv/grains.csv"), "--walls", sample("csv/walls.csv"), "--set", "width=8", "--set", "bottom=0", "--set",
             f"top={TOP!r}", *FRICTION]
    convert(*words, "--contacts", sample("csv/contacts.csv"), "-o", "a.txt")
    convert(*words, "--contacts", "on_second.csv", "-o", "b.txt", says="turned")
    for a, b in zip(numbers("a.txt")[2], numbers("b.txt")[2]):
        expect(all(abs(x - y) < 1e-13 for x, y in zip(a, b)), f"{a} {b}")
    convert(*words, "--contacts", "turned.csv", "-o", "c.txt", says="other sign")
    convert(*words, "--contacts", "turned.csv", "--columns", "ft_x=-ft_x,ft_y=-ft_y", "-o", "d.txt")
    expect(numbers("a.txt") == numbers("d.txt"), "a minus in --columns turns them back")


def test_bad_data():
    data = open(sample("lammps/layer.data")).read()
    words = ["a.data", "--contacts", "overlap", "--types", "1", "--set", f"top={TOP!r}", *FRICTION]
    write("a.data", data)
    convert(*words, "a.h5")
    for text, says in (
            (data.replace("# sphere", "# ellipsoid"), "a.data:10 ellipsoid sphere"),
            (data.replace("# sphere", "# hybrid sphere bond"), "hybrid"),
            (data[:data.index("Atoms")], "Atoms"),
            (data[:3000], "a.data:"),
            (data.replace("0 8 xlo xhi", "0 8 xlo xhi\n1 0 0 xy xz yz"), "tilted"),
            (data.replace("73 atoms", "80 atoms"), "a.data:"),
    ):
        write("a.data", text)
        refuse(*words, says=says)
    write("a.data", data.replace("0 8 xlo xhi\n", ""))
    refuse(*words, status=2, says="width")


def test_fully_periodic():
    """A box that is periodic on all axes is a periodic cell, or cut where asked, and the cut contacts are counted."""
    text = ("ITEM: TIMESTEP\n1\nITEM: NUMBER OF ATOMS\n16\nITEM: BOX BOUNDS pp pp pp\n0 3.996\n0 3.996\n-1 1\n"
            "ITEM: ATOMS id type xs ys zs radius\n")
    for k in range(16):
        text += f"{k + 1} 1 {(k % 4 + 0.5) / 4:.17g} {(k // 4 + 0.5) / 4:.17g} 0.5 0.5\n"
    write("p.dump", text)
    refuse("p.dump", *FRICTION, *EXACT, "--set", "cell=piston", status=2, says="across=drop up=")
    convert("p.dump", "a.txt", *FRICTION, *EXACT)
    expect(numbers("a.txt")[0]["cell"] == "periodic" and len(numbers("a.txt")[2]) == 32, "all 32 contacts")
    convert("p.dump", "a.txt", *FRICTION, *EXACT, "--set", "across=drop", says="4 contacts across")
    expect(len(numbers("a.txt")[2]) == 28, "of 32 contacts 28 are left")


def test_other_files():
    write("a.txt", "hello\n")
    convert("a.txt", "b.h5", status=1, says="a.txt")
    convert("a.txt", "b.h5", "--types", "1", status=2, says="types --from")
    write("a.csv", "id,x,y,radius\n1,0.5,0.5,0.5\n2,1.49,0.5,0.5,7\n")
    refuse("a.csv", *FRICTION, "--set", "sides=open", says="a.csv:3 5 4")
    write("a.csv", "1,0.5,0.5,0.5\n")
    refuse("a.csv", "--from", "csv", *FRICTION, says="a.csv:1 header")
    write("a.xyz", "3\nLattice=\"4 0 0 0 1 0 0 0 1\" Properties=pos:R:3:radius:R:1\n0.5 0.5 0 0.5\n")
    refuse("a.xyz", *FRICTION, says="a.xyz:3 1 of 3")
    write("a.xyz", "1\nLattice=\"4 1 0 0 1 0 0 0 1\" Properties=pos:R:3:radius:R:1\n0.5 0.5 0 0.5\n")
    refuse("a.xyz", *FRICTION, says="a.xyz:2 Lattice x")
    write("m.data", "2 0 0 0 0 4 1 1\n0.5 0.5 0 0 0 0 0.5 0 0 0 0 0 0 0\n")
    refuse("m.data", *FRICTION, says="m.data:2 1 of 2")


for test in [value for name, value in list(globals().items()) if name.startswith("test_")]:
    test()
print(f"{len(failures)} failures" if failures else "import: all fine")
sys.exit(1 if failures else 0)
