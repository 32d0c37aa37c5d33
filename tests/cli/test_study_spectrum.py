"""The part spectrum of a store and its table: every frequency against a network that numpy builds from the packing, the
histogram's means and errors against numpy's and what is kept, made anew and refused.

usage: test_study_spectrum.py COMMAND SOURCE_DIR
"""
import pathlib
import shutil
import tempfile

import h5py
import numpy as np

from network_oracle import Network
from common import made_now, names_all
from streams import column, comment, run, tables

PACKING = ["packing.grains=60", "packing.width=8"]
COLUMNS = ["omega", "low", "high", "density", "density_err", "density_low", "density_high", "cumulative",
           "cumulative_err"]


def study(store, *settings, samples=5, want=("spectrum",), options=(), keys=PACKING):
    words = ", ".join(f'"{word}"' for word in want)
    keys = [*keys, f"study.samples={samples}", f"study.want=[{words}]", *settings]
    return run("study", "--store", store, *options, *(word for key in keys for word in ("--set", key)))


def spectrum(store, *args):
    (table,) = tables(run("table", "spectrum", "--store", store, *args).stdout)
    return table


def stored(store):
    """Of every sample with frequencies: (omega, carrying grains)."""
    found = []
    for path in sorted(store.glob("*.h5")):
        with h5py.File(path) as file:
            if "results/spectrum" in file:
                found.append((file["results/spectrum/omega"][()], int(file["results/spectrum/carrying"][()])))
    return found


def parts(store):
    lines = [line.split("\t") for line in (store / "manifest.tsv").read_text().splitlines() if line[0] != "#"]
    last = {line[0]: line for line in lines[1:]}
    return [int(line[lines[0].index("parts")]) for line in last.values()]


def content(store):
    return {path.name: path.read_bytes() for path in sorted(store.glob("*.h5"))}


def frequencies(folder, store):
    """Each sample's own, by a dense eigensolver from its packing file; and nothing else was computed."""
    printed = study(store)
    assert parts(store) == [128] * 5
    for path in sorted(store.glob("*.h5")):
        run("convert", path, folder / "packing.txt", "--force")
        network = Network(folder / "packing.txt")
        with h5py.File(path) as file:
            assert set(file["results"]) == {"sample", "spectrum"} and "signal" not in file
            group = file["results/spectrum"]
            assert set(group) == {"omega", "carrying", "dof", "zero_modes", "omega_max"}
            for name, data in group.items():
                assert data.attrs["unit"] and data.attrs["description"], name
            assert group["omega"].attrs["unit"] in ("sqrt(E* / rho) / d", b"sqrt(E* / rho) / d")
            omega = group["omega"][()]
            assert group["dof"][()] == 3 and group["carrying"][()] == 60 - network.rattlers
            assert group["zero_modes"][()] == np.count_nonzero(omega == 0)
            assert group["omega_max"][()] == omega.max() and np.all(np.diff(omega) >= 0)
        expected = np.sort(network.frequencies())
        assert len(omega) == len(expected) == 3 * (60 - network.rattlers)
        off = abs(omega - expected) / expected
        assert off.max() < 1e-10, off.max()
    assert any(len(omega) < 180 for omega, _ in stored(store)), "no sample with a rattler"
    # the study printed the table
    assert tables(printed.stdout)[0][1:] == spectrum(store)[1:]


def check_histogram(table, samples):
    """Means over the samples of modes in (low, high] for each grain and unit of omega."""
    low, high = column(table, "low"), column(table, "high")
    assert np.array_equal(low[1:], high[:-1]) and low[0] == 0
    n = len(samples)
    counts = np.array([[np.count_nonzero((omega > a) & (omega <= b)) for a, b in zip(low, high)] for omega, _ in samples])
    grains = np.array([[carrying] for _, carrying in samples])
    density, cumulative = counts / grains / (high - low), counts.cumsum(axis=1) / grains
    for name, x in (("density", density), ("cumulative", cumulative)):
        scale = abs(x).max()
        assert np.allclose(column(table, name), x.mean(axis=0), rtol=1e-13, atol=1e-14 * scale), name
        error = x.std(axis=0, ddof=1) / n ** 0.5 if n > 1 else np.full(len(low), np.nan)
        assert np.allclose(column(table, f"{name}_err"), error, rtol=1e-12, atol=1e-14 * scale, equal_nan=True), name
    assert comment(table, "samples") == str(n)
    assert float(comment(table, "omega_max")) == max(omega.max() for omega, _ in samples)
    assert abs(float(comment(table, "mean_carrying")) - grains.mean()) < 1e-12 * grains.mean()
    zeros = np.mean([np.count_nonzero(omega == 0) for omega, _ in samples])
    assert abs(float(comment(table, "mean_zero_modes")) - zeros) < 1e-12
    return density


def histograms(store):
    samples = stored(store)
    table = spectrum(store)
    default = sum(len(omega) for omega, _ in samples) // 20
    assert table[1] == COLUMNS and len(table[2]) == default and 20 < default < 100
    density = check_histogram(table, samples)
    # all modes are there: the integral and the zero modes are the degrees of freedom of a grain
    zeros = float(comment(table, "mean_zero_modes_per_grain"))
    assert abs(column(table, "cumulative")[-1] + zeros - 3) < 1e-12
    until = column(table, "high")[-1]
    largest = float(comment(table, "omega_max"))
    assert largest <= until < 1.1 * largest and until == float(f"{until:.1e}")
    mean, low, high = density.mean(axis=0), column(table, "density_low"), column(table, "density_high")
    full = mean > 0
    assert np.all(low[full] <= mean[full] + 1e-12) and np.all(high[full] >= mean[full] - 1e-12)
    # where no sample has a mode nothing is known of the scatter
    assert np.array_equal(np.isnan(low), ~full) and np.array_equal(np.isnan(high), ~full)
    (table,) = tables(run("table", "spectrum", "--store", store, "--omega-max", "4", "--bins", "50").stdout)
    empty = column(table, "density") == 0
    assert empty.sum() > 20 and np.array_equal(np.isnan(column(table, "density_high")), empty)
    assert np.array_equal(column(table, "density_err")[empty], np.zeros(empty.sum()))
    for args in (("--bins", "7"), ("--bins", "1"), ("--omega-max", "0.5"), ("--bins", "40", "--omega-max", "3.7")):
        table = spectrum(store, *args)
        check_histogram(table, samples)
        options = dict(zip(args[::2], args[1::2]))
        assert len(table[2]) == int(options.get("--bins", default))
        assert column(table, "high")[-1] == float(options.get("--omega-max", until))
    assert column(spectrum(store, "--omega-max", "0.5"), "cumulative")[-1] < 2.5  # modes above are not in it
    # the same as of one packing
    path = sorted(store.glob("*.h5"))[0]
    (one,) = tables(run("spectrum", "dos", path, "--method", "exact", "--bins", "40", "--omega-max", "1.5").stdout)
    omega, carrying = stored(store)[0]
    counts, _ = np.histogram(omega, bins=np.linspace(0, 1.5, 41))
    assert np.allclose(column(one, "density"), counts / carrying / (1.5 / 40), rtol=1e-12)


def zero_modes(folder):
    """Of a network without its weak contacts: told, and in no bin."""
    store = folder / "floppy"
    study(store, "network.threshold=1", samples=3)
    zeros = []
    for path, (omega, carrying) in zip(sorted(store.glob("*.h5")), stored(store)):
        run("convert", path, folder / "packing.txt", "--force")
        network = Network(folder / "packing.txt", threshold=1)
        zeros.append(np.count_nonzero(network.squares < 1e-12))
        assert carrying == 60 - network.rattlers and np.all(omega[:zeros[-1]] == 0) and omega[zeros[-1]] > 0
        assert np.allclose(omega[zeros[-1]:], np.sort(network.frequencies())[zeros[-1]:], rtol=1e-10, atol=0)
    assert max(zeros) > 0
    table = spectrum(store)
    check_histogram(table, stored(store))
    assert float(comment(table, "mean_zero_modes")) == np.mean(zeros)
    assert abs(column(table, "cumulative")[-1] + float(comment(table, "mean_zero_modes_per_grain")) - 3) < 1e-12
    assert names_all(run("study", "--store", store, "--verify").stderr, "3")


def intervals(folder):
    """Of two samples Student's interval for one degree of freedom; of one none."""
    store = folder / "two"
    study(store, samples=2)
    table = spectrum(store, "--bins", "10")
    density = check_histogram(table, stored(store))
    half = 12.706204736 * abs(density[0] - density[1]) / 2
    half[density.sum(axis=0) == 0] = np.nan
    for name, end in (("density_high", density.mean(axis=0) + half), ("density_low", density.mean(axis=0) - half)):
        assert np.allclose(column(table, name), end, rtol=1e-9, atol=1e-9, equal_nan=True), name
    wide = spectrum(store, "--bins", "10", "--interval", "0.99")
    assert any("at level 0.99," in line for line in wide[0])
    differ = half > 0
    assert differ.any()
    assert np.all(column(wide, "density_high")[differ] > column(table, "density_high")[differ])
    # more bins than are resampled at once: the same as of a few
    many = spectrum(store, "--bins", "4000")
    density = check_histogram(many, stored(store))
    half = 12.706204736 * abs(density[0] - density[1]) / 2
    half[density.sum(axis=0) == 0] = np.nan
    assert np.allclose(column(many, "density_high"), density.mean(axis=0) + half, rtol=1e-9,
                       atol=1e-9 * density.max(), equal_nan=True)
    shutil.rmtree(store)
    study(store, samples=1)
    table = spectrum(store)
    check_histogram(table, stored(store))
    assert len(table[2]) == 20  # the least
    for name in ("density_err", "density_low", "density_high", "cumulative_err"):
        assert np.all(np.isnan(column(table, name)))


def other_parts_join(folder, store):
    """Frequencies stay, bit for bit, when other parts are added; and they join what is there."""
    place, before, text = folder / "joined", stored(store), run("table", "spectrum", "--store", store).stdout
    shutil.copytree(store, place)
    done = study(place, want=("statics",))
    assert made_now(done.stderr) == 5 and parts(place) == [130] * 5
    study(place, "signal.until=40", "signal.points=41", want=("signal", "moduli"))
    assert parts(place) == [128 + 8 + 4 + 2] * 5
    assert all(np.array_equal(a, b) and n == m for (a, n), (b, m) in zip(stored(place), before))
    assert run("table", "spectrum", "--store", place).stdout == text
    done = study(place, want=("spectrum", "statics"))
    assert made_now(done.stderr) == 0
    # the other way round: the signals stay
    other = folder / "later"
    study(other, "signal.until=40", "signal.points=41", want=("signal", "moduli"))
    signals = run("table", "signal", "--store", other).stdout
    assert run("table", "spectrum", "--store", other).stdout.count("without_spectrum = 5 ") == 1
    done = study(other, "signal.until=40", "signal.points=41", want=("signal", "spectrum"))
    assert made_now(done.stderr) == 5 and parts(other) == [128 + 8 + 4 + 2] * 5
    assert run("table", "spectrum", "--store", other).stdout == text
    assert run("table", "signal", "--store", other).stdout == signals


def resumed(folder, store):
    """Whatever was there before, lost or not, in any number of threads: the same bytes."""
    whole, text = content(store), run("table", "spectrum", "--store", store).stdout
    for jobs in (1, 2):
        place = folder / f"jobs{jobs}"
        study(place, samples=2, options=("--jobs", jobs))
        done = study(place, options=("--jobs", jobs))
        assert made_now(done.stderr) == 3
        assert content(place) == whole and run("table", "spectrum", "--store", place).stdout == text
    lost = sorted(place.glob("*.h5"))
    lost[0].unlink()
    lost[1].write_bytes(whole[lost[1].name][:-3000])
    done = study(place)
    assert made_now(done.stderr) == 2
    assert content(place) == whole and run("table", "spectrum", "--store", place).stdout == text


def change(path, name, value):
    with h5py.File(path, "r+") as file:
        data = np.array(file[f"results/spectrum/{name}"][()])
        file[f"results/spectrum/{name}"][...] = value(data)


def swap(omega):
    omega[[3, 90]] = omega[[90, 3]]
    return omega


def put(place, value):
    def changed(omega):
        omega[place] = value
        return omega
    return changed


def verified(folder, store):
    assert names_all(run("study", "--store", store, "--verify").stderr, "5")
    place = folder / "faulty"
    shutil.copytree(store, place)
    name = sorted(content(place))
    faults = (("omega", put(7, np.nan)), ("omega", put(0, -1e-3)), ("omega", swap), ("omega", put(-1, np.inf)),
              ("zero_modes", lambda x: x + 1))
    for one, (dataset, fault) in zip(name, faults):
        change(place / one, dataset, fault)
    done = run("study", "--store", place, "--verify", status=1)
    ((_, _, rows),) = tables(done.stdout)
    assert [row[:2] for row in rows] == [[one, "no"] for one in name], rows
    assert all("/results/spectrum" in row[2] for row in rows), rows
    assert sorted(content(place)) == name  # they read well, and stay
    # frequencies of another network cannot be read; they are put aside, and made anew
    shutil.rmtree(place)
    shutil.copytree(store, place)
    change(place / name[2], "carrying", lambda x: x - 1)
    done = run("study", "--store", place, "--verify", status=1)
    assert names_all(done.stderr, ".bad") and sorted(content(place)) == name[:2] + name[3:]
    study(place)
    assert content(place) == content(store)


def refused(folder, store):
    place = folder / "mixed"
    shutil.copytree(store, place)
    study(place, "packing.pressure=1e-5", samples=2)
    study(place, "packing.grains=80", samples=2)
    study(place, "packing.friction=0", samples=2)
    assert names_all(run("table", "spectrum", "--store", place, status=1).stderr, "--pressure")
    done = run("table", "spectrum", "--store", place, "--pressure", "1e-4", status=1)
    assert names_all(done.stderr, "--grains") and not done.stdout
    done = run("table", "spectrum", "--store", place, "--pressure", "1e-4", "--grains", "60", status=1)
    assert names_all(done.stderr, "friction")
    one = spectrum(place, "--pressure", "1e-4", "--grains", "60", "--friction", "0.5")
    assert one[1:] == spectrum(store)[1:]
    for args, word in ((("--bins", "0"), "--bins"), (("--bins", "x"), "--bins"), (("--omega-max", "-1"), "--omega-max"),
                       (("--bins", "10001"), "10000")):
        assert names_all(run("table", "spectrum", "--store", store, *args, status=2).stderr, word)
    assert names_all(run("table", "ctof", "--store", store, "--bins", "3", status=2).stderr, "--bins")
    assert names_all(run("study", "--store", place, "--set", 'study.want=["spectra"]', status=2).stderr, "spectrum")
    # a store without frequencies, and one with some
    study(folder / "statics", want=("statics",), samples=3)
    table = spectrum(folder / "statics")
    assert table[2] == [] and comment(table, "samples") == "0"
    assert any("none of 3 samples has a stored spectrum" in line for line in table[0]), table[0]
    study(folder / "statics", samples=2)
    table = spectrum(folder / "statics")
    assert comment(table, "samples") == "2" and comment(table, "without_spectrum").startswith("1 ")


def too_large(folder):
    """A network that the dense solver refuses lacks the part; what else is wanted is there."""
    store = folder / "large"
    chain = ['packing.kind="chain"', "packing.friction=0", "packing.grains=20100"]
    done = study(store, samples=1, want=("statics", "spectrum"), keys=chain)
    assert names_all(done.stderr, "1")
    (table,) = tables(run("table", "ensemble", "--store", store).stdout)
    assert "20000" in table[2][0][table[1].index("reason")], table[2]
    with h5py.File(next(store.glob("*.h5"))) as file:
        assert file["results/sample/lacks"][()] == 128 and "statics" in file["results"]
    assert "128 spectrum" in str(h5py.File(next(store.glob("*.h5")))["results/sample/lacks"].attrs["description"])
    done = study(store, samples=1, want=("statics", "spectrum"), keys=chain)
    assert made_now(done.stderr) == 0  # it is known
    table = spectrum(store)
    assert table[2] == [] and any("20000" in line for line in table[0])


def chains(folder):
    """Other dimensions have other degrees of freedom; the zero modes of a frictionless chain's turns are none of its
    network."""
    store = folder / "chain"
    study(store, samples=1, keys=['packing.kind="chain"', "packing.friction=0", "packing.grains=50"])
    table = spectrum(store, "--bins", "20")
    check_histogram(table, stored(store))
    dof = int(comment(table, "dof"))
    assert dof == len(stored(store)[0][0]) // 50
    assert abs(column(table, "cumulative")[-1] + float(comment(table, "mean_zero_modes_per_grain")) - dof) < 1e-12


def sweeps(folder):
    """A swept key is a table each, of signals too; the filter takes one."""
    scene, store, out = folder / "sweep.cfg", folder / "sweep", folder / "out.tsv"
    scene.write_text('packing = { grains = 60; width = 8; pressure = [1e-5, 1e-4]; };'
                     'signal = { until = 40; points = 41; };'
                     'study = { samples = 2; want = ["ctof", "spectrum", "signal"]; };')
    printed = tables(run("study", scene, "--store", store).stdout)
    assert [table[1][0] for table in printed] == ["p", "omega", "omega"]
    two = tables(run("table", "spectrum", scene, "--store", store).stdout)
    assert [table[1:] for table in two] == [table[1:] for table in printed[1:]]
    assert [float(comment(table, "packing.pressure")) for table in two] == [1e-5, 1e-4]
    for table, pressure in zip(two, ("1e-5", "1e-4")):
        (chosen,) = tables(run("table", "spectrum", scene, "--store", store, "--pressure", pressure).stdout)
        assert chosen[2] == table[2] and comment(chosen, "samples") == "2"
        run("table", "spectrum", scene, "--store", store, "--pressure", pressure, "-o", out, "--force")
        assert tables(out.read_text())[0][2] == table[2] and not (folder / "out-spectrum-2.tsv").exists()
    run("table", "spectrum", scene, "--store", store, "-o", out, "--force")
    assert tables((folder / "out-spectrum-2.tsv").read_text())[0][2] == two[1][2]
    signals = tables(run("table", "signal", scene, "--store", store).stdout)
    assert [len(table[2]) for table in signals] == [41, 41]


with tempfile.TemporaryDirectory(prefix="sonopack-spectra-") as name:
    folder = pathlib.Path(name)
    store = folder / "store"
    for test, arguments in ((frequencies, (folder, store)), (histograms, (store,)), (zero_modes, (folder,)),
                            (intervals, (folder,)), (other_parts_join, (folder, store)), (resumed, (folder, store)),
                            (verified, (folder, store)), (refused, (folder, store)), (too_large, (folder,)),
                            (chains, (folder,)), (sweeps, (folder,))):
        test(*arguments)
        print(test.__name__, "ok", flush=True)
