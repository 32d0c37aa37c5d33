"""coda: changes of one grain are found, also from signals in files; what no grain explains leaves doubt. The statistics are
in tests/unit/test_inference_coda.c.

usage: test_coda.py COMMAND SOURCE_DIR
"""
import shutil

import h5py
import numpy as np

from command import N200, SOURCE, main, pack, refused, run, sets, table

PLACES = ["--detector=part:0:12", "--detector=part:12:24"]


def one():
    found = table("coda", N200, "--grain=78", "--change=0.01", "--noise=0.001", "--rows=5")
    assert len(found) == 5 and found["grain"][0] == 78 and found["probability"][0] > 0.99
    assert abs(found["change"][0] / 0.01 - 1) < 0.1 and found.note("distance") == 0
    assert found["misfit"][0] < found["misfit"][1] and found.notes["fits"] == "yes"
    # noise that is known contradicts nothing; a change by much, which kernels do not know, does
    assert table("coda", N200, "--grain=78", "--change=0.01", "--noise=0.1").notes["fits"] == "yes"
    for change in (1, 3, -0.9):
        assert table("coda", N200, "--grain=78", f"--change={change}").notes["fits"] == "no"


def trials():
    """Noise hides places, and detectors find them again."""
    found = {}
    for name, words in (("quiet", []), ("loud", ["--noise=0.2"]),
                        ("many", ["--noise=0.2", *(f"--detector=part:{x}:{x + 6}" for x in range(0, 24, 6))])):
        t = table("coda", N200, "--trials=40", *words)
        found[name] = t.note("found")
        assert len(t) == 40 and (t.note("distance") == 0) == (found[name] == 1) and t.note("found_err") > 0.01
    assert found["quiet"] == 1 and found["loud"] < 0.7 and found["many"] > found["loud"], found


def files():
    """Signals of two packings of which one has changed: the contacts of grain 50 are 2% stiffer."""
    run("design", N200, "--goal=delay", "--vary=modulus", "--limits=0.999999999:1.000000001", "--iterations=0",
        "--packing=before.h5")
    shutil.copy("before.h5", "after.h5")
    with h5py.File("after.h5", "r+") as file:
        ends = np.concatenate([file["/connectivity/contacts"][:], file["/sonopack/walls/contacts"][:]])
        for name in ("normal_stiffness", "tangential_stiffness"):
            values = file["/sonopack/contacts/" + name][:]
            file["/sonopack/contacts/" + name][:] = np.where((ends == 50).any(axis=1), 1.02, 1) * values
    for name in ("before", "after"):
        run("signal", f"{name}.h5", "--until=400", "--points=1000", *PLACES, "-o", f"{name}.tsv")
    words = ["coda", "before.h5", "--before=before.tsv"]
    found = table(*words, "--after=after.tsv", "--window=50:400", *PLACES)
    assert found["grain"][0] == 50 and abs(found["change"][0] / 0.02 - 1) < 0.1 and found.notes["pairs"] == "2", found.row()
    run("signal", "after.h5", "--until=400", "--points=900", *PLACES, "-o", "other.tsv")
    refused("", *words, "--after=after.tsv", "--window=500:600", *PLACES)
    refused("", *words, "--after=other.tsv", *PLACES)
    for more in (["--after=before.tsv", *PLACES], ["--after=after.tsv", *PLACES, "--detector=top"],
                 ["--after=after.tsv", *PLACES[:1]], ["--after=after.tsv"]):  # columns without a place, and the other way
        refused("", *words, *more, status=1)


def doubt():
    """Signals of other packings differ by more than a grain; so do changes beyond the first order."""
    keys = ["--until=230", "--points=900"]
    run("signal", N200, *keys, "-o", "s0.tsv")
    for seed in (2, 3):
        pack("other.h5", SOURCE / "packings/single.cfg", grains=200, seed=seed, protocol="quick")
        run("signal", "other.h5", *keys, "-o", f"s{seed}.tsv")
    for noise in ([], ["--noise=0.01"]):
        best = [table("coda", N200, f"--before={b}.tsv", f"--after={a}.tsv", *noise)["probability"][0]
                for b, a in (("s0", "s2"), ("s0", "s3"), ("s2", "s3"))]
        assert max(best) < 0.95, best
    found = table("coda", N200, "--trials=40", "--change=1")
    assert found.note("found") < 0.3 and found["probability"].mean() < 0.8


main(one, trials, files, doubt)
