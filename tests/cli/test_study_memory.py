"""The memory of a study hardly grows with its samples.

usage: test_study_memory.py COMMAND SOURCE_DIR
"""
import pathlib
import subprocess
import sys
import tempfile

from streams import COMMAND

FEW, MANY = 60, 720
A_SAMPLE = 4.0     # kB: sp_sample is 2.7
CONSTANT = 4096.0  # kB: what the allocator and the libraries keep or not
LARGEST = 200000   # kB: that a study may take at all
CHAINS = ("--set", 'packing.kind="chain"', "--set", "packing.grains=12", "--set", "signal.until=20.0", "--set",
          "signal.points=101", "--jobs", "2")  # the quickest samples that there are

# The peak of a process counts what it was before exec: a small parent starts the command.
PARENT = """import os, sys
child = os.posix_spawn(sys.argv[1], sys.argv[1:], os.environ,
                       file_actions=[(os.POSIX_SPAWN_OPEN, 1, "/dev/null", os.O_WRONLY, 0)])
_, status, usage = os.wait4(child, 0)
print(os.waitstatus_to_exitcode(status), usage.ru_maxrss)
"""


def peak(*args):
    """Largest resident memory [kB]."""
    done = subprocess.run([sys.executable, "-I", "-S", "-c", PARENT, COMMAND, *map(str, args)], capture_output=True,
                          text=True, check=True)
    status, size = map(int, done.stdout.split())
    assert status == 0, (args, done)
    return size


def check(what, few, many):
    growth = (many - few) / (MANY - FEW)
    print(f"{what}: {few} kB with {FEW} samples, {many} kB with {MANY}: {growth:.2f} kB a sample")
    assert many < LARGEST, many
    assert many - few < A_SAMPLE * (MANY - FEW) + CONSTANT, (few, many)


def main(folder):
    if "libasan" in subprocess.run(["ldd", COMMAND], capture_output=True, text=True).stdout:
        print("skipped: the sanitizers keep memory of their own")
        sys.exit(77)
    store = {n: folder / f"store{n}" for n in (FEW, MANY)}
    for what, want in (("a study", '["statics","signal"]'), ("the same, all of it there", '["statics","signal"]'),
                       ("with one want more", '["statics","signal","moduli"]')):
        check(what, *(peak("study", "--store", store[n], "--set", f"study.samples={n}", "--set", f"study.want={want}",
                           *CHAINS) for n in store))
    for table in ("ensemble", "signal"):
        check("table " + table, *(peak("table", table, "--store", store[n]) for n in store))


with tempfile.TemporaryDirectory() as name:
    main(pathlib.Path(name))
