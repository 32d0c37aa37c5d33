"""pack killed at any moment goes on from its state to the same file; states of others; histories; packings that start from
files.

usage: test_restart.py COMMAND SOURCE_DIR
"""
import os
import pathlib
import random
import signal

import h5py

from command import main, pack, refused, run, sets, start
from common import PATIENCE, made_now, names_all, wait_for_work, wait_until

HISTORY = ["pack", *sets(grains=300, width=15, tolerance=1e-9, history="[1e-5, 3e-4]"), "-o"]
SMALL = ["pack", *sets(grains=60, width=6, tolerance=1e-6), "-o"]
WHOLE, PART = pathlib.Path("whole.h5"), pathlib.Path("part.h5")


def state_of(path):
    return pathlib.Path(f"{path}.state")


def stages_of(path):
    return [path.with_name(f"{path.stem}.stage{k}{path.suffix}") for k in (1, 2)]


def wait_for_states(making, path, count):
    """Until a making has written its state so often, or has ended."""
    def stamp():
        return state_of(path).stat().st_mtime_ns if state_of(path).exists() else 0

    for _ in range(count):
        before = stamp()
        wait_until(lambda: making.poll() is not None or stamp() not in (0, before), "a state", every=0.001)


def killed_and_resumed(seed=3, kills=6):
    """kill -9 again and again, when some more states were written; the file at the end is that of a making that nobody
    disturbed."""
    run(*HISTORY, WHOLE)
    assert not state_of(WHOLE).exists()
    dice, resumed = random.Random(seed), 0
    print(f"seed {seed}")
    for _ in range(kills):
        making = start(*HISTORY, PART, "--state-every", "0")
        wait_for_states(making, PART, dice.randrange(1, 4))
        making.send_signal(signal.SIGKILL)
        resumed += names_all(making.communicate()[1] or "-", state_of(PART))
        if PART.exists():
            break
    print(f"{resumed} went on")
    assert resumed >= 1
    if not PART.exists():
        run(*HISTORY, PART)
    assert not state_of(PART).exists()
    for one, other in zip([PART, *stages_of(PART)], [WHOLE, *stages_of(WHOLE)]):
        assert one.read_bytes() == other.read_bytes()


def stopped_politely():
    """Ctrl-C: the last state is written whatever the interval, and the way on is told."""
    path = pathlib.Path("stopped.h5")
    making = start("pack", *sets(grains=1500, pressure=1e-8), "--state-every", "1e6", "-o", path)
    wait_for_work(making, 0)  # the signal comes before the first state could be kept: the making goes on to it
    making.send_signal(signal.SIGINT)
    said = making.communicate(timeout=PATIENCE)[1]
    assert making.returncode == 1 and names_all(said, state_of(path)) and state_of(path).exists() and not path.exists(), said
    # a state of another scene is told of, and makes place; so is one that is damaged; what is none stays
    assert names_all(run(*SMALL, path).stderr, state_of(path)) and path.exists() and not state_of(path).exists()
    other = pathlib.Path("damaged.h5")
    state_of(other).write_text("my notes")
    refused(state_of(other), *SMALL, other)
    assert state_of(other).read_text() == "my notes"
    state_of(other).write_bytes(b"SNPKSTAT" + os.urandom(3000))
    assert names_all(run(*SMALL, other).stderr, state_of(other))


def from_a_file():
    scene = pathlib.Path("scenes/low.cfg")
    scene.parent.mkdir()
    WHOLE.rename(scene.parent / "whole.h5")
    scene.write_text('packing = { kind = "file"; file = "whole.h5"; pressure = 1e-5; };\n')
    run("pack", scene, "-o", "low.h5")  # the name is relative to the scene
    pack("back.h5", kind="file", file="low.h5")
    run("check", "low.h5", "back.h5", *stages_of(PART))
    with h5py.File("low.h5") as low, h5py.File(PART) as first:
        assert low["particles/grains/radius"].shape == first["particles/grains/radius"].shape == (300,)
    for names, keys, status in (("packing.grains 301 300", {"grains": 301}, 2), ("packing.content 5", {"content": 5}, 2),
                                ("packing.file none.h5", {"file": "none.h5"}, 1)):
        refused(names, "pack", scene, *sets(**keys), "-o", "x.h5", status=status)
    # stages are in the way
    refused(PART, *HISTORY, PART)
    PART.unlink()
    refused("stage1.h5", *HISTORY, PART, *sets(seed=99))  # the same scene would only write the same again


def a_study_from_a_file():
    scene = pathlib.Path("study.cfg")
    scene.write_text('packing = { kind = "file"; file = "low.h5"; };\n study = { want = ["statics"]; samples = 1;\n'
                     'sweep = ( { key = "packing.pressure"; values = [2e-5, 1e-4]; } ); };\n')
    text = run("study", scene, "--store", "store", "--jobs", 2).stdout
    assert len([line for line in text.splitlines() if line[:1].isdigit()]) == 2, text
    pathlib.Path("low.h5").rename("scenes/low.h5")
    again = run("study", scene.rename("scenes/study.cfg"), "--store", "store")
    assert made_now(again.stderr) == 0, again.stderr


main(killed_and_resumed, stopped_politely, from_a_file, a_study_from_a_file)
