"""study --verify and --retry: what is damaged is put aside and made anew, what failed is tried again. False numbers are in
test_forged_samples.py.

usage: test_verify.py COMMAND SOURCE_DIR
"""
import os
import pathlib
import shutil

import h5py

from command import COMMAND, main, run, sets, table, tables, tried
from common import made_now, names_all
from store_faults import OF_THE_STORE

SCENE = """
packing = { width = 8; grains = 40; seed = 3; };
study = { samples = 6; want = ["ctof", "moduli", "statics"]; };
"""
STORE = pathlib.Path("store")
TEXT = []  # what the study of SCENE printed


def verified(*words, status=0):
    """The process, and its rows {file: (ok, reason)}."""
    done = run("study", *words, "--verify", status=status)
    (found,) = tables(done.stdout)
    assert found.names == ["file", "ok", "reason", "field"], found.names
    return done, {row[0]: tuple(row[1:3]) for row in found.rows}


def content(folder):
    return {path.name: path.read_bytes() for path in pathlib.Path(folder).iterdir()
            if path.suffix != ".bad" and path.name not in OF_THE_STORE}


def a_good_store():
    pathlib.Path("scene.cfg").write_text(SCENE)
    TEXT.append(run("study", "scene.cfg", "--store", STORE).stdout)
    before = content(STORE)
    for words in ((), ("scene.cfg",)):
        done, rows = verified(*words, "--store", STORE)
        assert rows == dict.fromkeys(before, ("yes", "-")) and names_all(done.stderr, "6")
    assert content(STORE) == before
    # other samples do not belong to the scene, and those that are not there are no fault
    shutil.copytree(STORE, "more")
    run("study", "--store", "more", *sets("study.samples=1", kind="chain"))
    assert len(verified("scene.cfg", "--store", "more", "--set", "study.samples=9")[1]) == 6
    assert len(verified("--store", "more")[1]) == 7
    run("study", "--store", STORE, "--verify", "-o", "found.csv")
    assert len([line for line in pathlib.Path("found.csv").read_text().splitlines() if line[0] != "#"]) == 7
    pathlib.Path("empty").mkdir()
    assert verified("--store", "empty")[1] == {}


def other_kinds():
    """Every kind of sample is known by its stored scene again."""
    words = ["study", "--store", "kinds", *sets("study.samples=1", 'study.want=["statics"]')]
    small = {"grains": 40, "width": 8}
    run(*words, *sets(**small, diameters=[0.9, 1.1] * 20, sizes="list"))
    run(*words, *sets('study.sweep=({ key = "packing.height"; values = [8.0, 9.5]; })', 'study.want=["signal","planes"]',
                      "signal.planes=[2.0, 4.0, 6.0]", width=8))
    run(*words, *sets(**small, kind="triangular"))
    start = sorted(pathlib.Path("kinds").glob("*.h5"))[0].resolve()
    run(*words, *sets(kind="file", file=start))
    assert len(verified("--store", "kinds")[1]) == 5


def damaged():
    """Kinds of damage, each told by its reason; then all is made anew, bit for bit."""
    whole, place = content(STORE), pathlib.Path("damaged")
    shutil.copytree(STORE, place)
    name = sorted(whole)
    for k, data in enumerate((whole[name[0]][:-1000], whole[name[2]], whole[name[1]], b"", b"sample = 1\n")):
        (place / name[k]).write_bytes(data)
    (place / "notes.txt").write_text("left alone")
    done, rows = verified("scene.cfg", "--store", place, status=1)
    assert [rows[n][0] for n in name] == ["no"] * 5 + ["yes"] and all(rows[n][1] != "-" for n in name[:5]), rows
    assert done.stderr.count(".bad") == 5 and names_all(done.stderr, "5")
    assert sorted(path.name for path in place.iterdir() if path.name not in OF_THE_STORE) == sorted(
        [n.replace(".h5", ".bad") for n in name[:5]] + [name[5], "notes.txt"])
    assert verified("--store", place)[1] == {name[5]: ("yes", "-")}
    again = run("study", "scene.cfg", "--store", place)
    assert again.stdout == TEXT[0] and made_now(again.stderr) == 5
    (place / "notes.txt").unlink()
    assert content(place) == whole


def flipped_bytes():
    """A byte anywhere: found, or one of those that carry nothing, and then all that the file says is as before."""
    name, place = sorted(content(STORE))[0], pathlib.Path("flipped")
    whole, said = (STORE / name).read_bytes(), table("check", STORE / name).rows[0][1:]
    place.mkdir()
    passed, places = 0, range(5, len(whole), len(whole) // 60)
    for k in places:
        (place / name).write_bytes(whole[:k] + bytes([whole[k] ^ 0x10]) + whole[k + 1:])
        done = tried("study", "--store", place, "--verify")
        bad = (place / name).with_suffix(".bad")
        if done.returncode == 0:
            assert table("check", place / name).rows[0][1:] == said, k
            passed += 1
        else:
            assert done.returncode == 1 and bad.exists() != (place / name).exists(), (k, done)
            bad.unlink(missing_ok=True)
    assert passed < 0.2 * len(places), (passed, len(places))  # gaps in the file


def tolerance():
    """The audit is that of `check', with its tolerance; what reads well and is not right stays where it is."""
    run("study", "--store", "loose", "scene.cfg", *sets("packing.tolerance=1e-6", "study.samples=1"))
    before = content("loose")
    verified("--store", "loose", status=1)
    verified("--store", "loose", "--tolerance", "0.1")
    assert content("loose") == before


def read_only():
    """Damaged files of a store that may not be written are told, and stay. Root may write everywhere: the command runs
    as nobody then."""
    place = pathlib.Path("read-only")
    shutil.copytree(STORE, place)
    victim = sorted(place.glob("*.h5"))[0]
    victim.write_bytes(victim.read_bytes()[:500])
    place.chmod(0o555)
    pathlib.Path().resolve().chmod(0o755)
    shutil.copy(COMMAND, "sonopack")
    user = {"user": 65534, "group": 65534} if os.geteuid() == 0 else {}
    done = tried("study", "--store", place, "--verify", executable="./sonopack", **user)
    assert done.returncode == 1 and done.stderr and f"{victim.name}\tno" in done.stdout, done
    assert victim.exists() and not victim.with_suffix(".bad").exists()
    place.chmod(0o755)


def failures():
    """A recorded failure is sound, stays a failure, and is tried again only when asked."""
    words = ["failures.cfg", "--store", "failures"]
    pathlib.Path("failures.cfg").write_text(SCENE.replace("samples = 6", "samples = 2").replace("seed = 3;", "seed = 3; max_steps = 50;"))
    run("study", *words)
    records = content("failures")
    assert len(records) == 2 and all(name.endswith(".failed") for name in records)
    done, rows = verified(*words)
    assert names_all(done.stderr, "2") and all(ok == "yes" and names_all(why, "packing.max_steps 50") for ok, why in rows.values())
    assert made_now(run("study", *words).stderr) == 0
    again = run("study", *words, "--retry")  # fails again, and so it says
    assert made_now(again.stderr) == 2 and names_all(again.stderr, "2") and content("failures") == records
    # as after a lack of something that is there now: the samples of the good scene under records of failures
    good, words = pathlib.Path("good"), ["good.cfg", "--store", "good"]
    pathlib.Path("good.cfg").write_text(SCENE.replace("samples = 6", "samples = 2"))
    text = run("study", *words).stdout
    whole = content(good)
    for name in whole:
        with h5py.File(good / name) as file:
            seed = file["/results/sample/seed"][()]
        (good / name).unlink()
        (good / name).with_suffix(".failed").write_bytes(next(data for data in records.values() if f"seed = {seed}\n".encode() in data))
    assert tables(run("study", *words).stdout)[0].notes["failed"] == "2" and not list(good.glob("*.h5"))
    again = run("study", *words, "--retry")
    assert again.stdout == text and content(good) == whole
    assert made_now(run("study", *words, "--retry").stderr) == 0
    # a record that nobody can read is damaged
    broken = good / min(whole).replace(".h5", ".failed")
    broken.with_suffix(".h5").unlink()
    broken.write_bytes(b"grains = many\n")
    assert verified(*words, status=1)[1][broken.name][0] == "no" and broken.with_suffix(".bad").exists() and not broken.exists()
    assert run("study", *words).stdout == text


main(a_good_store, other_kinds, damaged, flipped_bytes, tolerance, read_only, failures)
