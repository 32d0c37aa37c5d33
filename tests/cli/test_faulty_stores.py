"""What happens to a store under a running study, clocks that are wrong, and samples of a newer version: no table leaves
finished samples out without a word, and no file of others is touched.

usage: test_faulty_stores.py COMMAND SOURCE_DIR
"""
import contextlib
import fcntl
import os
import pathlib
import shutil
import subprocess

import h5py

from command import main, run
from common import PATIENCE, names_all, sleeps, wait_until
from store_faults import ENVIRONMENT, SMALL, Reference, content, one_line, samples, shim

# six good samples, made in one go
SIX = SMALL.replace("1e-6, 1e-3", "1e-4, 1e-3").replace("samples = 2", "samples = 3").replace("max_steps = 3500;", "")


@contextlib.contextmanager
def claimed(store, name):
    """As long as another process makes this sample, a study makes all the others and waits."""
    store.mkdir(exist_ok=True)
    with open(store / ".sonopack-lock", "w") as file:
        fcntl.lockf(file, fcntl.LOCK_EX, 1, int(name[:16], 16) >> 2)
        yield


def remove(store):
    for path in samples(store)[:3]:
        path.unlink()


def shorten(store):
    for path in samples(store)[:3]:
        os.truncate(path, path.stat().st_size // 2)


def fill_with_zeros(store):
    for path in samples(store)[:3]:
        path.write_bytes(bytes(path.stat().st_size))


def exchange(store):
    store.rename(store.with_name("moved"))
    store.mkdir()


def forget(store):
    (store / "manifest.tsv").unlink()


def changed_under_a_study():
    """What was finished is changed before the last sample is made. Then no table may be printed that lacks it, and the
    next study completes the store. The index alone is no loss."""
    folder = pathlib.Path().resolve()
    reference = Reference(folder / "changed", SIX, stages=((),))
    last = sorted(reference.content[0])[-1].removesuffix(".h5")
    for change in (remove, shorten, fill_with_zeros, exchange, forget):
        store = folder / "store"
        with claimed(store, last):
            process = subprocess.Popen(reference.command(store, 0, "--jobs", 1), stdout=subprocess.PIPE,
                                       stderr=subprocess.PIPE, text=True, env=ENVIRONMENT)
            wait_until(lambda: process.poll() is not None or
                       (len(samples(store)) == reference.count - 1 and sleeps(process, 5)), "all other samples")
            assert process.poll() is None, process.communicate()
            change(store)
        out, err = process.communicate(timeout=PATIENCE)
        if change is forget:
            assert process.returncode == 0 and out == reference.stdout[0], err
        else:
            assert process.returncode == 1 and not out and str(store) in err.splitlines()[-1], (change, out, err)
        again = run("study", reference.scene, "--store", store)
        assert again.stdout == reference.stdout[0] and content(store) == reference.content[0], change
        shutil.rmtree(store)
        shutil.rmtree(store.with_name("moved"), ignore_errors=True)


def newer_version():
    """A sample of a format that a later version may have is neither renamed nor made again, and no table lacks it."""
    folder = pathlib.Path().resolve()
    reference = Reference(folder / "newer", SIX, stages=((),))
    store = folder / "newer-store"
    shutil.copytree(reference.store[0], store)
    (store / "manifest.tsv").unlink()
    victim = samples(store)[0]
    with h5py.File(victim, "r+") as file:
        file["sonopack"].attrs["format"] = 99
    before = content(store)
    for command in (["study", reference.scene, "--store", store], ["table", "ensemble", "--store", store]):
        refused = run(*command, status=1)
        assert not refused.stdout, refused
        one_line(refused.stderr, victim.name, "99")
    refused = run("study", "--verify", "--store", store, status=1)
    assert victim.name in refused.stdout and names_all(refused.stdout, "99"), refused
    assert content(store) == before and not list(store.glob("*.bad"))


def wrong_clock():
    """The temporary file of another machine is left alone, even where this one's clock is a year ahead."""
    folder = pathlib.Path().resolve()
    preload = shim(folder)
    if not preload:
        return "no cc, or a build with sanitizers"
    reference = Reference(folder / "clock", SIX, stages=((),))
    store = folder / "clock-store"
    store.mkdir()
    theirs = store / ".sonopack-00000000-1-1.tmp"
    for jump in ("AHEAD", "BACK"):
        theirs.write_text("being written")
        environment = {**ENVIRONMENT, "LD_PRELOAD": str(preload), "FAULTS_CALL": "clock", "FAULTS_DO": "ON",
                       "FAULTS_AT": "1", "FAULTS_ERROR": jump}
        done = subprocess.run(reference.command(store, 0), capture_output=True, text=True, env=environment)
        assert done.returncode == 0 and done.stdout == reference.stdout[0], done
        assert theirs.exists(), jump
        theirs.unlink()
        reference.check_end(store, 0)
        shutil.rmtree(store)
        store.mkdir()
    return None


main(changed_under_a_study, newer_version, wrong_clock)
