"""What guided fuzzing found in readers and no corpus can show: memory out of proportion, and words of a sample that mean
nothing.

usage: test_guided_readers.py COMMAND
"""
import pathlib
import resource
import subprocess
import sys
import tempfile

import h5py

from streams import run

COMMAND = sys.argv[1]
LIMIT = 3 << 30


def limit_memory():
    resource.setrlimit(resource.RLIMIT_AS, (LIMIT, LIMIT))


def unknown_method(folder):
    """The method of a stored signal was any word, and taken for the first method."""
    scene, store = folder / "s.cfg", folder / "store"
    scene.write_text('packing = { kind = "chain"; grains = 6; friction = 0.0; };\n'
                     'study = { want = ["ctof", "signal"]; samples = 1; };\n')
    run("study", scene, "--store", store, "-o", folder / "t.tsv", "-q")
    run("study", scene, "--store", store, "--verify")
    sample = next(store.glob("*.h5"))
    with h5py.File(sample, "r+") as file:
        del file["/signal/method"]
        file["/signal/method"] = "loud"
    done = subprocess.run([COMMAND, "study", scene, "--store", store, "--verify"], capture_output=True, text=True)
    assert done.returncode != 0 and "/signal/method" in done.stdout + done.stderr, (done.returncode, done.stdout, done.stderr)


with tempfile.TemporaryDirectory(prefix="sonopack-guided-") as scratch:
    unknown_method(pathlib.Path(scratch))
