"""valgrind finds no leak and no invalid access in short runs of the command, failures included.

usage: test_leaks.py COMMAND SOURCE_DIR
"""
import os
import pathlib
import shutil
import subprocess

from command import COMMAND, N200, main, sanitized, sets
from common import expect

CHAIN = sets(kind="chain", grains=20)
STUDY = """packing = { kind = "chain"; friction = 0; };
study = { samples = 1; want = ["ctof", "spectrum"]; sweep = ( { key = "packing.grains"; values = [10, 20]; } ); };
"""
# The C library's loader compares strings eight bytes at a time when it loads a library with a run path.
SUPPRESSIONS = """{
    loader
    Memcheck:Addr8
    fun:strncmp
    fun:is_dst
    ...
}
"""
ERROR = 99
# (expected status, arguments); the work of each is small, and the runs are few: valgrind takes a second to begin
RUNS = [
    (0, ["pack", "scene.cfg", *CHAIN, "-o", "chain.h5"]),
    (0, ["check", "chain.h5", "reference.txt"]),
    (0, ["signal", "chain.h5", "--points", "200", "-o", "chain.tsv"]),
    (0, ["front", "chain.tsv"]),
    (0, ["modes", "chain.h5", "--all"]),
    (0, ["modes", "cluster.txt", "--lowest", "2"]),
    (0, ["pack", "scene.cfg", *CHAIN, "-o", "chain.txt"]),
    (0, ["statics", "chain.txt"]),
    (0, ["moduli", "reference.txt"]),
    (0, ["study", "study.cfg", "--store", "store", "--jobs", "2"]),
    (0, ["table", "ensemble", "--store", "store", "--format", "json"]),
    (0, ["table", "spectrum", "study.cfg", "--store", "store", "--bins", "5"]),
    (0, ["help"]),
    (1, ["check", "truncated.h5"]),
    (1, ["front", "flat.tsv"]),
    (1, ["table", "ctof", "--store", "nowhere"]),
    (2, ["pack", "wrong.cfg", "-o", "never.h5"]),
    (2, ["signal"]),
]


def cluster():
    """Smooth spheres in a cubic lattice, most of whose contacts are missing: motions of every kind that cost nothing."""
    at = {(x, y, z): x + 3 * y + 9 * z for x in range(3) for y in range(3) for z in range(2)}
    bulk, walls = [], []
    for (x, y, z), i in at.items():
        for n, j in (((1, 0, 0), at[(x + 1) % 3, y, z]), ((0, 1, 0), at[x, (y + 1) % 3, z]),
                     ((0, 0, 1), at.get((x, y, z + 1), -2))):
            if (i + n.index(1) + j) % 3 != 1:
                (bulk if j >= 0 else walls).append((i, j, *n))
        if z == 0:
            walls.append((i, -1, 0, 0, -1))
    top = sum(c[1] == -2 for c in walls)
    lines = ["# packing: a cubic lattice", f"N 18 Lx 3 Ly 3 Lz 2 p 1e-4 mu 0 nu 0.3 contacts {len(bulk)} bottom 9 top {top}"]
    lines += [f"{x + 0.5} {y + 0.5} {z + 0.5} 0.5 0" for x, y, z in sorted(at, key=at.get)]
    lines += [" ".join(map(str, c)) + " 0.001 0.1 0 0 0" for c in bulk + walls]
    return "\n".join(lines) + "\n"


def leaks():
    if not shutil.which("valgrind") or sanitized():
        return "no valgrind, or a build with sanitizers, which find leaks themselves"
    # a plain kernel of the linear algebra: valgrind does not know every instruction of the newest processors
    env = dict(os.environ, OPENBLAS_CORETYPE="Prescott", OPENBLAS_NUM_THREADS="1")
    for name, text in (("scene.cfg", "packing = { pressure = 1e-4; };\n"), ("suppressions", SUPPRESSIONS), ("study.cfg", STUDY),
                       ("flat.tsv", "t\tF\n0\t0\n1\t0\n2\t0\n3\t0\n"), ("reference.txt", N200.read_text()),
                       ("cluster.txt", cluster()), ("wrong.cfg", "packing = { presure = 1e-4; };\n")):
        pathlib.Path(name).write_text(text)
    for status, words in RUNS:
        if "truncated.h5" in words:
            pathlib.Path("truncated.h5").write_bytes(pathlib.Path("chain.h5").read_bytes()[:-500])
        done = subprocess.run(["valgrind", "--quiet", "--leak-check=full", "--errors-for-leak-kinds=definite",
                               "--show-leak-kinds=definite", f"--error-exitcode={ERROR}", "--log-file=valgrind.log",
                               "--read-inline-info=no", "--suppressions=suppressions", COMMAND, *words],
                              env=env, text=True, capture_output=True)
        report = pathlib.Path("valgrind.log").read_text()
        expect(done.returncode == status and not report.strip(),
               f"sonopack {' '.join(words)}: exit status {done.returncode}, expected {status}\n{done.stderr}{report}")
    return None


main(leaks)
