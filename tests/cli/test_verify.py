"""sonopack study --verify and --retry: what is damaged is put aside and made anew, what failed is tried again.

usage: test_verify.py COMMAND SOURCE_DIR
"""
import os
import pathlib
import shutil
import subprocess
import tempfile

import h5py

from common import made_now, names_all
from store_faults import OF_THE_STORE, samples
from streams import COMMAND, comment, run, tables

SCENE = """
packing = { width = 8; grains = 40; seed = 3; };
study = { samples = 6; want = ["ctof", "moduli", "statics"]; };
"""


def found(done):
    """The rows {file: (ok, reason)}."""
    ((_, names, rows),) = tables(done.stdout)
    assert names == ["file", "ok", "reason", "field"], names
    return {row[0]: tuple(row[1:3]) for row in rows}


def content(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()
            if path.suffix != ".bad" and path.name not in OF_THE_STORE}


def a_good_store(folder):
    scene, store = folder / "scene.cfg", folder / "store"
    scene.write_text(SCENE)
    text = run("study", scene, "--store", store).stdout
    before = content(store)
    for args in ((), (scene,)):
        done = run("study", *args, "--store", store, "--verify")
        assert found(done) == {name: ("yes", "-") for name in before} and names_all(done.stderr, "6")
    assert content(store) == before
    # other samples do not belong to the scene, and those that are not there are no fault
    run("study", "--store", store, "--set", 'packing.kind="chain"', "--set", "study.samples=1")
    assert len(found(run("study", scene, "--store", store, "--verify", "--set", "study.samples=9"))) == 6
    assert len(found(run("study", "--store", store, "--verify"))) == 7
    out = folder / "found.csv"
    run("study", "--store", store, "--verify", "-o", out)
    assert len([line for line in out.read_text().splitlines() if not line.startswith("#")]) == 8
    for path in set(samples(store)) - {store / name for name in before}:
        path.unlink()
    return scene, store, text


def other_kinds(folder):
    """Every kind of sample is known by its stored scene again."""
    store, narrow = folder / "kinds", ["--set", "packing.width=8", "--set", "study.samples=1"]
    small = ["--set", "packing.grains=40", *narrow]
    run("study", "--store", store, *small, "--set", f"packing.diameters={[0.9, 1.1] * 20}", "--set",
        'packing.sizes="list"', "--set", 'study.want=["statics"]')
    run("study", "--store", store, *narrow, "--set", 'study.sweep=({ key = "packing.height"; values = [8.0, 9.5]; })',
        "--set", 'study.want=["signal","planes"]', "--set", "signal.planes=[2.0, 4.0, 6.0]")
    run("study", "--store", store, "--set", 'packing.kind="triangular"', *small, "--set", 'study.want=["statics"]')
    start = sorted(store.glob("*.h5"))[0]
    run("study", "--store", store, "--set", 'packing.kind="file"', "--set", f'packing.file="{start}"', "--set",
        "study.samples=1", "--set", 'study.want=["statics"]')
    assert len(found(run("study", "--store", store, "--verify"))) == 5


def damaged(folder, scene, store, text):
    """Six kinds of damage, each told apart from the others by its reason; then all is made anew, bit for bit."""
    whole = content(store)
    place = folder / "damaged"
    shutil.copytree(store, place)
    name = sorted(whole)
    (place / name[0]).write_bytes(whole[name[0]][:-1000])
    (place / name[1]).write_bytes(whole[name[2]])
    (place / name[2]).write_bytes(whole[name[1]])
    (place / name[3]).write_bytes(b"")
    (place / name[4]).write_text("sample = 1\n")
    (place / "notes.txt").write_text("left alone")
    done = run("study", scene, "--store", place, "--verify", status=1)
    rows = found(done)
    assert [rows[n][0] for n in name] == ["no"] * 5 + ["yes"], rows
    assert all(rows[n][1] != "-" for n in name[1:3]), rows
    assert all("HDF5" in rows[name[k]][1] for k in (0, 3, 4)), rows
    assert done.stderr.count(".bad") == 5 and names_all(done.stderr, "5")
    assert sorted(path.name for path in place.iterdir() if path.name not in OF_THE_STORE) == sorted(
        [n.replace(".h5", ".bad") for n in name[:5]] + [name[5], "notes.txt"])
    assert found(run("study", "--store", place, "--verify")) == {name[5]: ("yes", "-")}
    again = run("study", scene, "--store", place)
    assert again.stdout == text and made_now(again.stderr) == 5
    (place / "notes.txt").unlink()
    assert content(place) == whole


def flipped_bytes(folder, scene, store, text):
    """A byte anywhere: found, or one of those that carry nothing, and then all that the file says is as before."""
    name = sorted(content(store))[0]
    whole = (store / name).read_bytes()
    place = folder / "flipped"
    place.mkdir()
    ensemble = run("check", store / name).stdout.replace(str(store), "")
    passed = 0
    places = range(5, len(whole), len(whole) // 60)
    for k in places:
        (place / name).write_bytes(whole[:k] + bytes([whole[k] ^ 0x10]) + whole[k + 1:])
        done = subprocess.run([COMMAND, "study", "--store", place, "--verify"], capture_output=True, text=True)
        if done.returncode == 0:
            assert run("check", place / name).stdout.replace(str(place), "") == ensemble, k
            passed += 1
        else:
            assert done.returncode == 1 and (place / name).with_suffix(".bad").exists() == (
                not (place / name).exists()), (k, done)
            (place / name).with_suffix(".bad").unlink(missing_ok=True)
    assert passed < 0.2 * len(places), (passed, len(places))  # gaps in the file


def rewrite(path, dataset, change):
    """Another value, with checksums that fit it."""
    with h5py.File(path, "r+") as file:
        data = file[dataset][()]
        file[dataset][...] = change(data)


def faulty(folder, scene, store, text):
    """What reads well and is not right stays where it is: only its owner can know why."""
    place = folder / "faulty"
    shutil.copytree(store, place)
    name = sorted(content(place))
    rewrite(place / name[0], overlaps(place / name[0]), lambda x: 1.01 * x)
    rewrite(place / name[1], "/results/front/t10", lambda x: float("inf"))
    rewrite(place / name[2], "/results/moduli/c22", lambda x: float("nan"))
    rewrite(place / name[3], "/results/sample/grains", lambda x: x + 1)
    with h5py.File(place / name[4], "r+") as file:
        scene_text = file["/results/sample/scene"][()].decode().rstrip("\0")
        assert "seed = " in scene_text
        del file["/results/sample/scene"]
        changed = scene_text.replace("seed = ", "seed = 9", 1).encode()
        file.create_dataset("/results/sample/scene", data=changed, dtype=h5py.string_dtype("utf-8", len(changed)))
    before = content(place)
    done = run("study", "--store", place, "--verify", status=1)
    rows = found(done)
    reasons = ("", "t10 inf", "c22 nan", "40", "")
    for k, reason in enumerate(reasons):
        assert rows[name[k]][0] == "no" and names_all(rows[name[k]][1], reason), (k, rows[name[k]])
    assert rows[name[5]] == ("yes", "-") and content(place) == before
    # the audit is that of `check', with its tolerance
    rows = found(run("study", "--store", place, "--verify", "--tolerance", "0.5", status=1))
    assert "/results/" in rows[name[0]][1]  # which are not those of these overlaps
    loose = folder / "loose"
    run("study", "--store", loose, scene, "--set", "packing.tolerance=1e-6", "--set", "study.samples=1")
    run("study", "--store", loose, "--verify", status=1)
    run("study", "--store", loose, "--verify", "--tolerance", "0.1")


def overlaps(path):
    with h5py.File(path) as file:
        names = []
        file.visit(names.append)
    return next(n for n in names if n.endswith("overlap"))


def read_only(folder, scene, store, text):
    """Damaged files of a store that may not be written are told, and stay. Root may write everywhere: the command runs
    as nobody then."""
    place = folder / "read-only"
    shutil.copytree(store, place)
    victim = samples(place)[0]
    victim.write_bytes(victim.read_bytes()[:500])
    place.chmod(0o555)
    folder.chmod(0o755)
    program = folder / "sonopack"
    shutil.copy(COMMAND, program)
    user = {"user": 65534, "group": 65534} if os.geteuid() == 0 else {}
    done = subprocess.run([program, "study", "--store", place, "--verify"], capture_output=True, text=True,
                          cwd=folder, **user)
    assert done.returncode == 1 and names_all(done.stderr, ""), done
    assert found(done)[victim.name][0] == "no" and victim.exists() and not victim.with_suffix(".bad").exists()
    place.chmod(0o755)


def failures(folder):
    """A recorded failure is sound, stays a failure, and is tried again only when asked."""
    place, scene = folder / "failures", folder / "failures.cfg"
    scene.write_text(SCENE.replace("samples = 6", "samples = 2").replace("seed = 3;", "seed = 3; max_steps = 50;"))
    run("study", scene, "--store", place)
    records = content(place)
    assert len(records) == 2 and all(name.endswith(".failed") for name in records)
    done = run("study", scene, "--store", place, "--verify")
    assert all(row[0] == "yes" and names_all(row[1], "packing.max_steps 50") for row in found(done).values())
    assert names_all(done.stderr, "2")
    assert made_now(run("study", scene, "--store", place).stderr) == 0
    again = run("study", scene, "--store", place, "--retry")  # fails again, and so it says
    assert made_now(again.stderr) == 2 and names_all(again.stderr, "2") and content(place) == records
    # as after a lack of something that is there now: the samples of the good scene under records of failures
    good = folder / "good"
    scene.write_text(SCENE.replace("samples = 6", "samples = 2"))
    text = run("study", scene, "--store", good).stdout
    whole = content(good)
    for name in whole:
        with h5py.File(good / name) as file:
            seed = file["/results/sample/seed"][()]
        (good / name).unlink()
        (good / name).with_suffix(".failed").write_text(next(
            text.decode() for text in records.values() if f"seed = {seed}\n" in text.decode()))
    (table, *_) = tables(run("study", scene, "--store", good).stdout)
    assert comment(table, "failed") == "2" and all(path.suffix == ".failed" for path in samples(good))
    again = run("study", scene, "--store", good, "--retry")
    assert again.stdout == text and content(good) == whole
    assert made_now(run("study", scene, "--store", good, "--retry").stderr) == 0
    # a record that nobody can read is damaged
    broken = next(iter(whole)).replace(".h5", ".failed")
    (good / broken.replace(".failed", ".h5")).unlink()
    (good / broken).write_bytes(b"grains = many\n")
    assert found(run("study", scene, "--store", good, "--verify", status=1))[broken][0] == "no"
    assert (good / broken).with_suffix(".bad").exists() and not (good / broken).exists()
    assert run("study", scene, "--store", good).stdout == text


def wrong_usage(folder, scene, store):
    for args in (["--verify", "--retry"], ["--verify", "--shard", "1/2"], ["--tolerance", "1e-3"], ["--verify", "--tolerance", "x"], ["--verify", "-o", folder / "x.png"],
                 ["--verify", "--set", "packing.grain=3"]):
        done = run("study", scene, "--store", store, *args, status=2)
        assert done.stderr.startswith("sonopack") and not done.stdout, (args, done.stderr)
    run("study", "--verify", status=2)
    assert names_all(run("study", "--store", folder / "absent", "--verify", status=1).stderr, "absent")
    assert not (folder / "absent").exists()
    (folder / "empty").mkdir()
    assert found(run("study", "--store", folder / "empty", "--verify")) == {}


with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    good = a_good_store(folder)
    print("a_good_store ok")
    for test, arguments in ((other_kinds, ()), (damaged, good), (flipped_bytes, good), (faulty, good), (read_only, good), (failures, ()),
                            (wrong_usage, good[:2])):
        test(folder, *arguments)
        print(test.__name__, "ok")
