"""Yade makes a packing, and sonopack reads what yade_tables.py and Yade's own exports write.
`python3 test_import_yade.py COMMAND SOURCE_DIR`; 77 without yade."""
import os
import shutil
import subprocess
import sys
import tempfile

COMMAND, SOURCE = sys.argv[1], sys.argv[2]
if not shutil.which("yade"):
    print("no yade: skipped")
    sys.exit(77)
folder = tempfile.mkdtemp(prefix="sonopack-yade-")
for script in ("pack.py", "pack_periodic.py"):
    shutil.copy(os.path.join(SOURCE, "tests", "foreign", "samples", "yade", script), folder)
shutil.copy(os.path.join(SOURCE, "share", "sonopack", "yade_tables.py"), folder)


def run(*words):
    result = subprocess.run(words, capture_output=True, text=True, cwd=folder, timeout=3000, stdin=subprocess.DEVNULL)
    assert result.returncode == 0, f"{words}: {result.stdout[-2000:]} {result.stderr}"
    return result.stdout + result.stderr


def signal(name):
    out = run(COMMAND, "signal", name, "--until", "20", "--points", "21", "--quiet")
    return [line for line in out.split("\n") if not line.startswith("#")]


run("yade", "-n", "-x", "-j1", "pack.py")
run(COMMAND, "convert", "grains.tsv", "a.h5", "--contacts", "contacts.tsv")
run(COMMAND, "convert", "a.h5", "--grains", "g.tsv", "--contacts", "c.tsv")
run(COMMAND, "convert", "g.tsv", "b.h5", "--contacts", "c.tsv")
assert signal("a.h5") == signal("b.h5") and len(signal("a.h5")) > 21


def audit(name):
    """Forces against Hertz's law at the overlaps: the command's own check of the packing."""
    lines = subprocess.run([COMMAND, "check", name, "--quiet"], capture_output=True, text=True, cwd=folder).stdout.split("\n")
    return dict(zip(lines[-3].split("\t"), lines[-2].split("\t")))


values = audit("a.h5")
assert float(values["law"]) < 1e-4 and float(values["geometry"]) < 1e-8 and float(values["force"]) < 1e-3, values
# Yade's six digits: the same contacts by overlap
said = run(COMMAND, "convert", "packing_id.txt", "d.txt", "--set", "friction=0.5", "--set", "width=4", "--set", "depth=4",
           "--set", "bottom=5", "--set", "top=8.92966")
run(COMMAND, "convert", "a.h5", "a.txt")
pairs = [sorted(tuple(line.split()[:2]) for line in open(os.path.join(folder, name)).readlines()[65:]) for name in
         ("a.txt", "d.txt")]
assert pairs[0] == pairs[1], said
# a sheared cell without walls; Yade's damping lets forces balance within 2e-3 of the load
run("yade", "-n", "-x", "-j1", "pack_periodic.py")
run(COMMAND, "convert", "grains.tsv", "p.txt", "--contacts", "contacts.tsv")
assert " cell periodic xy 0.75" in open(os.path.join(folder, "p.txt")).read(), "cell"
values = audit("p.txt")
assert float(values["law"]) < 1e-4 and float(values["geometry"]) < 1e-8 and float(values["force"]) < 1e-2, values
assert float(values["walls"]) < 1e-12, values  # the pressure in the table is that of the contacts
shutil.rmtree(folder)
print("yade: tables, forces and signals agree")
