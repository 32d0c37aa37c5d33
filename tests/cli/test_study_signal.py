"""sonopack table signal: mean and scatter of the signals in a store, what is left out, what is refused, its figure.

usage: test_study_signal.py COMMAND SOURCE_DIR
"""
import pathlib
import tempfile

import h5py
import numpy as np

from common import names_all
from streams import column, comment, run, tables

PACKING = ["packing.grains=60", "packing.width=8", "packing.tolerance=1e-7"]
GRID = ["signal.until=40", "signal.points=81"]


def study(store, *settings, samples=3, want="signal"):
    keys = [*PACKING, f"study.samples={samples}", f'study.want=["{want}"]', *settings]
    return run("study", "--store", store, *(word for key in keys for word in ("--set", key)))


def signal(store, *args):
    (table,) = tables(run("table", "signal", "--store", store, *args).stdout)
    return table


def forces(store):
    """The stored signals, of the samples that have one."""
    found = []
    for path in sorted(store.glob("*.h5")):
        with h5py.File(path) as stored:
            if "signal" in stored:
                found.append((stored["signal/t"][()].ravel(), stored["signal/F"][()].ravel()))
    return np.array([t for t, _ in found]), np.array([f for _, f in found])


def check_numbers(table, t, f):
    # rounding of a few updates
    largest = abs(f).max()
    n = len(f)
    assert comment(table, "samples") == str(n)
    assert np.array_equal(column(table, "t"), t[0])
    assert np.allclose(column(table, "mean"), f.mean(axis=0), rtol=0, atol=1e-14 * largest)
    assert np.allclose(column(table, "rms"), f.std(axis=0), rtol=1e-12, atol=1e-15 * largest)
    assert np.allclose(column(table, "mean_err"), f.std(axis=0, ddof=1) / n ** 0.5, rtol=1e-12, atol=1e-15 * largest)


def mean_and_rms(store):
    study(store, *GRID)
    t, f = forces(store)
    assert f.shape == (3, 81) and abs(f).max() > 0
    table = signal(store)
    assert table[1] == ["t", "mean", "rms", "mean_err", "low", "high"] and len(table[2]) == 81
    check_numbers(table, t, f)
    assert comment(table, "failed") == "0" and not any("without" in line for line in table[0])
    assert comment(table, "pressure").startswith("0.0001, grains = 60, width = 8")


def formats(folder, store):
    csv = folder / "signal.csv"
    run("table", "signal", "--store", store, "-o", csv)
    lines = [line for line in csv.read_text().splitlines() if not line.startswith("#")]
    assert lines[0] == "t,mean,rms,mean_err,low,high", lines[0]
    rows = np.array([line.split(",") for line in lines[1:]], dtype=float)
    assert np.array_equal(rows[:, 2], column(signal(store), "rms"))


def intervals_of_the_mean(folder):
    """low and high, made without keeping the signals, against numpy's studentised bootstrap that keeps them."""
    store = folder / "many"
    study(store, *GRID, samples=24)
    table = signal(store)
    t, f = forces(store)
    n, size, seed = len(f), 20000, 6
    assert n == 24
    print("seed", seed)
    check_numbers(table, t, f)
    random = np.random.default_rng(seed)
    counts = random.multinomial(n, [1 / n] * n, size).astype(float)
    mean, error = f.mean(axis=0), f.std(axis=0, ddof=1) / n ** 0.5
    alive = error > 1e-12 * error.max()
    away = f - mean
    first, second = counts @ away / n, counts @ away ** 2 / n
    errors = np.sqrt(np.maximum(second - first ** 2, 0) / (n - 1))
    t_all = np.clip(np.divide(first, errors, out=np.zeros_like(first), where=errors > 0), -4.137, 4.137)  # 2 Student's
    ends = mean - np.quantile(t_all, [0.975, 0.025], axis=0) * error
    low, high = column(table, "low"), column(table, "high")
    assert np.all(low <= mean + 1e-12 * error.max()) and np.all(high >= mean - 1e-12 * error.max())
    # an end is a quantile of 1000 resamples, of t beyond 2 in a tail longer than a normal one: known to 0.1 to 0.2 errors
    off = np.array([low - ends[0], high - ends[1]])[:, alive] / error[alive]
    assert np.abs(off).max() < 0.8 and np.all(np.abs(off.mean(axis=1)) < 0.3), (np.abs(off).max(), off.mean(axis=1))
    ratio = ((high - low)[alive] / (ends[1] - ends[0])[alive]).mean()
    assert 0.93 < ratio < 1.07, ratio
    # as all tables: the same bytes again, wider for a higher level, the rest the same
    assert signal(store) == table
    wide = signal(store, "--interval", "0.99")
    assert any("at level 0.99," in line for line in wide[0])
    assert np.all((column(wide, "high") - column(wide, "low"))[alive] > (high - low)[alive])
    assert np.array_equal(column(wide, "mean_err"), column(table, "mean_err"))
    # one signal has no interval
    study(folder / "one", *GRID, samples=1)
    for name in ("rms", "mean_err", "low", "high"):
        assert np.all(np.isnan(column(signal(folder / "one"), name)))


def many_times(folder):
    """More times than are resampled at once: the same as in one window, where there are few."""
    store = folder / "long"
    study(store, "signal.until=40", "signal.points=6001", samples=2)
    table = signal(store)
    t, f = forces(store)
    check_numbers(table, t, f)
    low, high = column(table, "low"), column(table, "high")
    assert np.all(np.isfinite(low)) and len(low) == 6001
    # two samples: Student's interval for one degree of freedom
    assert any("by Student's t (of fewer than 8 samples)" in line for line in table[0])
    half = 12.706204736 * abs(f[0] - f[1]) / 2
    assert np.allclose(high, f.mean(axis=0) + half, rtol=1e-9, atol=1e-9 * abs(f).max())
    assert np.allclose(low, f.mean(axis=0) - half, rtol=1e-9, atol=1e-9 * abs(f).max())


def samples_without_a_signal(store):
    """They are left out, and counted."""
    before = signal(store)
    study(store, samples=5, want="statics")
    table = signal(store)
    assert table[2] == before[2] and comment(table, "samples") == "3"
    assert comment(table, "without_signal").startswith("2 "), table[0]
    check_numbers(table, *forces(store))


def no_signal_at_all(folder):
    store = folder / "statics"
    study(store, want="statics")
    table = signal(store)
    assert not table[2] and comment(table, "samples") == "0"
    assert any("none of 3 samples has a stored signal" in line for line in table[0]), table[0]
    done = run("table", "signal", "--store", folder / "nothing", status=1)
    assert names_all(done.stderr, "")


def failed_samples(folder):
    store = folder / "failing"
    study(store, *GRID)
    keys = [*PACKING, "packing.seed=50", "packing.max_steps=1000", "study.samples=2", 'study.want=["signal"]', *GRID]
    run("study", "--store", store, *(word for key in keys for word in ("--set", key)))
    table = signal(store)
    assert comment(table, "samples") == "3" and comment(table, "failed") == "2", table[0]
    assert any(line.startswith("left out: the first reason is ") and len(line) > 40 for line in table[0])


def unlike_signals(folder):
    # the last time goes with the height, which each sample has its own
    store = folder / "heights"
    study(store)
    done = run("table", "signal", "--store", store, status=1)
    assert names_all(done.stderr, "signal.until"), done.stderr
    # the nonlinear motion at the same times is another signal
    store = folder / "dynamics"
    study(store, *GRID)
    with h5py.File(max(store.glob("*.h5")), "a") as stored:
        stored["signal/method"][...] = "dynamics"
    assert names_all(run("table", "signal", "--store", store, status=1).stderr, "dynamics")
    # other numbers of points
    store = folder / "points"
    study(store, *GRID)
    study(store, "signal.until=40", "signal.points=41", "packing.seed=30")
    done = run("table", "signal", "--store", store, status=1)
    assert names_all(done.stderr, "points") and not done.stdout, done.stderr


def unlike_samples(folder, store):
    study(store, *GRID, "packing.pressure=1e-5")
    study(store, *GRID, "packing.grains=80")
    assert names_all(run("table", "signal", "--store", store, status=1).stderr, "--pressure")
    assert names_all(run("table", "signal", "--store", store, "--pressure", "1e-4", status=1).stderr, "--grains")
    for choice in (["--pressure", "1e-5"], ["--pressure", "1e-4", "--grains", "80"]):
        table = signal(store, *choice)
        assert comment(table, "samples") == "3" and len(table[2]) == 81
    # a scene chooses too; one that wants other times than those stored finds no signal
    scene = folder / "scene.cfg"
    scene.write_text('packing = { grains = 80; width = 8; tolerance = 1e-7; };'
                     'signal = { until = 40; points = 81; }; study = { samples = 3; want = ["signal"]; };')
    assert signal(store, scene)[2] == signal(store, "--grains", "80")[2]
    assert signal(store, scene, "--set", "signal.points=41")[2] == []
    # two frictions are two tables
    keys = ["packing.grains=60", "packing.width=8"]
    study(folder / "mu", *GRID, *keys)
    study(folder / "mu", *GRID, *keys, "packing.friction=0.1")
    assert names_all(run("table", "signal", "--store", folder / "mu", status=1).stderr, "friction")
    check = signal(folder / "mu", "--friction", "0.1")
    assert comment(check, "samples") == "3"


with tempfile.TemporaryDirectory(prefix="sonopack-signals-") as name:
    folder = pathlib.Path(name)
    store = folder / "store"
    for test, arguments in ((mean_and_rms, (store,)), (formats, (folder, store)),
                            (intervals_of_the_mean, (folder,)), (many_times, (folder,)),
                            (samples_without_a_signal, (store,)), (no_signal_at_all, (folder,)),
                            (failed_samples, (folder,)), (unlike_signals, (folder,)), (unlike_samples, (folder, store))):
        test(*arguments)
        print(test.__name__, "ok")
