"""--dry-run: a table of what would be made, for every command that has it; nothing is written, nothing is computed.

usage: test_dry_run.py COMMAND SOURCE_DIR
"""
import math
import os
import pathlib
import subprocess
import sys

from command import COMMAND, N200, main, refused, run, sanitized, sets, table

# The peak of a process counts what it was before exec: a small parent starts the command.
PARENT = """import os, sys
child = os.posix_spawn(sys.argv[1], sys.argv[1:], os.environ,
                       file_actions=[(os.POSIX_SPAWN_OPEN, 1, os.devnull, os.O_WRONLY, 0)])
_, status, usage = os.wait4(child, 0)
print(os.waitstatus_to_exitcode(status), usage.ru_maxrss)
"""


def snapshot():
    """Every name below the current folder, with size and times of change."""
    return {str(path): (path.stat().st_size, path.stat().st_mtime_ns) for path in pathlib.Path().rglob("*")}


def plan(*words):
    """The rows of a dry run by their names; times of one kernel are those of the laws' machine, so that plans compare
    whatever else runs here. Nothing in the current folder changes."""
    before = snapshot()
    found = table(*words, "--dry-run")
    assert snapshot() == before, f"{words}: something was written"
    assert found.names == "what count cpu_s wall_s memory_MB disk_MB".split() and found.words("what")[-1] == "total"
    for name, slack in (("cpu_s", 0), ("disk_MB", 1e-6)):
        *work, total = found[name]
        assert math.isnan(total) or abs(sum(work) - total) <= 0.02 * total + slack, (name, found.rows)
    machine = [found.note(key) for key in found.notes if key.startswith("machine_")]
    rows = {row[0]: dict(zip(found.names[1:], map(float, row[1:]))) for row in found.rows}
    for row in rows.values() if len(machine) == 1 else ():
        row["cpu_s"] /= machine[0]
    return rows


def peak(*words):
    """Resident memory of `pack' [MB]."""
    done = subprocess.run([sys.executable, "-I", "-S", "-c", PARENT, COMMAND, "pack", "-q", "--threads", "1", *words],
                          text=True, capture_output=True, check=True)
    status, size = map(int, done.stdout.split())
    assert status == 0, done
    return 1.024e-3 * size


def memory():
    """That of making spheres against what is foretold, beyond that of a command that makes next to nothing."""
    if sanitized():
        return
    many = [*sets(dimension=3, grains=3000, width=16, pressure=1e-2, protocol="quick", tolerance=1e-5), "-o", "M.h5"]
    few = [*sets(kind="chain", grains=10), "-o", "M1.h5"]
    foretold = plan("pack", *many)["total"]["memory_MB"] - plan("pack", *few)["total"]["memory_MB"]
    measured = max(peak(*many, "--force") for _ in range(3)) - peak(*few)  # pages come and go by where threads end
    assert measured / 1.5 < foretold < 1.5 * measured, (foretold, measured)


def packings():
    keys = sets(grains=100, width=10, protocol="quick")
    total = plan("pack", *keys, "-o", "P.h5")["total"]
    run("pack", *keys, "-q", "-o", "P.h5")
    assert abs(total["disk_MB"] / (1e-6 * os.path.getsize("P.h5")) - 1) < 0.1, total
    large = plan("pack", *sets(grains=100000, width=316), "-o", "L.h5")["total"]
    assert large["cpu_s"] > 1e4 * total["cpu_s"] and large["memory_MB"] > 2 * total["memory_MB"]
    history = plan("pack", *keys, *sets(history="[1e-3, 1e-5]"), "-o", "H.h5")
    assert history["packings of the history"]["count"] == 2 and history["total"]["cpu_s"] > 1.2 * total["cpu_s"]
    # what the work would refuse, the plan refuses
    for names, words, status in (("P.h5", ["-o", "P.h5"], 2), ("packing.width", ["--set=packing.width=1", "-o", "Q.h5"], 2),
                                 ("nowhere", ["-o", "nowhere/Q.h5"], 1), ("", [], 2)):
        refused(names, "pack", *keys, "--dry-run", *words, status=status)


def studies():
    keys = sets('study.want=["ctof", "moduli"]', grains=60, width=8, protocol="quick")
    words = ["study", *keys, "--store", "store", "--set"]
    rows = plan(*words, "study.samples=3")
    assert not os.path.exists("store")
    assert [rows[name]["count"] for name in ("samples", "packings", "moduli", "samples in the store")] == [3, 3, 3, 0]
    run(*words, "study.samples=3", "-q")
    size = sum(1e-6 * path.stat().st_size for path in pathlib.Path("store").glob("*.h5"))
    assert abs(rows["total"]["disk_MB"] / size - 1) < 0.25, (rows, size)
    rows = plan(*words, "study.samples=3")
    assert rows["samples in the store"]["count"] == 3 and "packings" not in rows
    rows = plan(*words, "study.samples=5")
    assert rows["samples in the store"]["count"] == 3 and rows["packings"]["count"] == 2
    # their packings are there: only the new part is to be made
    rows = plan(*words, "study.samples=3", *sets('study.want=["ctof", "moduli", "statics", "probes"]'))
    assert "packings" not in rows or rows["packings"]["count"] == 0, rows
    assert rows["probes"]["count"] == 3
    assert plan("study", *keys, *sets("study.samples=8"), "--store", "other", "--shard", "1/4")["packings"]["count"] == 2
    assert plan(*words, "study.samples=1000000")["samples"]["count"] == 1000000
    refused("", *words, "study.samples=3", "--dry-run", "--verify")
    for wrong, status in (("t.xyz", 2), ("no/t.tsv", 1)):  # what the study could not write
        refused(wrong.split("/")[0], *words, "study.samples=3", "-o", wrong, "--dry-run", status=status)


def networks():
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
    refused("absent.h5", "signal", "absent.h5", "--dry-run", status=1)
    refused("--dry-run", "statics", N200, "--dry-run")


def speed():
    """No work: the processor time of a plan does not depend on what is planned."""
    before = os.times().children_user
    run("pack", *sets(grains=10000000, width=1e4), "--dry-run", "-o", "H.h5")
    assert os.times().children_user - before < 5


if __name__ == "__main__":
    main(memory, packings, studies, networks, speed)
