"""sonopack study and table: an ensemble, its tables, resuming, sharing a store, stopping by Ctrl-C, what is refused.

usage: test_study.py COMMAND SOURCE_DIR
"""
import io
import os
import pathlib
import shutil
import signal
import subprocess
import tempfile

import h5py
import numpy as np

from common import PATIENCE, made_now, names_all, wait_until
from streams import COMMAND, column, comment, run, tables

CTOF = ("p samples c_tof c_tof_err c_peak c_zero c_l c_t "
        "c_tof_low c_tof_high c_peak_err c_zero_err c_l_err c_t_err").split()
ENDS = ("", "_sd", "_err", "_low", "_high")
STATICS = "Phi2 Phi3 Phi3s zs f0 N_over_p Z2 Z3 F2 F2S s1_over_s2 s12_over_s2 mobilised".split()
MODULI = "C11 C12 C22 C33 c_l c_t".split()

# small and at rest soon: this tests the command, not the physics of large boxes
SCENE = """
packing = { width = 8; grains = 40; tolerance = 1e-9; seed = 3; };
study = { samples = 3; want = ["ctof", "moduli"]; sweep = (
  { key = "packing.pressure"; values = [1e-4, 1e-3]; },
  { key = "packing.grains"; values = [40, 120]; } ); };
"""


def an_ensemble(folder):
    scene, store = folder / "scene.cfg", folder / "store"
    scene.write_text(SCENE)
    text = run("study", scene, "--store", store, "--jobs", 2).stdout
    ctof, moduli = tables(text)
    assert ctof[1] == CTOF
    assert list(column(ctof, "p")) == [1e-4, 1e-3] and list(column(ctof, "samples")) == [3, 3]
    assert comment(ctof, "failed") == "0"
    assert moduli[1] == ["p", "grains", "samples", "left_out"] + [name + end for name in MODULI for end in ENDS]
    assert list(column(moduli, "grains")) == [40, 120, 40, 120]
    # c_tof from the rows of the ensemble
    (rows,) = tables(run("table", "ensemble", "--store", store).stdout)
    assert len(rows[2]) == 12 and len({row[rows[1].index("name")] for row in rows[2]}) == 12
    p, grains = column(rows, "p"), column(rows, "grains")
    assert all(np.diff(np.lexsort((column(rows, "seed"), grains, p))) == 1)
    for k, pressure in enumerate((1e-4, 1e-3)):
        low, high = (p == pressure) & (grains == 40), (p == pressure) & (grains == 120)
        rise = column(rows, "height")[high].mean() - column(rows, "height")[low].mean()
        for mark, name in (("t10", "c_tof"), ("t_peak", "c_peak"), ("t_zero", "c_zero")):
            time_ = column(rows, mark)[high].mean() - column(rows, mark)[low].mean()
            assert np.isclose(column(ctof, name)[k], rise / time_, rtol=1e-12), name
        assert np.isclose(column(ctof, "c_l")[k], column(rows, "c_l")[high].mean(), rtol=1e-12)
        assert np.isclose(column(moduli, "C33_sd")[2 * k], column(rows, "C33")[low].std(ddof=1), rtol=1e-9)
        assert np.isclose(column(moduli, "C33_err")[2 * k], column(rows, "C33")[low].std(ddof=1) / 3 ** 0.5, rtol=1e-9)
        assert np.isclose(column(ctof, "c_t_err")[k], column(rows, "c_t")[high].std(ddof=1) / 3 ** 0.5, rtol=1e-9)
        # first order propagation of the three samples' spread: the bootstrap must be of that size
        spread = np.hypot(*(np.hypot(column(rows, "t10")[g].std(ddof=1), column(rows, "height")[g].std(ddof=1)
                                     / column(ctof, "c_tof")[k]) / 3 ** 0.5 for g in (low, high)))
        ratio = column(ctof, "c_tof_err")[k] / (column(ctof, "c_tof")[k] * spread / (rise / column(ctof, "c_tof")[k]))
        assert 0.2 < ratio < 2, ratio
    # a sample's file: packing and results, made by that seed
    name = rows[2][0][rows[1].index("name")]
    file = store / f"{name}.h5"
    run("check", file)
    (front,) = tables(run("front", file).stdout)
    assert column(front, "t10")[0] == column(rows, "t10")[0]
    with h5py.File(file) as stored:
        assert "signal" not in stored  # nobody wanted it
    return scene, store, text


def resumed_and_shared(folder, scene, store, text):
    before = {path.name: path.stat().st_mtime_ns for path in store.iterdir()}
    again = run("study", scene, "--store", store, "--jobs", 1)
    assert again.stdout == text and made_now(again.stderr) == 0
    assert {path.name: path.stat().st_mtime_ns for path in store.iterdir()} == before
    # lost and damaged files are made again, bit for bit
    victims = sorted(store.glob("*.h5"))
    victims[0].unlink()
    victims[1].write_bytes(victims[1].read_bytes()[:1000])
    again = run("study", scene, "--store", store)
    assert again.stdout == text and made_now(again.stderr) == 2
    # a pipe, a folder, an endless device, another sample's file: put aside, not read for ever
    strange = folder / "strange"
    shutil.copytree(store, strange, ignore=shutil.ignore_patterns("*.bad"))
    names = sorted(path.name for path in strange.glob("*.h5"))
    for name in names[:3]:
        (strange / name).unlink()
    os.mkfifo(strange / names[0])
    (strange / names[1]).mkdir()
    (strange / names[2]).symlink_to("/dev/zero")
    shutil.copy(strange / names[4], strange / names[3])
    again = run("study", scene, "--store", strange)
    assert again.stdout == text and made_now(again.stderr) == 4
    # shards in any order, and more than one process at a time, give the same bytes
    shared = folder / "shared"
    parts = [subprocess.Popen([COMMAND, "study", scene, "--store", shared, "--shard", f"{k}/3", "--jobs", "1"],
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) for k in (3, 1, 2)]
    for part in parts:
        assert part.wait() == 0, part.stderr.read()
        part.stdout.close(), part.stderr.close()
    assert run("study", scene, "--store", shared).stdout == text
    assert run("table", "ctof", "--store", shared).stdout == text.split("\n\n")[0] + "\n"
    # more wishes: only they are made, the packings stay
    more = run("study", scene, "--store", shared, "--set", 'study.want=["ctof","statics","signal"]')
    ctof, statics = tables(more.stdout)
    assert statics[1] == ["p", "grains", "samples", "left_out"] + [name + end for name in STATICS for end in ENDS]
    assert ctof[2] == tables(text)[0][2]
    for path in shared.glob("*.h5"):
        with h5py.File(path) as stored:
            assert "signal" in stored
    # more samples: the scene's own table has them, the first scene's table does not
    larger = run("study", scene, "--store", shared, "--set", "study.samples=4", "-q")
    assert list(column(tables(larger.stdout)[0], "samples")) == [4, 4] and not larger.stderr
    assert run("table", "ctof", "--store", shared, scene).stdout == text.split("\n\n")[0] + "\n"
    (all_of_it,) = tables(run("table", "ctof", "--store", shared).stdout)
    assert list(column(all_of_it, "samples")) == [4, 4]
    # nothing of the scene is there: no empty table
    assert names_all(run("table", "ctof", "--store", shared, scene, "--set", "packing.seed=77",
                                           status=1).stderr, "12")
    # what is not there yet is counted
    (early,) = tables(run("table", "ctof", "--store", shared, scene, "--set", "study.samples=6").stdout)
    assert comment(early, "missing").startswith("8 ")


def check_ends(low, high, expected, error, what):
    """Ends of an interval, of 1000 resamples here and 20000 there: t at 95% has the deviation 0.09 errors for normal
    samples, and a few times that in the long tail that t has for few."""
    for found, there in ((low, expected[0]), (high, expected[1])):
        assert abs(found - there) <= 0.6 * error + 1e-12 * abs(there), (what, found, there, error)


def intervals(folder):
    """Means, errors and intervals of the tables, against numpy's own bootstrap of the rows of the ensemble."""
    store = folder / "intervals"
    keys = ["packing.width=8", "packing.tolerance=1e-7", "study.samples=12",
            'study.want=["ctof","statics","moduli"]']
    for grains in (40, 120):
        settings = [word for key in (*keys, f"packing.grains={grains}") for word in ("--set", key)]
        run("study", "--store", store, *settings)
    (rows,) = tables(run("table", "ensemble", "--store", store).stdout)
    seed = 5
    print("seed", seed)
    random = np.random.default_rng(seed)
    grains, n, size = column(rows, "grains"), 12, 20000
    student = 2.2009851600829 * 2  # of 11 degrees of freedom, twice

    def ends(value, error, values, errors):
        t = np.clip((values - value) / errors, -student, student)
        return value - np.quantile(t, [0.975, 0.025]) * error

    seen = 0
    for table, names in (("statics", STATICS), ("moduli", MODULI)):
        (means,) = tables(run("table", table, "--store", store).stdout)
        for row, number in enumerate((40, 120)):
            pick = random.integers(0, n, (size, n))
            for name in names:
                x = column(rows, name)[grains == number]
                found = {end: column(means, name + end)[row] for end in ENDS}
                if np.isnan(x).any():  # what a packing lacks has no mean, error or interval
                    assert all(np.isnan(number) for number in found.values()), (name, found)
                    continue
                seen += 1
                error = x.std(ddof=1) / n ** 0.5
                assert np.isclose(found[""], x.mean(), rtol=1e-12) and np.isclose(found["_err"], error, rtol=1e-9)
                assert np.isclose(found["_sd"], x.std(ddof=1), rtol=1e-9)
                drawn = x[pick]
                check_ends(found["_low"], found["_high"],
                           ends(x.mean(), error, drawn.mean(axis=1), drawn.std(axis=1, ddof=1) / n ** 0.5 + 1e-300),
                           error, name)
    assert seen > 20, seen
    # the speed: a quotient of differences of means, its error to first order
    (ctof,) = tables(run("table", "ctof", "--store", store).stdout)
    height, time_ = ([column(rows, mark)[grains == number] for number in (40, 120)] for mark in ("height", "t10"))

    def speed(low, high):
        h, t = ([quantity[g][pick] for g, pick in enumerate((low, high))] for quantity in (height, time_))
        rise, flight = (q[1].mean(axis=-1) - q[0].mean(axis=-1) for q in (h, t))
        own = [h[g] / np.expand_dims(rise, -1) - t[g] / np.expand_dims(flight, -1) for g in (0, 1)]
        return rise / flight, rise / flight * np.sqrt(sum(o.var(axis=-1, ddof=1) / n for o in own))

    value, error = speed(np.arange(n), np.arange(n))
    values, errors = speed(random.integers(0, n, (size, n)), random.integers(0, n, (size, n)))
    assert np.isclose(column(ctof, "c_tof")[0], value, rtol=1e-12)
    check_ends(column(ctof, "c_tof_low")[0], column(ctof, "c_tof_high")[0], ends(value, error, values, errors), error,
               "c_tof")
    # levels: wider and wider, the rest of the table the same; what is no level is refused
    width = []
    for level in ("0.5", "0.95", "0.999"):
        (other,) = tables(run("table", "ctof", "--store", store, "--interval", level).stdout)
        width.append(column(other, "c_tof_high")[0] - column(other, "c_tof_low")[0])
        assert column(other, "c_tof_err")[0] == column(ctof, "c_tof_err")[0]
        assert any(f"at level {level}," in line for line in other[0]), other[0]
    assert width[0] < width[1] < width[2], width
    assert width[1] == column(ctof, "c_tof_high")[0] - column(ctof, "c_tof_low")[0]
    for wrong in ("95", "0.4", "1", "nan", "wide"):
        assert names_all(run("table", "ctof", "--store", store, "--interval", wrong, status=2).stderr, "--interval")
    assert any("at level 0.68," in line for line in run("study", "--store", store, "--interval", "0.68", *settings)
               .stdout.splitlines())


def files_of_tables(folder, scene, store, text):
    out = folder / "tables.tsv"
    run("study", scene, "--store", store, "-o", out)
    ctof, moduli = text.split("\n\n")
    assert out.read_text() == ctof + "\n" and (folder / "tables-moduli.tsv").read_text() == moduli
    run("study", scene, "--store", store, "-o", out, status=2)
    run("study", scene, "--store", store, "-o", out, "--force")
    out.unlink()
    run("study", scene, "--store", store, "-o", out, status=2)  # the other table is in the way
    assert not out.exists()
    run("table", "moduli", "--store", store, "-o", folder / "m.csv")
    assert len(np.genfromtxt(io.StringIO((folder / "m.csv").read_text()), delimiter=",", names=True)) == 4


def other_sweeps(folder):
    """A sweep over what has no rows: a table for each value, and no average over them."""
    store = folder / "frictions"
    args = ["--store", store, "--set", "study.samples=2", "--set", "packing.width=8", "--set", "packing.grains=120",
            "--set", "packing.tolerance=1e-7", "--set", "study.want=statics", "--set",
            'study.sweep=({ key = "packing.friction"; values = [0.0, 0.5]; })']
    both = tables(run("study", *args).stdout)
    assert [comment(table, "packing.friction") for table in both] == ["0", "0.5"]
    assert column(both[0], "zs")[0] > column(both[1], "zs")[0] + 0.3  # 4 against 3 and more
    done = run("table", "statics", "--store", store, status=1)
    assert names_all(done.stderr, "friction")
    assert len(tables(run("table", "ensemble", "--store", store).stdout)[0][2]) == 4


def unlike_scenes(folder):
    """Samples of unlike scenes in one store are averaged by nobody, whatever their seeds; a scene chooses its own."""
    store, base = folder / "unlike", ["packing.width=8", "packing.grains=60", "study.samples=2", 'study.want=["statics"]']
    changes = {11: ["packing.sizes=bidisperse", "packing.large_fraction=0.3"], 21: ["packing.protocol=somfai2005"],
               31: ["network.prestress=true"], 41: ["packing.history=[1e-3]"], 51: ["packing.poisson=0.3"],
               61: ["signal.source=velocity"], 71: ["packing.max_steps=1000000"]}

    def keys(settings):
        return [word for setting in [*base, *settings] for word in ("--set", setting)]
    alone = tables(run("study", "--store", store, *keys([])).stdout)[0]
    for seed, change in changes.items():
        one = folder / f"unlike-{seed}"
        for place in (one, store):
            own = run("study", "--store", place, *keys([f"packing.seed={seed}", *change])).stdout
        run("study", "--store", one, *keys([]))
        both = run("table", "statics", "--store", one, status=0 if seed == 71 else 1)
        if seed == 71:  # how long one tries does not change what is found
            assert list(column(tables(both.stdout)[0], "samples")) == [4]
        else:
            assert both.stderr and not both.stdout, (seed, both.stderr)
        (folder / "unlike.cfg").write_text("study = { samples = 2; };")
        assert run("table", "statics", "--store", store, folder / "unlike.cfg",
                   *keys([f"packing.seed={seed}", *change])).stdout == own
    (folder / "unlike.cfg").write_text("study = { samples = 2; };")
    assert tables(run("table", "statics", "--store", store, folder / "unlike.cfg", *keys([])).stdout)[0] == alone


def heights_of_equal_boxes(folder):
    """Two heights that take the same number of grains are one box: made once, counted once."""
    store = folder / "equal"
    (folder / "equal.cfg").write_text('packing = { width = 6; height = [8, 8.01, 9]; tolerance = 1e-7; };'
                                      'study = { samples = 3; want = ["statics"]; };')
    done = run("study", folder / "equal.cfg", "--store", store, "--jobs", 2)
    (table,) = tables(done.stdout)
    assert made_now(done.stderr) == 6 and len(list(store.glob("*.h5"))) == 6
    assert list(column(table, "samples")) == [3, 3] and not any("missing" in line for line in table[0])
    # by cases as well
    sweep = run("study", folder / "equal.cfg", "--store", store, "--set", "packing.poisson=[0,0.1]")
    for table in tables(sweep.stdout):
        assert list(column(table, "samples")) == [3, 3] and not any("missing" in line for line in table[0])


def other_methods(folder):
    """Signals by every method that a scene may name, nonlinear motion included, which needs the packing as well."""
    found = {}
    (folder / "one.cfg").write_text("packing = { grains = 60; width = 8.0; }; study = { samples = 1; want = "
                                    '["signal"]; }; signal = { until = 40.0; points = 41; tolerance = 1e-3; };\n')
    for method in ("chebyshev", "dense", "dynamics"):
        store = folder / method
        run("study", "--store", store, folder / "one.cfg", "--set", f'signal.method="{method}"')
        (path,) = store.glob("*.h5")
        with h5py.File(path) as stored:
            assert stored["signal/method"][()].decode().rstrip("\0") == method, stored["signal/method"][()]
            found[method] = stored["signal/F"][()]
    peak = np.max(np.abs(found["dense"]))
    assert np.max(np.abs(found["chebyshev"] - found["dense"])) < 2e-3 * peak
    assert 0 < np.max(np.abs(found["dynamics"] - found["dense"])) < 0.5 * peak


def failures(folder):
    """Packings that cannot be finished are recorded and counted; the rest of the study goes on."""
    store = folder / "failures"
    args = ["--store", store, "--set", "packing.width=8", "--set", "packing.grains=40", "--set", "packing.max_steps=50",
            "--set", "study.samples=2"]
    done = run("study", *args)
    assert names_all(done.stderr, "2")
    (table,) = tables(done.stdout)
    assert comment(table, "failed") == "2" and np.isnan(column(table, "c_tof")).all()
    (rows,) = tables(run("table", "ensemble", "--store", store).stdout)
    assert list(column(rows, "failed")) == [1, 1] and "step" in rows[2][0][rows[1].index("reason")]
    assert made_now(run("study", *args).stderr) == 0


def stopped(folder):
    """Ctrl-C: finished samples stay, the exit status is 1, and the same command goes on to the same bytes."""
    store, whole = folder / "stopped", folder / "whole"
    args = ["--set", "packing.width=8", "--set", "packing.grains=60", "--set", "packing.pressure=1e-5",
            "--set", "study.samples=40", "--jobs", "1"]
    for number in (signal.SIGINT, signal.SIGTERM):
        process = subprocess.Popen([COMMAND, "study", "--store", store, *args], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True)
        had = len(list(store.glob("*.h5"))) if store.exists() else 0
        wait_until(lambda: store.exists() and len(list(store.glob("*.h5"))) >= had + 2, "two samples")
        process.send_signal(number)
        out, err = process.communicate(timeout=PATIENCE)
        assert process.returncode == 1 and not out, (process.returncode, out)
        assert names_all(err, f"40 {store}") and len(err.splitlines()) == 2, err
        there = sorted(path.name for path in store.glob("*.h5"))
        assert had + 2 <= len(there) < 40 and not list(store.glob("*.tmp")), there
        run("check", *store.glob("*.h5"))
    resumed, straight = run("study", "--store", store, *args), run("study", "--store", whole, *args)
    assert resumed.stdout == straight.stdout
    assert sorted(path.name for path in store.glob("*.h5")) == sorted(path.name for path in whole.glob("*.h5"))


def wrong_usage(folder, scene, store):
    for args in (["study"], ["study", scene], ["study", "--store", store], ["study", folder / "absent.cfg", "--store", store],
                 ["study", scene, "--store", store, "--jobs", "0"], ["study", scene, "--store", store, "--shard", "0/2"],
                 ["study", scene, "--store", store, "--shard", "3/2"], ["study", scene, "--store", store, "--shard", "2"],
                 ["study", scene, "--store", store, "--shard", "1/2/3"], ["study", scene, scene, "--store", store],
                 ["study", scene, "--store", store, "--set", "packing.grain=3"],
                 ["study", scene, "--store", store, "--set", "packing.pressure=1e-5"],
                 ["table", "ctof", scene, "--store", store, "--set", "packing.grains=60"],
                 ["table", "ctof", "--store", store, "--set", "packing.seed=3"],
                 ["study", scene, "--store", store, "--set", "study.want=signal", "-o", folder / "x.tsv"],
                 ["study", scene, "--store", store, "-o", folder / "x.png"],
                 ["table"], ["table", "ctof"], ["table", "--store", store], ["table", "spectra", "--store", store],
                 ["table", "ctof", scene, scene, "--store", store]):
        done = run(*args, status=2)
        assert done.stderr.startswith("sonopack") and not done.stdout, (args, done.stderr)
    assert names_all(run("table", "ctof", "--store", folder / "absent", status=1).stderr, "absent")
    assert not (folder / "absent").exists()
    assert names_all(run(
        "study", scene, "--store", store, "--set", "packing.pressure=1e-5", status=2).stderr, "packing.pressure study.sweep")
    (folder / "empty").mkdir()
    assert run("table", "ctof", "--store", folder / "empty", status=1).stderr
    one = ["pack", scene, "--set", "packing.pressure=1e-3", "-o"]  # one packing: the sweep does not hide it
    assert run(*one, folder / "one.h5").stdout.splitlines()[-1].split("\t")[2] == "0.001"
    (folder / "file").write_text("x")
    run("study", scene, "--store", folder / "file", status=1)


with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    scene, store, text = an_ensemble(folder)
    print("an_ensemble ok")
    for test, arguments in ((resumed_and_shared, (scene, store, text)), (files_of_tables, (scene, store, text)),
                            (intervals, ()),
                            (other_sweeps, ()), (unlike_scenes, ()), (heights_of_equal_boxes, ()),
                            (other_methods, ()), (failures, ()), (stopped, ()), (wrong_usage, (scene, store))):
        test(folder, *arguments)
        print(test.__name__, "ok")
