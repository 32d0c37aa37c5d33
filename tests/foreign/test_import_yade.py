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
shutil.copy(os.path.join(SOURCE, "tests", "foreign", "samples", "yade", "pack.py"), folder)
shutil.copy(os.path.join(SOURCE, "share", "sonopack", "yade_tables.py"), folder)


def run(*words):
    result = subprocess.run(words, capture_output=True, text=True, cwd=folder, timeout=3000, stdin=subprocess.DEVNULL)
    assert result.returncode == 0, f"{words}: {result.stdout[-2000:]} {result.stderr}"
    return result.stdout + result.stderr


def signal(name):
    out = run(COMMAND, "signal", name, "--until", "20", "--points", "21", "--quiet")
    return [line for line in out.split("\n") if not line.startswith("#")]


run("yade", "-n", "-x", "-j1", "pack.py")
run(COMMAND, "convert", "grains.tsv", "a.h5", "--contact-table", "contacts.tsv")
run(COMMAND, "convert", "a.h5", "--grain-table", "g.tsv", "--contact-table", "c.tsv")
run(COMMAND, "convert", "g.tsv", "b.h5", "--contact-table", "c.tsv")
assert signal("a.h5") == signal("b.h5") and len(signal("a.h5")) > 21
# forces against Hertz's law at the overlaps: the command's own check of the packing
audit = subprocess.run([COMMAND, "check", "a.h5", "--quiet"], capture_output=True, text=True, cwd=folder).stdout.split("\n")
head, row = audit[-3].split("\t"), audit[-2].split("\t")
values = dict(zip(head, row))
assert float(values["law"]) < 1e-4 and float(values["geometry"]) < 1e-8 and float(values["force"]) < 1e-3, values
# Yade's six digits: the same contacts by overlap
said = run(COMMAND, "convert", "packing_id.txt", "d.txt", "--set", "friction=0.5", "--set", "width=4", "--set", "depth=4",
           "--set", "bottom=5", "--set", "top=8.92966")
run(COMMAND, "convert", "a.h5", "a.txt")
pairs = [sorted(tuple(line.split()[:2]) for line in open(os.path.join(folder, name)).readlines()[65:]) for name in
         ("a.txt", "d.txt")]
assert pairs[0] == pairs[1], said
shutil.rmtree(folder)
print("yade: tables, forces and signals agree")
