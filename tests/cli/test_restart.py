"""sonopack pack killed at any moment goes on from its state to the same file; states of others; histories; packings that
start from files.

usage: test_restart.py COMMAND SOURCE_DIR
"""
import os
import pathlib
import random
import signal
import subprocess
import sys
import tempfile
import time

import h5py

COMMAND = sys.argv[1]
HISTORY = ["--set", "packing.grains=300", "--set", "packing.width=15", "--set", "packing.tolerance=1e-9",
           "--set", "packing.history=[1e-5, 3e-4]"]


def run(*args, status=0):
    done = subprocess.run([COMMAND, *map(str, args)], capture_output=True, text=True)
    assert done.returncode == status, (args, done.returncode, done.stdout, done.stderr)
    return done


def seconds_of(*args):
    begun = time.monotonic()
    run(*args)
    return time.monotonic() - begun


def state_of(path):
    return path.with_name(path.name + ".state")


def stages_of(path):
    return [path.with_name(f"{path.stem}.stage{k}{path.suffix}") for k in (1, 2)]


def killed_and_resumed(folder, seed=3, kills=6):
    """kill -9 again and again, at random moments; the file at the end is that of a making that nobody disturbed."""
    whole, part = folder / "whole.h5", folder / "part.h5"
    length = seconds_of("pack", *HISTORY, "-o", whole)
    assert not state_of(whole).exists()
    dice, resumed = random.Random(seed), 0
    print(f"seed {seed}: {length:.2f} s for the whole")
    for _ in range(kills):
        making = subprocess.Popen([COMMAND, "pack", *HISTORY, "-o", str(part), "--state-every", "0"],
                                  stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        time.sleep(dice.uniform(0.1, 0.4) * length)
        making.send_signal(signal.SIGKILL)
        resumed += "goes on from step" in making.communicate()[1]
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
    args = ["pack", "--set", "packing.grains=6000", "-o", path]  # far longer than what follows
    for seconds in (1, 2, 4, 8, 16):  # on a busy machine the first state that can be kept comes late
        making = subprocess.Popen([COMMAND, *map(str, args)], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                                  text=True)
        time.sleep(seconds)
        making.send_signal(signal.SIGINT)
        said = making.communicate()[1]
        if "nothing is written" not in said:
            break
    assert making.returncode == 1 and "the same command goes on" in said and str(state_of(path)) in said, said
    assert state_of(path).exists() and not path.exists()
    # a state of another scene is told of, and makes place
    other = run("pack", "--set", "packing.grains=60", "--set", "packing.width=6", "--set", "packing.tolerance=1e-6",
                "-o", path)
    assert "is not used: the state" in other.stderr, other.stderr
    assert path.exists() and not state_of(path).exists()


def damaged_states(folder):
    path = folder / "damaged.h5"
    small = ["pack", "--set", "packing.grains=60", "--set", "packing.width=6", "--set", "packing.tolerance=1e-6"]
    state_of(path).write_text("my notes")
    assert "is something else" in run(*small, "-o", path, status=2).stderr
    assert state_of(path).read_text() == "my notes"
    state_of(path).write_bytes(b"SNPKSTAT" + os.urandom(3000))
    assert "is not used" in run(*small, "-o", path).stderr


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
    assert "packing.file" in run("pack", "--set", "packing.kind=file", "-o", folder / "x.h5", status=2).stderr
    missing = run("pack", scene, "--set", "packing.file=none.h5", "-o", folder / "x.h5", status=1).stderr
    assert "packing.file" in missing and "none.h5" in missing, missing
    # stages are in the way
    assert "exists already" in run("pack", *HISTORY, "-o", first, status=2).stderr
    os.remove(first)
    assert "stage1.h5: exists already" in run("pack", *HISTORY, "-o", first, status=2).stderr


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
    assert "0 of them made now" in again.stderr, again.stderr


with tempfile.TemporaryDirectory(prefix="sonopack-restart-") as name:
    where = pathlib.Path(name)
    killed_and_resumed(where)
    stopped_politely(where)
    damaged_states(where)
    from_a_file(where)
    a_study_from_a_file(where)
print("ok")
