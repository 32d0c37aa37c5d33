"""sonopack study --verify --recompute: the same table for any number of jobs, and Ctrl-C stops it between samples.

usage: test_recompute.py COMMAND
"""
import pathlib
import shutil
import signal
import subprocess
import tempfile

import h5py

from common import names_all, wait_for_work
from streams import COMMAND, run

SAMPLES = 6


def restore_signals():
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # which a job in the background ignores


def false_numbers(store):
    for path in sorted(store.glob("*.h5"))[::2]:
        with h5py.File(path, "r+") as file:
            file["/results/moduli/c11"][...] = 1.01 * file["/results/moduli/c11"][()]


def main():
    with tempfile.TemporaryDirectory() as name:
        store = pathlib.Path(name) / "store"
        run("study", "-q", "--store", store, "--set", "packing.grains=150", "--set", "packing.width=10", "--set",
            f"study.samples={SAMPLES}", "--set", 'study.want=["moduli","spectrum"]')
        check = ("study", "--store", store, "--verify", "--recompute")
        process = subprocess.Popen([COMMAND, *check, "--jobs", "1"], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                   text=True, preexec_fn=restore_signals)
        wait_for_work(process, 0.05)
        process.send_signal(signal.SIGINT)
        out, said = process.communicate()
        assert process.returncode == 1 and names_all(said, SAMPLES) and out == "", (process.returncode, out, said)
        assert not list(store.glob("*.bad"))
        shutil.copytree(store, store.with_name("honest"))
        false_numbers(store)
        tables = {run("study", "-q", "--store", store, "--verify", "--recompute", "--jobs", jobs, status=1).stdout
                  for jobs in (1, 2, 5, 100)}
        assert len(tables) == 1 and tables.pop().count("/results/moduli/c11 =") == SAMPLES / 2
        run("study", "-q", "--store", store, "--verify")  # nothing else in the file contradicts it
        run("study", "-q", "--store", store.with_name("honest"), "--verify", "--recompute")
        for wrong in (("--recompute",), ("--verify", "--jobs", "2"), ("--verify", "--recompute", "--retry")):
            assert wrong[0] in run("study", "--store", store, *wrong, status=2).stderr, wrong


main()
