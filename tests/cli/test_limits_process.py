"""Limits of a process (ulimit) and files that are closed before it begins: the same result, or exit status 1 with a
reason; never an endless loop, a lost file, or a crash.

usage: test_limits_process.py COMMAND SOURCE_DIR
"""
import itertools
import os
import pathlib
import resource
import signal

from command import main, pack, tried
from common import expect, names_all

PACKING = "P.h5"


def run(*words, limits=(), closed=()):
    """Limits: pairs of the resource and its value."""
    def prepare():
        signal.signal(signal.SIGPIPE, signal.SIG_DFL)
        for what, value in limits:
            resource.setrlimit(what, (value, value))
        for file in closed:
            os.close(file)
    return tried(*words, preexec_fn=prepare, stdin=None)


def stack():
    pack(PACKING, grains=60, width=8)
    for kilobytes in (64, 128, 256, 512):
        done = run("signal", PACKING, limits=[(resource.RLIMIT_STACK, kilobytes * 1024)])
        good = names_all(done.stderr, f"{kilobytes} kB") if kilobytes < 256 else done.returncode == 0
        expect(done.returncode in (0, 1) and good, f"a stack of {kilobytes} kB: {done.returncode} {done.stderr}")


def open_files():
    """3 is too few for the loader (127); from there on a reason, or the result."""
    for number in range(4, 12):
        path = pathlib.Path(f"files{number}.tsv")
        done = run("moduli", PACKING, "-o", path, limits=[(resource.RLIMIT_NOFILE, number)])
        expect(done.returncode == 0 and path.exists() or done.returncode == 1 and done.stderr,
               f"{number} open files: {done.returncode} {done.stderr}")
    expect(done.returncode == 0, f"11 open files do not do: {done.stderr}")


def closed_files():
    """A result does not land in the number of a closed standard file, nor with it what is printed."""
    want = run("statics", PACKING, "-o", "want.tsv")
    assert want.returncode == 0, want
    for count in (1, 2, 3):
        for closed in itertools.combinations((0, 1, 2), count):
            path = pathlib.Path(f"closed{''.join(map(str, closed))}.tsv")
            done = run("statics", PACKING, "-o", path, closed=closed)
            expect(done.returncode == 0 and path.read_bytes() == pathlib.Path("want.tsv").read_bytes(),
                   f"{closed} are closed: {done}")
            printed = run("statics", PACKING, closed=closed)
            expect(printed.returncode == (1 if 1 in closed else 0), f"{closed} are closed: {printed}")


main(stack, open_files, closed_files)
