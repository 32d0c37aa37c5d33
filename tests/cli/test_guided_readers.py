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
PACKING = pathlib.Path(__file__).resolve().parents[2] / "packings/reference/packing_N200_p1e-4.txt"
LIMIT = 3 << 30


def limit_memory():
    resource.setrlimit(resource.RLIMIT_AS, (LIMIT, LIMIT))


def wide_table(folder):
    """30,000 columns and 30,000 blank lines: a table of one row, for which 7 GB were taken."""
    trial = subprocess.run([COMMAND, "help", "coda"], capture_output=True, preexec_fn=limit_memory)
    limited = trial.returncode == 0  # a build with sanitizers cannot run under the limit at all
    path = folder / "wide.csv"
    columns = 30000
    path.write_text(",".join(f"c{k}" for k in range(columns)) + "\n" * 30000 + ",".join(["1"] * columns) + "\n")
    done = subprocess.run([COMMAND, "coda", PACKING, "--before", path, "--after", path], capture_output=True, text=True,
                          preexec_fn=limit_memory if limited else None)
    assert done.returncode == 1 and "memory" not in done.stderr and "wide.csv" in done.stderr, (done.returncode, done.stderr)


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
    wide_table(pathlib.Path(scratch))
    unknown_method(pathlib.Path(scratch))
