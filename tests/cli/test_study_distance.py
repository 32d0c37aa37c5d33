"""study and table over distance: heights and widths swept, fronts at planes, probes, filters; what changes is made anew, and
nothing else. What is fitted, and how, is in tests/unit/test_study_scaling.c.

usage: test_study_distance.py COMMAND SOURCE_DIR
"""
import pathlib

import h5py
import numpy as np

from command import main, refused, run, sets, table, tables
from common import made_now, names_all

SCENE = """
packing = { tolerance = 1e-7; seed = 3; };
signal = { planes = [3, 5, 40]; };
study = { samples = 3; want = ["scaling", "planes", "probes"]; sweep = (
  { key = "packing.width"; values = [8, 12]; },
  { key = "packing.height"; values = [7, 14]; } ); };
"""
WORDS = ["study", "scene.cfg", "--store", "store"]
TEXT = []  # what it printed
BOX = sets("study.samples=3", width=12, tolerance=1e-7, seed=3)


def files():
    return sorted(pathlib.Path("store").glob("*.h5"))


def positions():
    found = {}
    for path in files():
        with h5py.File(path) as stored:
            found[path.name] = stored["particles/grains/position/value"][()].tobytes()
    return found


def an_ensemble():
    pathlib.Path("scene.cfg").write_text(SCENE)
    done = run(*WORDS, "--jobs", 2)
    TEXT.append(done.stdout)
    assert made_now(done.stderr) == 12, done.stderr
    scaling, planes, narrow, wide = tables(done.stdout)  # a table of probes for each width
    assert list(scaling["width"]) == [8, 8, 12, 12] and list(scaling["samples"]) == [3] * 4
    assert [t.notes["packing.width"] for t in (narrow, wide)] == ["8", "12"] and "packing.width" not in scaling.notes
    # the heights that were asked for, in boxes as low and narrow as these to 12%
    assert np.allclose(scaling["distance"], [7, 14] * 2, rtol=0.12), scaling["distance"]
    rows = table("table", "ensemble", "--store", "store")
    for k in range(4):
        mine = (rows["Lx"] == scaling["width"][k]) & (rows["grains"] == scaling["grains"][k])
        for name, other in (("distance", "height"), ("t10", "t10"), ("amplitude", "amplitude"), ("width10", "width")):
            values = rows[other][mine]
            assert len(values) == 3 and np.isclose(scaling[name][k], values.mean(), rtol=1e-12)
            assert np.isclose(scaling[name + "_err"][k], values.std(ddof=1) / 3**0.5, rtol=1e-9)
    length, amplitude, t10 = (scaling[name] for name in ("distance", "amplitude", "t10"))
    for k in (0, 2):
        assert np.isclose(scaling["gamma"][k], -np.log(amplitude[k + 1] / amplitude[k]) / np.log(length[k + 1] / length[k]))
        assert np.isclose(scaling["speed"][k], (length[k + 1] - length[k]) / (t10[k + 1] - t10[k]))
    assert np.isnan(scaling["gamma"][[1, 3]]).all()
    # two heights: the fit is the interval
    assert np.isclose(scaling.note("gamma(p=0.0001, width=8, friction=0.5)"), scaling["gamma"][0], rtol=1e-5)
    # planes: 40 lies above every box, and a plane near the top of a low box may have no front where the echo is too early
    high = planes["grains"] > 100
    assert set(planes["distance"]) == {3, 5} and np.isfinite(planes["t10"]).all()
    assert list(planes["distance"][high]) == [3, 5] * 2 and list(planes["samples"][high]) == [3] * 4
    with h5py.File(files()[0]) as stored:
        assert list(stored["results/planes/height"]) == [3, 5]
        scene = stored["results/sample/scene"][()].decode()
        assert "height" not in scene and "planes = (3" in scene
    # probes: near the moduli themselves (Table IV: 0.93(4); lines stiffen), in boxes so low to a factor of 4
    for probes in (narrow, wide):
        whole = table("table", "moduli", "--store", "store", "--width", probes.notes["packing.width"])["C22"]
        ratio = probes["C22_lines1_ratio"]
        assert np.all((0.2 < ratio) & (ratio < 4)) and np.allclose(ratio, probes["C22_lines1"] / whole, rtol=0.2)


def the_same_by_grains():
    """A packing asked for by its height is the one asked for by the number of grains that follows from it."""
    grains = int(table("table", "ensemble", "--store", "store")["grains"].max())
    one, other = (run("study", "--store", "store", *BOX, *sets(key)) for key in (f"packing.grains={grains}", "packing.height=14"))
    assert made_now(one.stderr) == made_now(other.stderr) == 0 and one.stdout == other.stdout


def filters():
    refused("width", "table", "moduli", "--store", "store", status=1)
    for width in (8, 12):
        moduli = table("table", "moduli", "--store", "store", "--width", width)
        assert list(moduli["samples"]) == [3, 3]
    one = table("table", "moduli", "--store", "store", "--grains", int(moduli["grains"][0]), "--friction", "0.5",
                "--pressure", "0.00010000001")
    assert len(one) == 1 and one["C22"][0] == moduli["C22"][0]
    assert list(table("table", "scaling", "--store", "store", "--width", "12")["width"]) == [12, 12]
    for other in (["--width", "9"], ["--grains", "7"], ["--friction", "0"], ["--pressure", "1e-5"]):
        refused("", "table", "ctof", "--store", "store", *other, status=1)


def only_what_changes_is_made():
    def again(count, *keys):
        done = run(*WORDS, *sets(*keys))
        assert made_now(done.stderr) == count, (keys, done.stderr)
        return done

    assert again(0).stdout == TEXT[0]
    packings, was = positions(), tables(TEXT[0])
    other = tables(again(12, "signal.planes=3,4").stdout)  # planes elsewhere: fronts there, the rest stays
    assert set(other[1]["distance"]) == {3, 4} and other[0].body == was[0].body and positions() == packings
    low = [t["t10"][t["distance"] == 3] for t in (other[1], was[1])]
    assert len(low[0]) == 4 and np.allclose(*low, rtol=1e-9)
    # a table of the old scene has no samples with its planes any more
    lines = run("table", "planes", "--store", "store", "scene.cfg").stdout.splitlines()
    assert any(line.startswith("# lacking = 12 ") for line in lines) and not [line for line in lines if line[:1].isdigit()]
    assert run(*WORDS).stdout == TEXT[0]
    # planes without a front: recorded, though the file has others, and not tried again
    for count in (12, 0):
        assert names_all(again(count, "signal.planes=1.0").stderr, count)
    assert run(*WORDS).stdout == TEXT[0]
    # the signal: made, kept, and made anew when its description changes
    for keys, count in ((["signal.points=31"], 12), (["signal.points=31"], 0), (["signal.points=41"], 12),
                        (["signal.points=41", "signal.until=20"], 12), (["signal.points=41", "signal.until=20"], 0)):
        again(count, "study.want=signal", *keys)
    assert all(h5py.File(path)["signal/F"].shape == (41,) for path in files()) and again(0).stdout == TEXT[0]


def parts_that_are_missing():
    """Files without some parts are read, and get what they lack; those with numbers that no sample has are left out."""
    for path in files():
        with h5py.File(path, "a") as stored:
            del stored["results/planes"], stored["results/probes"]
    fronts = run(*WORDS, *sets("study.want=scaling"))
    assert made_now(fronts.stderr) == 0 and tables(fronts.stdout)[0].body == tables(TEXT[0])[0].body
    done = run(*WORDS)
    assert made_now(done.stderr) == 12 and done.stdout == TEXT[0]
    for name, value in (("planes/height", np.nan), ("planes/height", 1e9), ("sample/pressure", np.nan), ("sample/width", -8.0),
                        ("sample/dim", 7), ("sample/grains", 0)):
        kept = files()[0].read_bytes()
        with h5py.File(files()[0], "a") as stored:
            place = stored["results"][name]
            place[0 if place.shape else ...] = value
        done = run("table", "scaling", "--store", "store")
        assert names_all(done.stderr, "1") and name in done.stderr and sum(tables(done.stdout)[0]["samples"]) == 11, done
        files()[0].write_bytes(kept)
    outside = run("study", "--store", "outside", *sets("study.want=planes", "signal.planes=1000", grains=40, width=6, tolerance=1e-7))
    assert "no row: none of 1 samples" in outside.stdout, outside.stdout


main(an_ensemble, the_same_by_grains, filters, only_what_changes_is_made, parts_that_are_missing)
