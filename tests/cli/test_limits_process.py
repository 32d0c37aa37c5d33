"""Limits of a process (ulimit) and files that are closed before it begins: the same result, or exit status 1 with a
reason; never an endless loop, a lost file, or a crash.

usage: test_limits_process.py COMMAND SOURCE_DIR
"""
import itertools
import os
import pathlib
import resource
import signal
import subprocess
import sys
import tempfile

from common import PATIENCE, expect, faults, names_all

COMMAND = str(pathlib.Path(sys.argv[1]).resolve())
SMALL = ["--set", "packing.grains=60", "--set", "packing.width=8"]


def run(*words, limits=(), closed=(), **options):
    """Limits: pairs of the resource and its value."""
    def prepare():
        signal.signal(signal.SIGPIPE, signal.SIG_DFL)
        for what, value in limits:
            resource.setrlimit(what, (value, value))
        for file in closed:
            os.close(file)
    return subprocess.run([COMMAND, *map(str, words)], preexec_fn=prepare, text=True, timeout=PATIENCE,
                          **{"capture_output": True, **options})


def stack(packing):
    for kilobytes in (64, 128, 256, 512):
        done = run("signal", packing, limits=[(resource.RLIMIT_STACK, kilobytes * 1024)])
        good = names_all(done.stderr, f"{kilobytes} kB") if kilobytes < 256 else done.returncode == 0
        expect(done.returncode in (0, 1) and good, f"a stack of {kilobytes} kB: {done.returncode} {done.stderr}")


def open_files(packing, folder):
    """3 is too few for the loader (127); from there on a reason, or the result."""
    for number in range(4, 12):
        path = folder / f"files{number}.tsv"
        done = run("moduli", packing, "-o", path, limits=[(resource.RLIMIT_NOFILE, number)])
        expect(done.returncode == 0 and path.exists() or done.returncode == 1 and done.stderr,
               f"{number} open files: {done.returncode} {done.stderr}")
    expect(done.returncode == 0, f"11 open files do not do: {done.stderr}")


def closed_files(packing, folder):
    """A result does not land in the number of a closed standard file, nor with it what is printed."""
    want = run("statics", packing, "-o", folder / "want.tsv")
    assert want.returncode == 0, want
    for count in (1, 2, 3):
        for closed in itertools.combinations((0, 1, 2), count):
            path = folder / f"closed{''.join(map(str, closed))}.tsv"
            done = run("statics", packing, "-o", path, closed=closed)
            expect(done.returncode == 0 and path.read_bytes() == (folder / "want.tsv").read_bytes(),
                   f"{closed} are closed: {done}")
            printed = run("statics", packing, closed=closed)
            expect(printed.returncode == (1 if 1 in closed else 0), f"{closed} are closed: {printed}")


def largest_seed(folder):
    """The range that the help of packing.seed says is the range that is accepted."""
    low, high = (word for word in run("help", "packing.seed").stdout.split("an integer", 1)[1].split()[:3] if word != "..")
    for seed, status in ((low, 0), (high, 0), (int(high) + 1, 2)):
        done = run("pack", *SMALL, "--set", f"packing.seed={seed}", "--dry-run", "-o", folder / "seed.h5")
        expect(done.returncode == status, f"packing.seed = {seed}: {done.returncode} {done.stderr}")


def main():
    with tempfile.TemporaryDirectory(prefix="sonopack-limits-") as name:
        folder = pathlib.Path(name)
        packing = folder / "P.h5"
        assert run("pack", *SMALL, "-o", packing).returncode == 0
        stack(packing)
        open_files(packing, folder)
        closed_files(packing, folder)
        largest_seed(folder)
    print("\n".join(faults) or "ok")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
