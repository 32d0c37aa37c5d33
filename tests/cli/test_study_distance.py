"""sonopack study and table over distance: heights and widths swept, fronts at planes, probes, filters, and stores that
lack newer parts.

usage: test_study_distance.py COMMAND SOURCE_DIR
"""
import pathlib
import shutil
import tempfile

import h5py
import numpy as np

from common import made_now, names_all
from streams import column, comment, run, tables

SCENE = """
packing = { tolerance = 1e-7; seed = 3; };
signal = { planes = [3, 5, 40]; };
study = { samples = 3; want = ["scaling", "planes", "probes"]; sweep = (
  { key = "packing.width"; values = [8, 12]; },
  { key = "packing.height"; values = [7, 14]; } ); };
"""


def an_ensemble(folder):
    scene, store = folder / "scene.cfg", folder / "store"
    scene.write_text(SCENE)
    done = run("study", scene, "--store", store, "--jobs", 2)
    assert made_now(done.stderr) == 12, done.stderr
    scaling, planes, narrow, wide = tables(done.stdout)  # a table of probes for each width
    assert list(column(scaling, "width")) == [8, 8, 12, 12] and list(column(scaling, "samples")) == [3] * 4
    assert [comment(t, "packing.width") for t in (narrow, wide)] == ["8", "12"]
    assert not any(line.startswith("packing.width") for line in scaling[0])
    # the heights that were asked for, in boxes as low and narrow as these to 12%
    assert np.allclose(column(scaling, "distance"), [7, 14] * 2, rtol=0.12), column(scaling, "distance")
    # the numbers of the rows, from the ensemble
    (rows,) = tables(run("table", "ensemble", "--store", store).stdout)
    for k in range(4):
        mine = (column(rows, "Lx") == column(scaling, "width")[k]) & (column(rows, "grains") == column(scaling, "grains")[k])
        assert mine.sum() == 3
        for name, other in (("distance", "height"), ("t10", "t10"), ("amplitude", "amplitude"), ("width10", "width")):
            values = column(rows, other)[mine]
            assert np.isclose(column(scaling, name)[k], values.mean(), rtol=1e-12)
            assert np.isclose(column(scaling, name + "_err")[k], values.std(ddof=1) / 3 ** 0.5, rtol=1e-9)
    length, amplitude, t10 = (column(scaling, name) for name in ("distance", "amplitude", "t10"))
    for k in (0, 2):
        assert np.isclose(column(scaling, "gamma")[k], -np.log(amplitude[k + 1] / amplitude[k]) / np.log(length[k + 1] / length[k]))
        assert np.isclose(column(scaling, "speed")[k], (length[k + 1] - length[k]) / (t10[k + 1] - t10[k]))
    assert np.isnan(column(scaling, "gamma")[[1, 3]]).all()
    # two heights: the fit is the interval
    fit = float(comment(scaling, "gamma(p=0.0001, width=8, friction=0.5)").split(",")[0])
    assert np.isclose(fit, column(scaling, "gamma")[0], rtol=1e-5)
    assert "through all of its points, no chi2" in comment(scaling, "gamma(p=0.0001, width=8, friction=0.5)")
    # planes: 40 lies above every box
    # and a plane near the top of a box has no front where the echo is too early
    assert set(column(planes, "distance")) == {3, 5} and len(planes[2]) in (6, 7, 8), planes
    assert np.isfinite(column(planes, "t10")).all() and (column(planes, "samples") >= 1).all()
    high = column(planes, "grains") > 100
    assert list(column(planes, "distance")[high]) == [3, 5] * 2 and list(column(planes, "samples")[high]) == [3] * 4
    name = rows[2][0][rows[1].index("name")]
    with h5py.File(store / f"{name}.h5") as stored:
        assert list(stored["results/planes/height"]) == [3, 5]
        assert stored["results/planes/t10"].attrs["unit"].decode().startswith("d / sqrt")
        scene_text = stored["results/sample/scene"][()].decode()
        assert "height" not in scene_text and "planes = (3" in scene_text
    # probes: near the moduli themselves (Table IV: 0.93(4); lines stiffen), in boxes so low to a factor of 4
    for table in (narrow, wide):
        assert list(column(table, "samples")) == [3, 3]
        assert all(0.2 < ratio < 4 for ratio in column(table, "C22_lines1_ratio")), table
        assert np.allclose(column(table, "C22_lines1_ratio"), column(table, "C22_lines1") / column_of_moduli(store, table),
                           rtol=0.2)  # mean of ratios, ratio of means
    return scene, store, done.stdout


def column_of_moduli(store, table):
    (moduli,) = tables(run("table", "moduli", "--store", store, "--width", comment(table, "packing.width")).stdout)
    return column(moduli, "C22") if len(moduli[2]) else np.array([np.nan])


def the_same_by_grains(scene, store):
    """A packing asked for by its height is the one asked for by the number of grains that follows from it."""
    (rows,) = tables(run("table", "ensemble", "--store", store).stdout)
    grains = int(column(rows, "grains").max())
    again = run("study", "--store", store, "--set", f"packing.grains={grains}", "--set", "packing.width=12", "--set",
                "packing.tolerance=1e-7", "--set", "packing.seed=3", "--set", "study.samples=3")
    assert made_now(again.stderr) == 0, again.stderr
    by_height = run("study", "--store", store, "--set", "packing.height=14", "--set", "packing.width=12", "--set",
                    "packing.tolerance=1e-7", "--set", "packing.seed=3", "--set", "study.samples=3")
    assert made_now(by_height.stderr) == 0 and by_height.stdout == again.stdout


def filters(store):
    refused = run("table", "moduli", "--store", store, status=1)
    assert names_all(refused.stderr, "width")
    for width in (8, 12):
        (moduli,) = tables(run("table", "moduli", "--store", store, "--width", width).stdout)
        assert len(moduli[2]) == 2 and list(column(moduli, "samples")) == [3, 3]
    grains = int(column(moduli, "grains")[0])
    (one,) = tables(run("table", "moduli", "--store", store, "--grains", grains, "--friction", "0.5", "--pressure",
                        "0.00010000001").stdout)
    assert len(one[2]) == 1 and column(one, "C22")[0] == column(moduli, "C22")[0]
    (scaling,) = tables(run("table", "scaling", "--store", store, "--width", "12").stdout)
    assert list(column(scaling, "width")) == [12, 12]
    for other in (["--width", "9"], ["--grains", "7"], ["--friction", "0"], ["--pressure", "1e-5"]):
        assert names_all(run("table", "ctof", "--store", store, *other, status=1).stderr, "")
    for wrong in (["--width", "wide"], ["--grains", "1.5"], ["--pressure", "-1"], ["--friction"]):
        run("table", "ctof", "--store", store, *wrong, status=2)


def only_what_changes_is_made(scene, store, text):
    again = run("study", scene, "--store", store)
    assert again.stdout == text and made_now(again.stderr) == 0
    before = {path.name: path.stat().st_mtime_ns for path in store.glob("*.h5")}
    packings = {path.name: positions(path) for path in store.glob("*.h5")}
    # planes elsewhere: fronts there, the rest stays
    other = run("study", scene, "--store", store, "--set", "signal.planes=3,4")
    assert made_now(other.stderr) == 12
    planes = tables(other.stdout)[1]
    assert set(column(planes, "distance")) == {3, 4}
    was = tables(text)[1]
    low = [column(t, "t10")[column(t, "distance") == 3] for t in (planes, was)]
    assert len(low[0]) == 4 and np.allclose(*low, rtol=1e-9)
    assert tables(other.stdout)[0][2] == tables(text)[0][2]
    assert {path.name: positions(path) for path in store.glob("*.h5")} == packings
    assert set(before) == set(packings)
    # a table of the old scene has no samples with its planes any more
    (missing,) = tables(run("table", "planes", "--store", store, scene).stdout)
    assert comment(missing, "lacking").startswith("12 ") and comment(missing, "failed") == "0" and not missing[2]
    back = run("study", scene, "--store", store)
    assert back.stdout == text
    # planes without a front: recorded, though the file has others, and not tried again
    for count in (12, 0, 0):
        beyond = run("study", scene, "--store", store, "--set", "signal.planes=1.0")
        assert made_now(beyond.stderr) == count and names_all(beyond.stderr, count), beyond.stderr
    back = run("study", scene, "--store", store)
    assert back.stdout == text
    # the signal: made, kept, and made anew when its description changes
    signal = ["study", scene, "--store", store, "--set", "study.want=signal", "--set"]
    for setting, count in (("signal.points=31", 12), ("signal.points=31", 0), ("signal.points=41", 12)):
        assert made_now(run(*signal, setting).stderr) == count
    assert all(h5py.File(path)["signal/F"].shape == (41,) for path in store.glob("*.h5"))
    assert made_now(run(*signal, "signal.points=41", "--set", "signal.until=20").stderr) == 12
    assert made_now(run(*signal, "signal.points=41", "--set", "signal.until=20").stderr) == 0
    assert run("study", scene, "--store", store).stdout == text


def positions(path):
    with h5py.File(path) as stored:
        return stored["particles/grains/position/value"][()].tobytes()


def stores_without_newer_parts(scene, store, text):
    """Files as earlier versions wrote them are read, and get what they lack."""
    for path in store.glob("*.h5"):
        with h5py.File(path, "a") as stored:
            for name in ("results/planes", "results/probes", "signal/tolerance"):
                if name in stored:
                    del stored[name]
    fronts = run("study", scene, "--store", store, "--set", "study.want=scaling")
    assert made_now(fronts.stderr) == 0 and tables(fronts.stdout)[0][2] == tables(text)[0][2]
    kept = run("study", scene, "--store", store, "--set", "study.want=signal", "--set", "signal.points=41", "--set",
               "signal.until=20")
    assert made_now(kept.stderr) == 0
    done = run("study", scene, "--store", store)
    assert made_now(done.stderr) == 12
    assert done.stdout == text


def values_of_no_sample(folder, store):
    """A file whose numbers no sample can have is left out by name, and the table is that of the others; a table
    without rows says why."""
    name = min(path.name for path in store.glob("*.h5"))
    with h5py.File(store / name) as stored:
        fronts = np.isfinite(stored["results/planes/t10"][()]).sum()
    rest = sum(column(tables(run("table", "planes", "--store", store).stdout)[0], "samples")) - fronts
    for dataset, value in (("planes/height", np.nan), ("planes/height", 1e9), ("planes/height", -1.0),
                           ("sample/pressure", np.nan), ("sample/width", -8.0), ("sample/dim", 7),
                           ("sample/grains", 0), ("sample/friction", np.inf), ("sample/height", -1.0)):
        other = folder / "forged"
        shutil.copytree(store, other)
        with h5py.File(other / name, "a") as stored:
            place = stored["results"][dataset]
            if dataset == "planes/height":
                place[0] = value
            else:
                place[...] = value
        for table in ("planes", "scaling"):
            done = run("table", table, "--store", other)
            assert names_all(done.stderr, "1") and dataset in done.stderr, (dataset, done.stderr)
            assert sum(column(tables(done.stdout)[0], "samples")) == (rest if table == "planes" else 11), done.stdout
        shutil.rmtree(other)
    outside = run("study", "--store", folder / "outside", "--set", "packing.grains=40", "--set", "packing.width=6",
                  "--set", "packing.tolerance=1e-7", "--set", "study.want=planes", "--set", "signal.planes=1000")
    assert "no row: none of 1 samples has a front at a plane inside" in outside.stdout, outside.stdout


def wrong_scenes(folder, scene):
    for args, reason in ((["--set", "study.want=planes"], "signal.planes"),
                         ([scene, "--set", "signal.planes=[]"], "signal.planes"),
                         ([scene, "--set", "packing.grains=100"], "packing.height"),
                         (["--set", "packing.height=10", "--set", "packing.kind=chain"], "packing.height"),
                         (["--set", "study.want=spectra"], "spectrum")):
        done = run("study", "--store", folder / "never", *args, status=2)
        assert names_all(done.stderr, reason) and not (folder / "never").exists(), done.stderr


with tempfile.TemporaryDirectory(prefix="sonopack-distance-") as name:
    folder = pathlib.Path(name)
    scene, store, text = an_ensemble(folder)
    print("an_ensemble ok")
    for test, arguments in ((the_same_by_grains, (scene, store)), (filters, (store,)),
                            (only_what_changes_is_made, (scene, store, text)),
                            (stores_without_newer_parts, (scene, store, text)), (values_of_no_sample, (folder, store)),
                            (wrong_scenes, (folder, scene))):
        test(*arguments)
        print(test.__name__, "ok")
