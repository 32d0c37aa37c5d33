"""--dry-run: a table of what would be made, for every command that has it; nothing is written, nothing is computed.

usage: test_dry_run.py COMMAND SOURCE_DIR
"""
import math
import os
import pathlib
import re
import subprocess
import sys
import tempfile

from common import PATIENCE, names_all

COMMAND, SOURCE = str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2]).resolve()
N200 = SOURCE / "packings/reference/packing_N200_p1e-4.txt"
COLUMNS = "what count cpu_s wall_s memory_MB disk_MB".split()


def run(*words, status=0):
    done = subprocess.run([COMMAND, *map(str, words)], text=True, capture_output=True, stdin=subprocess.DEVNULL,
                          timeout=PATIENCE)
    assert done.returncode == status, (words, done.returncode, done.stderr)
    return done.stderr if status else done.stdout


def sets(*keys):
    return [word for key in keys for word in ("--set", key)]


def snapshot(folder):
    """Every name below a folder, with size and times of change."""
    return {str(path): (path.stat().st_size, path.stat().st_mtime_ns) for path in [folder, *folder.rglob("*")]}


def plan(*words):
    """The rows of a dry run by their names. Nothing in the current folder changes."""
    before = snapshot(pathlib.Path.cwd())
    lines = [line.split("\t") for line in run(*words, "--dry-run").splitlines() if not line.startswith("#")]
    assert snapshot(pathlib.Path.cwd()) == before, f"{words}: something was written"
    assert lines[0] == COLUMNS, lines[0]
    rows = {line[0]: dict(zip(COLUMNS[1:], map(float, line[1:]), strict=True)) for line in lines[1:]}
    assert list(rows)[-1] == "total", list(rows)
    total = rows["total"]
    work = [row for name, row in rows.items() if name != "total"]
    if not math.isnan(total["cpu_s"]):
        assert abs(sum(row["cpu_s"] for row in work) - total["cpu_s"]) <= 0.02 * total["cpu_s"], rows
    assert abs(sum(row["disk_MB"] for row in work) - total["disk_MB"]) <= 0.02 * total["disk_MB"] + 1e-6, rows
    return rows


# The peak of a process counts what it was before exec: a small parent starts the command.
PARENT = """import os, sys
child = os.posix_spawn(sys.argv[1], sys.argv[1:], os.environ,
                       file_actions=[(os.POSIX_SPAWN_OPEN, 1, os.devnull, os.O_WRONLY, 0)])
_, status, usage = os.wait4(child, 0)
print(os.waitstatus_to_exitcode(status), usage.ru_maxrss)
"""


def test_memory():
    """Resident memory of making spheres against what is foretold, beyond that of a command that makes next to nothing."""
    def peak(*words):
        done = subprocess.run([sys.executable, "-I", "-S", "-c", PARENT, COMMAND, "pack", "-q", "--threads", "1", *words],
                              text=True, capture_output=True, check=True)
        status, size = map(int, done.stdout.split())
        assert status == 0, done
        return 1.024e-3 * size

    if "libasan" in subprocess.run(["ldd", COMMAND], capture_output=True, text=True).stdout:
        return  # the sanitizers keep memory of their own
    little = sets('packing.kind="chain"', "packing.grains=10", "packing.friction=0")
    keys = sets("packing.dimension=3", "packing.grains=3000", "packing.width=16", "packing.pressure=1e-2",
                'packing.protocol="quick"', "packing.tolerance=1e-5")
    foretold = plan("pack", *keys, "-o", "M.h5")["total"]["memory_MB"] - plan("pack", *little, "-o", "M1.h5")["total"]["memory_MB"]
    measured = peak(*keys, "-o", "M.h5") - peak(*little, "-o", "M1.h5")
    assert measured / 1.5 < foretold < 1.5 * measured, (foretold, measured)


def test_pack():
    keys = sets("packing.grains=100", "packing.width=10", 'packing.protocol="quick"')
    total = plan("pack", *keys, "-o", "P.h5")["total"]
    run("pack", *keys, "-q", "-o", "P.h5")
    size = 1e-6 * os.path.getsize("P.h5")
    assert abs(total["disk_MB"] / size - 1) < 0.1, (total, size)
    large = plan("pack", *sets("packing.grains=100000", "packing.width=316"), "-o", "L.h5")["total"]
    assert large["cpu_s"] > 1e4 * total["cpu_s"] and large["memory_MB"] > 2 * total["memory_MB"]
    history = plan("pack", *keys, *sets("packing.history=[1e-3, 1e-5]"), "-o", "H.h5")
    assert history["packings of the history"]["count"] == 2
    assert history["total"]["cpu_s"] > 1.2 * total["cpu_s"]
    # what the work would refuse, the plan refuses
    assert names_all(run("pack", *keys, "--dry-run", "-o", "P.h5", status=2), "P.h5")
    assert names_all(run("pack", *sets("packing.width=1"), "--dry-run", "-o", "Q.h5", status=2), "packing.width")
    run("pack", *keys, "--dry-run", "-o", "nowhere/Q.h5", status=1)
    run("pack", *keys, "--dry-run", status=2)


def test_study():
    keys = sets("packing.grains=60", "packing.width=8", 'packing.protocol="quick"', "study.samples=3",
                'study.want=["ctof", "moduli"]')
    words = ["study", *keys, "--store", "store"]
    rows = plan(*words)
    assert not os.path.exists("store")
    assert rows["samples"]["count"] == rows["packings"]["count"] == rows["moduli"]["count"] == 3
    assert rows["samples in the store"]["count"] == 0
    run(*words, "-q")
    size = sum(1e-6 * path.stat().st_size for path in pathlib.Path("store").glob("*.h5"))
    assert abs(rows["total"]["disk_MB"] / size - 1) < 0.25, (rows, size)
    rows = plan(*words)
    assert rows["samples in the store"]["count"] == 3 and "packings" not in rows
    more = plan("study", *keys, *sets("study.samples=5"), "--store", "store")
    assert more["samples in the store"]["count"] == 3 and more["packings"]["count"] == 2
    # their packings are there: only the new part is to be made
    probes = plan("study", *keys, *sets('study.want=["ctof", "moduli", "statics", "probes"]'), "--store", "store")
    assert "packings" not in probes or probes["packings"]["count"] == 0, probes
    assert probes["probes"]["count"] == 3
    shard = plan("study", *keys, *sets("study.samples=8"), "--store", "other", "--shard", "1/4")
    assert shard["packings"]["count"] == 2
    many = plan("study", *keys, *sets("study.samples=1000000"), "--store", "store")
    assert many["samples"]["count"] == 1000000
    run(*words, "--dry-run", "--verify", status=2)
    for wrong in ("t.xyz", "no/t.tsv"):  # what the study could not write
        refused = run(*words, "-o", wrong, "--dry-run", status=2 if "/" not in wrong else 1)
        assert names_all(refused, wrong.split("/")[0]), refused


def test_networks():
    few, every = plan("modes", N200, "--lowest", 10), plan("modes", N200)
    assert few["modes"]["count"] == 10 and few["total"]["cpu_s"] < every["total"]["cpu_s"]
    assert plan("modes", N200, "--vectors", "V.h5")["vectors"]["disk_MB"] > 1
    assert math.isnan(plan("modes", N200, "--damping", 0.1)["modes"]["cpu_s"])
    short, long = plan("signal", N200), plan("signal", N200, "--until", 100000, "-o", "t.tsv")
    assert "signals by chebyshev" in short and long["total"]["cpu_s"] > 2 * short["total"]["cpu_s"]
    assert long["total"]["disk_MB"] > 0 and short["total"]["disk_MB"] == 0
    assert plan("signal", N200, "--planes", 7)["signals by chebyshev"]["count"] == 7
    assert math.isnan(plan("signal", N200, "--method", "verlet")["signals by verlet"]["cpu_s"])
    for kind in "dos transmission dispersion harmonic participation continuum".split():
        assert plan("spectrum", kind, N200)[kind]["cpu_s"] > 0
    ten, hundred = (plan("spectrum", "harmonic", N200, "--at", f"0.1:0.5:{n}")["harmonic"]["cpu_s"] for n in (10, 100))
    assert 5 < hundred / ten < 20
    run("signal", "absent.h5", "--dry-run", status=1)
    run("statics", N200, "--dry-run", status=2)


def test_speed():
    """No work: the processor time of a plan does not depend on what is planned."""
    before = os.times().children_user
    run("pack", *sets("packing.grains=10000000", "packing.width=1e4"), "--dry-run", "-o", "H.h5")
    assert os.times().children_user - before < 5


with tempfile.TemporaryDirectory(prefix="sonopack-dry-run-") as name:
    os.chdir(name)
    for test in (test_memory, test_pack, test_study, test_networks, test_speed):
        test()
        print(test.__name__, "ok")
    text = run("pack", "--help")
    assert re.search(r"^ +--dry-run", text, re.M)
    os.chdir(SOURCE)
