"""The part spectrum of a store and its table: every frequency against a network that numpy builds from the packing, the
histogram's means and errors against numpy's, what is kept, made anew and refused.

usage: test_study_spectrum.py COMMAND SOURCE_DIR
"""
import pathlib
import shutil

import h5py
import numpy as np

from command import main, refused, run, sets, table, tables
from common import made_now, names_all
from network_oracle import Network

COLUMNS = ["omega", "low", "high", "density", "density_err", "density_low", "density_high", "cumulative",
           "cumulative_err"]


def study(store, *keys, samples=5, want=("spectrum",), options=(), **packing):
    words = ", ".join(f'"{word}"' for word in want)
    return run("study", "--store", store, *options, *sets(
        f"study.samples={samples}", f"study.want=[{words}]", *keys, **{"grains": 60, "width": 8, **packing}))


def spectrum(store, *words):
    return table("table", "spectrum", "--store", store, *words)


def stored(store):
    """Of every sample with frequencies: (omega, carrying grains)."""
    found = []
    for path in sorted(pathlib.Path(store).glob("*.h5")):
        with h5py.File(path) as file:
            if "results/spectrum" in file:
                found.append((file["results/spectrum/omega"][()], int(file["results/spectrum/carrying"][()])))
    return found


def content(store):
    return {path.name: path.read_bytes() for path in sorted(pathlib.Path(store).glob("*.h5"))}


def oracles(store, threshold=1e-4):
    """The network of every sample, by way of the packing as text, with what the file says of it."""
    for path in sorted(pathlib.Path(store).glob("*.h5")):
        with h5py.File(path) as file:
            group = {name: data[()] for name, data in file["results/spectrum"].items()}
            assert all(data.attrs["unit"] and data.attrs["description"] for data in file["results/spectrum"].values())
        run("convert", path, "packing.txt", "--force")
        yield Network("packing.txt", threshold=threshold), group


def frequencies():
    """Each sample's own, by a dense eigensolver from its packing file; and nothing else was computed."""
    printed = study("store")
    for network, group in oracles("store"):
        omega, expected = group["omega"], np.sort(network.frequencies())
        assert set(group) == {"omega", "carrying", "dof", "zero_modes", "omega_max"}
        assert group["dof"] == 3 and group["carrying"] == 60 - network.rattlers and group["omega_max"] == omega.max()
        assert group["zero_modes"] == np.count_nonzero(omega == 0) and np.all(np.diff(omega) >= 0)
        assert len(omega) == len(expected) and np.all(abs(omega - expected) < 1e-10 * expected)
    assert any(len(omega) < 180 for omega, _ in stored("store")), "no sample with a rattler"
    assert tables(printed.stdout)[0].body == spectrum("store").body


def check_histogram(found, samples):
    """Means over the samples of modes in (low, high] for each grain and unit of omega. Returns the densities."""
    low, high, n = found["low"], found["high"], len(samples)
    assert np.array_equal(low[1:], high[:-1]) and low[0] == 0
    counts = np.array([[np.count_nonzero((omega > a) & (omega <= b)) for a, b in zip(low, high)] for omega, _ in samples])
    grains = np.array([[carrying] for _, carrying in samples])
    density, cumulative = counts / grains / (high - low), counts.cumsum(axis=1) / grains
    for name, x in (("density", density), ("cumulative", cumulative)):
        scale, error = abs(x).max(), x.std(axis=0, ddof=1) / n**0.5 if n > 1 else np.full(len(low), np.nan)
        assert np.allclose(found[name], x.mean(axis=0), rtol=1e-13, atol=1e-14 * scale), name
        assert np.allclose(found[f"{name}_err"], error, rtol=1e-12, atol=1e-14 * scale, equal_nan=True), name
    zeros = np.mean([np.count_nonzero(omega == 0) for omega, _ in samples])
    assert found.note("samples") == n and found.note("omega_max") == max(omega.max() for omega, _ in samples)
    assert abs(found.note("mean_carrying") - grains.mean()) < 1e-12 * grains.mean() and abs(found.note("mean_zero_modes") - zeros) < 1e-12
    if high[-1] >= found.note("omega_max"):  # all modes are there: with the zero modes the degrees of freedom of a grain
        assert abs(found["cumulative"][-1] + found.note("mean_zero_modes_per_grain") - found.note("dof")) < 1e-12
    return density


def histograms():
    samples, found = stored("store"), spectrum("store")
    default, until, largest = sum(len(omega) for omega, _ in samples) // 20, found["high"][-1], found.note("omega_max")
    assert found.names == COLUMNS and len(found) == default and 20 < default < 100
    assert largest <= until < 1.1 * largest and until == float(f"{until:.1e}")
    mean = check_histogram(found, samples).mean(axis=0)
    low, high, full = found["density_low"], found["density_high"], mean > 0
    assert np.all(low[full] <= mean[full] + 1e-12) and np.all(high[full] >= mean[full] - 1e-12)
    # where no sample has a mode nothing is known of the scatter
    assert np.array_equal(np.isnan(low), ~full) and np.array_equal(np.isnan(high), ~full)
    for words in (("--bins", "7"), ("--omega-max", "0.5"), ("--bins", "40", "--omega-max", "3.7")):
        found, given = spectrum("store", *words), dict(zip(words[::2], words[1::2]))
        check_histogram(found, samples)
        assert len(found) == int(given.get("--bins", default)) and found["high"][-1] == float(given.get("--omega-max", until))
    # the same as of one packing
    path = sorted(pathlib.Path("store").glob("*.h5"))[0]
    one, (omega, carrying) = table("spectrum", "dos", path, "--method", "exact", "--bins", 40, "--omega-max", 1.5), samples[0]
    counts, _ = np.histogram(omega, bins=np.linspace(0, 1.5, 41))
    assert np.allclose(one["density"], counts / carrying / (1.5 / 40), rtol=1e-12)


def zero_modes():
    """Of a network without its weak contacts: told, and in no bin."""
    study("floppy", "network.threshold=1", samples=3)
    zeros = []
    for network, group in oracles("floppy", threshold=1):
        zeros.append(np.count_nonzero(network.squares < 1e-12))
        omega, expected = group["omega"], np.sort(network.frequencies())
        assert group["carrying"] == 60 - network.rattlers and group["zero_modes"] == zeros[-1] == np.count_nonzero(omega == 0)
        assert np.allclose(omega[zeros[-1]:], expected[zeros[-1]:], rtol=1e-10, atol=0)
    assert max(zeros) > 0
    check_histogram(spectrum("floppy"), stored("floppy"))
    study("chain", samples=1, kind="chain", friction=0, grains=50)  # other dimensions have other degrees of freedom
    check_histogram(spectrum("chain", "--bins", 20), stored("chain"))


def intervals():
    """Of two samples Student's interval for one degree of freedom, of few bins and of more than are resampled at once; of
    one none."""
    study("two", samples=2)
    for bins in (10, 4000):
        found = spectrum("two", "--bins", bins)
        density = check_histogram(found, stored("two"))
        half = 12.706204736 * abs(density[0] - density[1]) / 2
        half[density.sum(axis=0) == 0] = np.nan
        for name, end in (("density_high", density.mean(axis=0) + half), ("density_low", density.mean(axis=0) - half)):
            assert np.allclose(found[name], end, rtol=1e-9, atol=1e-9 * density.max(), equal_nan=True), (name, bins)
    study("one", samples=1)
    found = spectrum("one")
    check_histogram(found, stored("one"))
    assert len(found) == 20 and all(np.isnan(found[name]).all() for name in ("density_err", "density_low", "cumulative_err"))


def other_parts_join():
    """Frequencies stay, bit for bit, when other parts are added; and they join what is there."""
    keys = "signal.until=40", "signal.points=41"
    text = run("table", "spectrum", "--store", "store").stdout
    shutil.copytree("store", "joined")
    assert made_now(study("joined", want=("statics",)).stderr) == 5
    study("joined", *keys, want=("signal", "moduli"))
    assert run("table", "spectrum", "--store", "joined").stdout == text
    assert made_now(study("joined", want=("spectrum", "statics")).stderr) == 0
    study("later", *keys, want=("signal", "moduli"))  # the other way round: the signals stay
    signals = run("table", "signal", "--store", "later").stdout
    assert "without_spectrum = 5 " in run("table", "spectrum", "--store", "later").stdout
    assert made_now(study("later", *keys, want=("signal", "spectrum")).stderr) == 5
    assert run("table", "spectrum", "--store", "later").stdout == text
    assert run("table", "signal", "--store", "later").stdout == signals


def resumed():
    """Whatever was there before, lost or not, in any number of threads: the same bytes."""
    for jobs in (1, 2):
        place = f"jobs{jobs}"
        study(place, samples=2, options=("--jobs", jobs))
        assert made_now(study(place, options=("--jobs", jobs)).stderr) == 3 and content(place) == content("store")
    lost = sorted(pathlib.Path(place).glob("*.h5"))
    lost[0].unlink()
    lost[1].write_bytes(lost[1].read_bytes()[:-3000])
    with h5py.File(lost[2], "r+") as file:  # frequencies of another network cannot be read
        file["results/spectrum/carrying"][...] -= 1
    assert made_now(study(place).stderr) == 3 and content(place) == content("store")


def unlike_samples():
    shutil.copytree("store", "mixed")
    for keys in ({"pressure": 1e-5}, {"grains": 80}, {"friction": 0}):
        study("mixed", samples=2, **keys)
    words = ["table", "spectrum", "--store", "mixed"]
    for names, choice in (("--pressure", []), ("--grains", ["--pressure", "1e-4"]), ("friction", ["--pressure=1e-4", "--grains=60"])):
        refused(names, *words, *choice, status=1)
    assert spectrum("mixed", "--pressure=1e-4", "--grains=60", "--friction=0.5").body == spectrum("store").body


def too_large():
    """A network that the dense solver refuses lacks the part; what else is wanted is there."""
    chain = {"samples": 1, "want": ("statics", "spectrum"), "kind": "chain", "friction": 0, "grains": 20100}
    assert names_all(study("large", **chain).stderr, "1")
    assert "20000" in table("table", "ensemble", "--store", "large").words("reason")[0]
    with h5py.File(next(pathlib.Path("large").glob("*.h5"))) as file:
        assert file["results/sample/lacks"][()] == 128 and "statics" in file["results"]
    assert made_now(study("large", **chain).stderr) == 0  # it is known
    assert "20000" in run("table", "spectrum", "--store", "large").stdout


def sweeps():
    """A swept key is a table each, of signals too; the filter takes one."""
    pathlib.Path("sweep.cfg").write_text('packing = { grains = 60; width = 8; pressure = [1e-5, 1e-4]; };'
                                         'signal = { until = 40; points = 41; };'
                                         'study = { samples = 2; want = ["ctof", "spectrum", "signal"]; };')
    printed = tables(run("study", "sweep.cfg", "--store", "sweep").stdout)
    words = ["table", "spectrum", "sweep.cfg", "--store", "sweep"]
    two = tables(run(*words).stdout)
    assert [t.names[0] for t in printed] == ["p", "omega", "omega"] and [t.body for t in two] == [t.body for t in printed[1:]]
    assert [t.note("packing.pressure") for t in two] == [1e-5, 1e-4]
    assert table(*words, "--pressure", "1e-4").body == two[1].body
    run(*words, "-o", "out.tsv")
    assert pathlib.Path("out.tsv").read_text() + "\n" + pathlib.Path("out-spectrum-2.tsv").read_text() == run(*words).stdout
    assert [len(t) for t in tables(run("table", "signal", "sweep.cfg", "--store", "sweep").stdout)] == [41, 41]


main(frequencies, histograms, zero_modes, intervals, other_parts_join, resumed, unlike_samples, too_large, sweeps, begun=True)
