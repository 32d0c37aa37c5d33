"""study and table: an ensemble, its tables, resuming, sharing a store, sweeps, failures, stopping by Ctrl-C. What tables
average, and how, is in tests/unit/test_study_*.c.

usage: test_study.py COMMAND SOURCE_DIR
"""
import os
import pathlib
import shutil
import signal

import h5py
import numpy as np

from command import Table, main, refused, run, sets, start, table, tables
from common import PATIENCE, made_now, names_all, wait_until

CTOF = ("p samples c_tof c_tof_err c_peak c_zero c_l c_t "
        "c_tof_low c_tof_high c_peak_err c_zero_err c_l_err c_t_err").split()
ENDS = ("", "_sd", "_err", "_low", "_high")
STATICS = "Phi2 Phi3 Phi3s zs f0 N_over_p Z2 Z3 F2 F2S s1_over_s2 s12_over_s2 mobilised".split()
MODULI = "C11 C12 C22 C33 c_l c_t K G".split()
# small and at rest soon: this tests the command, not the physics of large boxes
SCENE = """
packing = { width = 8; grains = 40; tolerance = 1e-9; seed = 3; };
study = { samples = 3; want = ["ctof", "moduli"]; sweep = (
  { key = "packing.pressure"; values = [1e-4, 1e-3]; },
  { key = "packing.grains"; values = [40, 120]; } ); };
"""
STORE = pathlib.Path("store")
TEXT = []  # what the study of SCENE printed


def files(store):
    return sorted(pathlib.Path(store).glob("*.h5"))


def an_ensemble():
    pathlib.Path("scene.cfg").write_text(SCENE)
    TEXT.append(run("study", "scene.cfg", "--store", STORE, "--jobs", 2).stdout)
    ctof, moduli = tables(TEXT[0])
    assert ctof.names == CTOF and list(ctof["p"]) == [1e-4, 1e-3] and list(ctof["samples"]) == [3, 3]
    assert moduli.names == ["p", "grains", "samples", "left_out"] + [name + end for name in MODULI for end in ENDS]
    assert list(moduli["grains"]) == [40, 120, 40, 120] and ctof.notes["failed"] == "0"
    rows = table("table", "ensemble", "--store", STORE)
    assert len(rows) == 12 == len(set(rows.words("name")))
    p, grains = rows["p"], rows["grains"]
    assert all(np.diff(np.lexsort((rows["seed"], grains, p))) == 1)
    for k, pressure in enumerate((1e-4, 1e-3)):
        low, high = (p == pressure) & (grains == 40), (p == pressure) & (grains == 120)
        rise = rows["height"][high].mean() - rows["height"][low].mean()
        for mark, name in (("t10", "c_tof"), ("t_peak", "c_peak"), ("t_zero", "c_zero")):
            flight = rows[mark][high].mean() - rows[mark][low].mean()
            assert np.isclose(ctof[name][k], rise / flight, rtol=1e-12), name
        assert np.isclose(ctof["c_l"][k], rows["c_l"][high].mean(), rtol=1e-12)
        assert np.isclose(moduli["C33_sd"][2 * k], rows["C33"][low].std(ddof=1), rtol=1e-9)
        assert np.isclose(moduli["C33_err"][2 * k], rows["C33"][low].std(ddof=1) / 3**0.5, rtol=1e-9)
        assert ctof["c_tof_low"][k] < ctof["c_tof"][k] < ctof["c_tof_high"][k] and ctof["c_tof_err"][k] > 0
    # a sample's file: packing and results, made by that seed
    file = STORE / f"{rows.words('name')[0]}.h5"
    run("check", file)
    assert table("front", file)["t10"][0] == rows["t10"][0]
    with h5py.File(file) as stored:
        assert "signal" not in stored  # nobody wanted it
    # levels of intervals: wider and wider, the rest of the table the same
    found = [table("table", "ctof", "--store", STORE, "--interval", level) for level in ("0.5", "0.95", "0.999")]
    assert np.all(np.diff([t["c_tof_high"] - t["c_tof_low"] for t in found], axis=0) > 0)
    assert found[1].body == ctof.body and np.array_equal(found[0]["c_tof_err"], ctof["c_tof_err"])


def resumed():
    before = {path.name: path.stat().st_mtime_ns for path in STORE.iterdir()}
    again = run("study", "scene.cfg", "--store", STORE, "--jobs", 1)
    assert again.stdout == TEXT[0] and made_now(again.stderr) == 0
    assert {path.name: path.stat().st_mtime_ns for path in STORE.iterdir()} == before
    # lost and damaged files, a pipe, a folder, an endless device, another sample's file: made again, bit for bit
    lost, cut, pipe, folder, device, other, *_ = files(STORE)
    cut.write_bytes(cut.read_bytes()[:1000])
    shutil.copy(files(STORE)[-1], other)
    for path in (lost, pipe, folder, device):
        path.unlink()
    os.mkfifo(pipe)
    folder.mkdir()
    device.symlink_to("/dev/zero")
    again = run("study", "scene.cfg", "--store", STORE)
    assert again.stdout == TEXT[0] and made_now(again.stderr) == 6


def shared():
    """Shards in any order, and more than one process at a time, give the same bytes; wishes are added to what is there."""
    parts = [start("study", "scene.cfg", "--store", "shared", "--shard", f"{k}/3", "--jobs", 1) for k in (3, 1, 2)]
    for part in parts:
        assert part.communicate(timeout=PATIENCE) and part.returncode == 0
    assert run("study", "scene.cfg", "--store", "shared").stdout == TEXT[0]
    only = TEXT[0].split("\n\n")[0] + "\n"
    assert run("table", "ctof", "--store", "shared").stdout == only
    more = run("study", "scene.cfg", "--store", "shared", *sets('study.want=["ctof","statics","signal"]'))
    ctof, statics = tables(more.stdout)
    assert statics.names == ["p", "grains", "samples", "left_out"] + [name + end for name in STATICS for end in ENDS]
    assert ctof.body == Table(only).body
    for path in files("shared"):
        with h5py.File(path) as stored:
            assert "signal" in stored
    # more samples: the scene's own table has them, the first scene's table does not
    larger = run("study", "scene.cfg", "--store", "shared", "--set", "study.samples=4", "-q")
    assert list(tables(larger.stdout)[0]["samples"]) == [4, 4] and not larger.stderr
    assert run("table", "ctof", "--store", "shared", "scene.cfg").stdout == only
    assert list(table("table", "ctof", "--store", "shared")["samples"]) == [4, 4]
    # nothing of the scene is there: no empty table; what is not there yet is counted
    refused("12", "table", "ctof", "--store", "shared", "scene.cfg", "--set", "packing.seed=77", status=1)
    early = table("table", "ctof", "--store", "shared", "scene.cfg", "--set", "study.samples=6")
    assert early.notes["missing"].startswith("8 ")


def files_of_tables():
    run("study", "scene.cfg", "--store", STORE, "-o", "tables.tsv")
    out, other = pathlib.Path("tables.tsv"), pathlib.Path("tables-moduli.tsv")
    assert out.read_text() + "\n" + other.read_text() == TEXT[0]
    refused("tables.tsv", "study", "scene.cfg", "--store", STORE, "-o", out)
    out.unlink()
    refused("tables-moduli.tsv", "study", "scene.cfg", "--store", STORE, "-o", out)  # the other table is in the way
    assert not out.exists()


def unlike_samples():
    """A sweep over what has no rows is a table for each value; samples of unlike scenes are averaged by nobody, whatever
    their seeds; a scene chooses its own."""
    keys = sets("study.samples=2", "study.want=statics", width=8, grains=120, tolerance=1e-7)
    both = tables(run("study", "--store", "mu", *keys, *sets(
        'study.sweep=({ key = "packing.friction"; values = [0.0, 0.5]; })')).stdout)
    assert [t.notes["packing.friction"] for t in both] == ["0", "0.5"] and both[0]["zs"][0] > both[1]["zs"][0] + 0.3
    refused("friction", "table", "statics", "--store", "mu", status=1)
    keys = sets("study.samples=2", 'study.want=["statics"]', width=8, grains=60)
    alone = tables(run("study", "--store", "unlike", *keys).stdout)[0]
    pathlib.Path("two.cfg").write_text("study = { samples = 2; };")
    for seed, change in {11: ["packing.sizes=bidisperse", "packing.large_fraction=0.3"], 31: ["network.prestress=true"],
                         41: ["packing.history=[1e-3]"], 51: ["packing.poisson=0.3"], 61: ["signal.source=velocity"]}.items():
        other = [*keys, *sets(f"packing.seed={seed}", *change)]
        own = run("study", "--store", "unlike", *other).stdout
        refused("", "table", "statics", "--store", "unlike", status=1)
        assert run("table", "statics", "--store", "unlike", "two.cfg", *other).stdout == own, change
    assert table("table", "statics", "--store", "unlike", "two.cfg", *keys).body == alone.body
    # how long one tries does not change what is found
    for more in ((), sets("packing.seed=71", "packing.max_steps=1000000")):
        run("study", "--store", "steps", *keys, *more)
    assert list(table("table", "statics", "--store", "steps")["samples"]) == [4]


def equal_boxes():
    """Two heights that take the same number of grains are one box: made once, counted once."""
    pathlib.Path("equal.cfg").write_text('packing = { width = 6; height = [8, 8.01, 9]; tolerance = 1e-7; };'
                                         'study = { samples = 3; want = ["statics"]; };')
    done = run("study", "equal.cfg", "--store", "equal", "--jobs", 2)
    assert made_now(done.stderr) == 6 == len(files("equal"))
    for found in [Table(done.stdout), *tables(run("study", "equal.cfg", "--store", "equal", "--set", "packing.poisson=[0,0.1]").stdout)]:
        assert list(found["samples"]) == [3, 3] and "missing" not in found.notes


def methods():
    """Signals by every method that a scene may name, nonlinear motion included, which needs the packing as well."""
    found, keys = {}, sets("study.samples=1", 'study.want=["signal"]', "signal.until=40.0", "signal.points=41",
                           "signal.tolerance=1e-3", grains=60, width=8)
    for method in ("chebyshev", "dense", "dynamics"):
        run("study", "--store", method, *keys, "--set", f'signal.method="{method}"')
        with h5py.File(*files(method)) as stored:
            assert stored["signal/method"][()].decode().rstrip("\0") == method
            found[method] = stored["signal/F"][()]
    peak = np.max(np.abs(found["dense"]))
    assert np.max(np.abs(found["chebyshev"] - found["dense"])) < 2e-3 * peak
    assert 0 < np.max(np.abs(found["dynamics"] - found["dense"])) < 0.5 * peak


def failures():
    """Packings that cannot be finished are recorded and counted; the rest of the study goes on."""
    words = ["study", "--store", "failures", *sets("study.samples=2", width=8, grains=40, max_steps=50)]
    done = run(*words)
    found = Table(done.stdout)
    assert names_all(done.stderr, "2") and found.notes["failed"] == "2" and np.isnan(found["c_tof"]).all()
    rows = table("table", "ensemble", "--store", "failures")
    assert list(rows["failed"]) == [1, 1] and "step" in rows.words("reason")[0]
    assert made_now(run(*words).stderr) == 0


def stopped():
    """Ctrl-C: finished samples stay, the exit status is 1, and the same command goes on to the same bytes."""
    keys = [*sets("study.samples=40", width=8, grains=60, pressure=1e-5), "--jobs", "1"]
    for number in (signal.SIGINT, signal.SIGTERM):
        had = len(files("stopped"))
        process = start("study", "--store", "stopped", *keys)
        wait_until(lambda: len(files("stopped")) >= had + 2, "two samples")
        process.send_signal(number)
        out, err = process.communicate(timeout=PATIENCE)
        assert process.returncode == 1 and not out and names_all(err, "40 stopped") and len(err.splitlines()) == 2, (out, err)
        assert had + 2 <= len(files("stopped")) < 40 and not list(pathlib.Path("stopped").glob("*.tmp"))
        run("check", *files("stopped"))
    assert run("study", "--store", "stopped", *keys).stdout == run("study", "--store", "whole", *keys).stdout
    assert [path.name for path in files("stopped")] == [path.name for path in files("whole")]


main(an_ensemble, resumed, shared, files_of_tables, unlike_samples, equal_boxes, methods, failures, stopped)
