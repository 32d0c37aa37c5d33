"""table signal: mean and scatter of the signals in a store, what is left out, and what is refused. The intervals are in
tests/unit/test_study_signals.c.

usage: test_study_signal.py COMMAND SOURCE_DIR
"""
import pathlib

import h5py
import numpy as np

from command import Table, main, refused, run, sets, table

GRID = ["signal.until=40", "signal.points=81"]


def study(store, *keys, samples=3, want="signal", **packing):
    keys = sets(f"study.samples={samples}", f'study.want=["{want}"]', *keys, **{"grains": 60, "width": 8, "tolerance": 1e-7, **packing})
    return run("study", "--store", store, *keys)


def signal(store, *words):
    return table("table", "signal", "--store", store, *words)


def unlike(names, store, *words):
    refused(names, "table", "signal", "--store", store, *words, status=1)


def check_numbers(found, store):
    """Against the stored signals, of the samples that have one. Returns these."""
    t, f = [], []
    for path in sorted(pathlib.Path(store).glob("*.h5")):
        with h5py.File(path) as stored:
            if "signal" in stored:
                t, f = stored["signal/t"][()].ravel(), [*f, stored["signal/F"][()].ravel()]
    f, n = np.array(f), len(f)
    slack = 1e-14 * abs(f).max()  # rounding of a few updates
    assert found.notes["samples"] == str(n) and np.array_equal(found["t"], t)
    for name, value in (("mean", f.mean(axis=0)), ("rms", f.std(axis=0)), ("mean_err", f.std(axis=0, ddof=1) / n**0.5)):
        assert np.allclose(found[name], value, rtol=1e-12, atol=slack), name
    return f


def mean_and_rms():
    study("store", *GRID)
    found = signal("store")
    assert found.names == ["t", "mean", "rms", "mean_err", "low", "high"] and len(found) == 81
    check_numbers(found, "store")
    assert found.notes["failed"] == "0" and found.notes["pressure"].startswith("0.0001, grains = 60, width = 8")
    run("table", "signal", "--store", "store", "-o", "signal.csv")
    rows = [line.split(",") for line in pathlib.Path("signal.csv").read_text().splitlines() if line[0] != "#"]
    assert rows == found.body


def intervals():
    """Wider for a higher level, the rest the same; of two signals Student's for one degree of freedom, at any number of
    times; of one none."""
    study("many", *GRID, samples=12)
    found, wide = signal("many"), signal("many", "--interval", "0.99")
    f = check_numbers(found, "many")
    alive = found["mean_err"] > 1e-12 * abs(f).max()
    assert np.all(found["low"][alive] <= found["mean"][alive]) and np.all(found["high"][alive] >= found["mean"][alive])
    assert np.all((wide["high"] - wide["low"])[alive] > (found["high"] - found["low"])[alive])
    assert np.array_equal(wide["mean_err"], found["mean_err"]) and signal("many").body == found.body
    study("long", "signal.until=40", "signal.points=6001", samples=2)  # more times than are resampled at once
    found = signal("long")
    f = check_numbers(found, "long")
    half = 12.706204736 * abs(f[0] - f[1]) / 2
    for name, end in (("high", f.mean(axis=0) + half), ("low", f.mean(axis=0) - half)):
        assert np.allclose(found[name], end, rtol=1e-9, atol=1e-9 * abs(f).max()), name
    study("one", *GRID, samples=1)
    assert all(np.isnan(signal("one")[name]).all() for name in ("rms", "mean_err", "low", "high"))


def left_out():
    """Samples without a signal, and those that failed, are counted."""
    before = signal("store")
    study("store", samples=5, want="statics")
    found = signal("store")
    assert found.body == before.body and found.notes["without_signal"].startswith("2 ")
    study("store", *GRID, "packing.seed=50", samples=2, max_steps=1000)
    found = signal("store")
    assert found.body == before.body and found.notes["failed"] == "2"
    study("statics", want="statics")
    text = run("table", "signal", "--store", "statics").stdout
    assert "# samples = 0" in text and "none of 3 samples" in text


def unlike_signals():
    study("heights")  # the last time goes with the height, which each sample has its own
    unlike("signal.until", "heights")
    study("points", *GRID)
    study("points", "signal.until=40", "signal.points=41", "packing.seed=30")
    unlike("points", "points")
    study("one", *GRID, samples=2)
    with h5py.File(max(pathlib.Path("one").glob("*.h5")), "a") as stored:  # the nonlinear motion is another signal
        stored["signal/method"][...] = "dynamics"
    unlike("dynamics", "one")


def unlike_samples():
    study("mixed", *GRID)
    for keys in ({"pressure": 1e-5}, {"grains": 80}, {"friction": 0.1}):
        study("mixed", *GRID, **keys)
    unlike("--pressure", "mixed")
    unlike("--grains", "mixed", "--pressure", "1e-4")
    unlike("friction", "mixed", "--pressure", "1e-4", "--grains", "60")
    for choice in (["--pressure", "1e-5"], ["--pressure", "1e-4", "--grains", "80"], ["--friction", "0.1"]):
        found = signal("mixed", *choice)
        assert found.notes["samples"] == "3" and len(found) == 81, choice
    # a scene chooses too; one that wants other times than those stored finds no signal
    pathlib.Path("scene.cfg").write_text('packing = { grains = 80; width = 8; tolerance = 1e-7; };'
                                         'signal = { until = 40; points = 81; }; study = { samples = 3; want = ["signal"]; };')
    assert signal("mixed", "scene.cfg").body == signal("mixed", "--grains", "80").body
    assert len(Table(run("table", "signal", "--store", "mixed", "scene.cfg", *sets("signal.points=41")).stdout)) == 0


main(mean_and_rms, intervals, left_out, unlike_signals, unlike_samples)
