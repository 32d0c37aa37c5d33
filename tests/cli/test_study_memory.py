"""The memory of a study hardly grows with its samples.

usage: test_study_memory.py COMMAND SOURCE_DIR
"""
import subprocess
import sys

from command import COMMAND, main, sanitized, sets
from test_dry_run import PARENT

FEW, MANY = 60, 720
A_SAMPLE = 4.0     # kB: sp_sample is 2.7
CONSTANT = 4096.0  # kB: what the allocator and the libraries keep or not
LARGEST = 200000   # kB: that a study may take at all
CHAINS = [*sets("signal.until=20.0", "signal.points=101", kind="chain", grains=12), "--jobs", "2"]  # the quickest samples


def peak(*words):
    """Largest resident memory [kB]."""
    done = subprocess.run([sys.executable, "-I", "-S", "-c", PARENT, COMMAND, *map(str, words)], capture_output=True,
                          text=True, check=True)
    status, size = map(int, done.stdout.split())
    assert status == 0, (words, done)
    return size


def check(what, few, many):
    print(f"{what}: {few} kB with {FEW} samples, {many} kB with {MANY}: {(many - few) / (MANY - FEW):.2f} kB a sample")
    assert many < LARGEST and many - few < A_SAMPLE * (MANY - FEW) + CONSTANT, (few, many)


def studies():
    if sanitized():
        return "the sanitizers keep memory of their own"
    for what, want in (("a study", '["statics","signal"]'), ("the same, all of it there", '["statics","signal"]'),
                       ("with one want more", '["statics","signal","moduli"]')):
        check(what, *(peak("study", "--store", f"store{n}", *sets(f"study.samples={n}", f"study.want={want}"), *CHAINS)
                      for n in (FEW, MANY)))
    for kind in ("ensemble", "signal"):
        check("table " + kind, *(peak("table", kind, "--store", f"store{n}") for n in (FEW, MANY)))
    return None


main(studies)
