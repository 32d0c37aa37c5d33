"""The command as the tests call it, and the tables that it prints: the frame of every script here.

A script ends with main(TESTS): they run one after the other in one temporary folder, which is the current one.
"""
import os
import pathlib
import re
import subprocess
import sys
import tempfile

import numpy as np

from common import PATIENCE, faults, names_all
from warm import warm

COMMAND = str(pathlib.Path(sys.argv[1]).resolve())
SOURCE = pathlib.Path(__file__).resolve().parents[2]
REFERENCE = SOURCE / "packings/reference"
N200, N600 = (REFERENCE / f"packing_N{n}_p1e-4.txt" for n in (200, 600))
MATERIAL = "--material=E=70e9,nu=0.22,rho=2500,d=1e-3"


def start(*words, **options):
    return subprocess.Popen([COMMAND, *map(str, words)], **{"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE,
                                                            "stderr": subprocess.PIPE, "text": True, **options})


def tried(*words, command=None, **options):
    """The process, however it ended."""
    return subprocess.run([command or COMMAND, *map(str, words)],
                          **{"stdin": subprocess.DEVNULL, "capture_output": True, "text": True, "timeout": PATIENCE, **options})


def warmly(*words, **options):
    """tried(), of a command that Python does."""
    return tried(*words, command=warm(COMMAND) / "sonopack", **options)


def run(*words, status=0, way=tried, **options):
    """The process, which must end with this exit status. way: tried or warmly."""
    done = way(*words, **options)
    assert done.returncode == status, (words, done.returncode, done.stdout[-500:], done.stderr)
    return done


def refused(names, *words, status=2, **options):
    """What is refused prints nothing, and its first line on stderr, warnings aside, is a reason that names these words."""
    done = run(*words, status=status, **options)
    line = next((line for line in done.stderr.splitlines() if "warning" not in line), "")
    assert line.startswith("sonopack") and names_all(line, names) and not done.stdout, (words, names, done)
    return line


def sets(*keys, **packing):
    """Options --set: of whole settings, and of keys of the packing."""
    keys = [*keys, *(f"packing.{key}={value}" for key, value in packing.items())]
    return [word for key in keys for word in ("--set", key)]


def pack(path, *words, **packing):
    run("pack", "-q", "--force", *words, *sets(**packing), "-o", path)
    return path


class Table:
    """Comments, notes `key = value', units, and columns: table["t"] are numbers, table.words("file") texts."""

    def __init__(self, text):
        lines = [line for line in text.splitlines() if line]
        self.comments = [line[2:] for line in lines if line.startswith("#")]
        self.notes = dict(line.split(" = ", 1) for line in self.comments if " = " in line)
        units = [line for line in self.comments if line.startswith("units: ")]
        self.units = dict(re.findall(r"(\S+) \[([^\]]*)\]", units[0][7:])) if units else {}
        rows = [line.split("\t") for line in lines if not line.startswith("#")]
        self.names, self.rows = rows[0], rows[1:]
        self.body = rows

    def __len__(self):
        return len(self.rows)

    def __getitem__(self, name):
        return np.array([float(word) for word in self.words(name)])

    def __contains__(self, name):
        return name in self.names

    def words(self, name):
        return [row[self.names.index(name)] for row in self.rows]

    def row(self, k=0):
        return dict(zip(self.names, self.rows[k], strict=True))

    def note(self, key):
        """The number of a comment, which may be followed by more."""
        return float(re.match(r"[^\s,]+", self.notes[key])[0])


def tables(text):
    """Tables are parted by empty lines."""
    return [Table(block) for block in text.split("\n\n")]


def table(*words, **options):
    return Table(run(*words, **options).stdout)


def sanitized():
    """Whether the command is a build with the sanitizers, which keep memory of their own and want to be loaded first."""
    return "libasan" in subprocess.run(["ldd", COMMAND], capture_output=True, text=True).stdout


def main(*tests, begun=False):
    """Runs the tests. One that cannot run here returns the reason: the exit status is 77 then. begun: the commands of
    Python are begun once for all (warm.py)."""
    global COMMAND
    skipped, COMMAND = False, str(warm(COMMAND) / "sonopack") if begun else COMMAND
    with tempfile.TemporaryDirectory(prefix="sonopack-test-") as folder:
        os.chdir(folder)
        for test in tests:
            reason = test()
            print(test.__name__, f"skipped: {reason}" if reason else "ok", flush=True)
            skipped = skipped or bool(reason)
        os.chdir("/")
    print(*faults, sep="\n")
    sys.exit(1 if faults else 77 if skipped else 0)
