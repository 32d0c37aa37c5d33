"""sonopack pack killed at any moment goes on from its state to the same file; states of others; histories; packings that
start from files.

usage: test_restart.py COMMAND SOURCE_DIR
"""
import os
import pathlib
import random
import signal
import subprocess
import tempfile

import h5py

from common import made_now, names_all, wait_for_work, wait_until
from streams import COMMAND, run

HISTORY = ["--set", "packing.grains=300", "--set", "packing.width=15", "--set", "packing.tolerance=1e-9",
           "--set", "packing.history=[1e-5, 3e-4]"]


def state_of(path):
    return path.with_name(path.name + ".state")


def stages_of(path):
    return [path.with_name(f"{path.stem}.stage{k}{path.suffix}") for k in (1, 2)]


def wait_for_states(making, path, count):
    """Until a making has written its state so often, or has ended."""
    def stamp():
        return state_of(path).stat().st_mtime_ns if state_of(path).exists() else 0

    for _ in range(count):
        before = stamp()
        wait_until(lambda: making.poll() is not None or stamp() not in (0, before), "a state", every=0.001)


def killed_and_resumed(folder, seed=3, kills=6):
    """kill -9 again and again, when some more states were written; the file at the end is that of a making that nobody
    disturbed."""
    whole, part = folder / "whole.h5", folder / "part.h5"
    run("pack", *HISTORY, "-o", whole)
    assert not state_of(whole).exists()
    dice, resumed = random.Random(seed), 0
    print(f"seed {seed}")
    for _ in range(kills):
        making = subprocess.Popen([COMMAND, "pack", *HISTORY, "-o", str(part), "--state-every", "0"],
                                  stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        wait_for_states(making, part, dice.randrange(1, 4))
        making.send_signal(signal.SIGKILL)
        resumed += names_all(making.communicate()[1] or "-", state_of(part))
        if part.exists():
            break
    print(f"{resumed} went on")
    assert resumed >= 1
    if not part.exists():
        run("pack", *HISTORY, "-o", part)
    assert not state_of(part).exists()
    assert part.read_bytes() == whole.read_bytes()
    for one, other in zip(stages_of(part), stages_of(whole)):
        assert one.read_bytes() == other.read_bytes()


def stopped_politely(folder):
    """Ctrl-C: the last state is written whatever the interval, and the way on is told."""
    path = folder / "stopped.h5"
    args = ["pack", "--set", "packing.grains=1500", "--set", "packing.pressure=1e-8", "--state-every", "1e6", "-o",
            path]
    making = subprocess.Popen([COMMAND, *map(str, args)], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    wait_for_work(making, 0)  # the signal comes before the first state could be kept: the making goes on to it
    making.send_signal(signal.SIGINT)
    said = making.communicate()[1]
    assert making.returncode == 1 and names_all(said, state_of(path)), said
    assert state_of(path).exists() and not path.exists()
    # a state of another scene is told of, and makes place
    other = run("pack", "--set", "packing.grains=60", "--set", "packing.width=6", "--set", "packing.tolerance=1e-6",
                "-o", path)
    assert names_all(other.stderr, state_of(path)), other.stderr
    assert path.exists() and not state_of(path).exists()


def damaged_states(folder):
    path = folder / "damaged.h5"
    small = ["pack", "--set", "packing.grains=60", "--set", "packing.width=6", "--set", "packing.tolerance=1e-6"]
    state_of(path).write_text("my notes")
    assert names_all(run(*small, "-o", path, status=2).stderr, state_of(path))
    assert state_of(path).read_text() == "my notes"
    state_of(path).write_bytes(b"SNPKSTAT" + os.urandom(3000))
    assert names_all(run(*small, "-o", path).stderr, state_of(path))


def from_a_file(folder):
    first, low, back = folder / "whole.h5", folder / "low.h5", folder / "back.h5"
    scene = folder / "low.cfg"
    scene.write_text('packing = { kind = "file"; file = "whole.h5"; pressure = 1e-5; };\n')
    run("pack", scene, "-o", low)  # the name is relative to the scene
    run("pack", "--set", "packing.kind=file", "--set", f"packing.file={low}", "-o", back)
    run("check", first, low, back, *stages_of(first))
    with h5py.File(low) as f, h5py.File(first) as g:
        assert len(f["particles/grains/position/value"][-1]) == len(g["particles/grains/position/value"][-1]) == 300
    refused = run("pack", scene, "--set", "packing.grains=301", "-o", folder / "x.h5", status=2).stderr
    assert "packing.grains = 301: must be that of packing.file, 300" in refused, refused
    refused = run("pack", scene, "--set", "packing.content=5", "-o", folder / "x.h5", status=2).stderr
    assert "packing.content = 5" in refused, refused
    assert names_all(run("pack", "--set", "packing.kind=file", "-o", folder / "x.h5", status=2).stderr, "packing.file")
    missing = run("pack", scene, "--set", "packing.file=none.h5", "-o", folder / "x.h5", status=1).stderr
    assert "packing.file" in missing and "none.h5" in missing, missing
    # stages are in the way
    assert names_all(run("pack", *HISTORY, "-o", first, status=2).stderr, first)
    os.remove(first)
    assert names_all(run("pack", *HISTORY, "-o", first, status=2).stderr, "stage1.h5")


def a_study_from_a_file(folder):
    scene, store = folder / "study.cfg", folder / "store"
    scene.write_text('packing = { kind = "file"; file = "low.h5"; };\n study = { want = ["statics"]; samples = 1;\n'
                     'sweep = ( { key = "packing.pressure"; values = [2e-5, 1e-4]; } ); };\n')
    table = run("study", scene, "--store", store, "--jobs", 2).stdout
    assert len([line for line in table.splitlines() if line[:1].isdigit()]) == 2, table
    moved = folder / "moved"
    moved.mkdir()
    (folder / "low.h5").rename(moved / "low.h5")
    scene.rename(moved / "study.cfg")
    again = run("study", moved / "study.cfg", "--store", store)
    assert made_now(again.stderr) == 0, again.stderr


with tempfile.TemporaryDirectory(prefix="sonopack-restart-") as name:
    where = pathlib.Path(name)
    killed_and_resumed(where)
    stopped_politely(where)
    damaged_states(where)
    from_a_file(where)
    a_study_from_a_file(where)
print("ok")
