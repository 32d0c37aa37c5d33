"""False numbers in the samples of a store: `study --verify' computes each again and names it, and refuses no honest sample,
for any number of jobs; Ctrl-C stops it between samples.

usage: test_forged_samples.py COMMAND SOURCE_DIR
"""
import itertools
import pathlib
import shutil
import signal

import h5py
import numpy as np

from command import Table, main, run, sets, start, tried
from common import expect, names_all, wait_for_work
from forging import forge, numbers_of

ALL = 'study.want=["ctof","statics","moduli","signal","probes","planes","spectrum"]'
SCENES = {  # one sample each, with every part that it can have
    "disks": (ALL, "signal.planes=[3.0,5.0]", "signal.points=301", "packing.grains=60", "packing.width=8"),
    "spheres": ("packing.dimension=3", "packing.grains=150", "packing.width=4", "packing.diameter_min=0.95",
                "packing.diameter_max=1", 'study.want=["ctof","statics","moduli"]'),
    "chain": ('packing.kind="chain"', "packing.grains=9", 'study.want=["ctof","signal","spectrum"]'),
    "cell": ("packing.grains=50", "packing.width=8", "packing.cell=periodic", 'study.want=["statics","moduli","spectrum"]'),
    "prestress": ("packing.grains=60", "packing.width=8", "network.prestress=true", 'study.want=["statics","moduli","ctof"]'),
    "still": ('packing.kind="chain"', "packing.grains=30", "signal.until=40", "signal.points=41",
              'study.want=["signal"]'),  # it ends before the wave arrives
    "short": ("packing.grains=60", "packing.width=8", "packing.seed=5", "signal.until=30", "signal.points=51", "signal.method=verlet",
              "signal.tolerance=1e-3", 'study.want=["ctof","signal"]'),
}
# how it was computed may be told otherwise, within bounds; negative zeros are zeros
FREE = {"signal/products": "more zero", "signal/tolerance": "more nan minus zero", "signal/error": "more",
        "results/moduli/residual": "more minus zero",
        "results/moduli/bulk": "nan", "results/moduli/shear": "nan"}  # as of stores of older versions
SAMPLES = {}


def verify(store):
    """The rows by their file."""
    found = Table(tried("study", "--store", store, "--verify", "-q").stdout)
    return {row[0]: dict(zip(found.names, row)) for row in found.rows}


def honest():
    """No false alarm, and no byte changed."""
    for name, keys in SCENES.items():
        run("study", "-q", "--store", name, *sets("study.samples=1", *keys))
        (SAMPLES[name],) = pathlib.Path(name).glob("*.h5")
        before = SAMPLES[name].read_bytes()
        (row,) = verify(name).values()
        assert (row["ok"], row["field"]) == ("yes", "-"), (name, row)
        assert SAMPLES[name].read_bytes() == before


def false(forgeries):
    """A store of samples that are false, {scene: (what is done, the field at fault)}: each is told, and stays as it was,
    unless it cannot be read at all."""
    shutil.rmtree("false", ignore_errors=True)
    pathlib.Path("false").mkdir()
    cases = {}
    for scene, (change, field) in forgeries.items():
        path = pathlib.Path(shutil.copy(SAMPLES[scene], "false"))
        if change(path) is not False:
            cases[path] = scene, field, path.read_bytes()
        else:
            path.unlink()
    rows = verify("false") if cases else {}
    for path, (scene, field, before) in cases.items():
        row, now = rows[path.name], path if path.exists() else path.with_suffix(".bad")
        named = field is None or field in (row["field"], row["reason"]) or names_all(row["reason"], "/" + field.split("/")[1])
        expect(row["ok"] == "no" and now.read_bytes() == before and named, f"{scene}, {field}: {row}")
    return len(cases)


def every_number(more=False):
    """Of every part of every kind of sample: larger, none, negative, or zero. Of disks each is made larger, and every
    second one of the others as well; the ways take turns elsewhere. more: each in every way."""
    ways, work = ("more", "nan", "minus", "zero"), {}
    for scene, path in SAMPLES.items():
        cases = []
        for k, name in enumerate(numbers_of(path, "results", "signal")):
            turn = ways if more else (ways[k % 2],) if scene != "disks" else (ways[0], *ways[1 + k // 2 % 3:][:k % 2])
            cases += [(name, way) for way in turn
                      if way not in FREE.get(name, "").split() and (scene, name) != ("short", "signal/F")]
        work[scene] = cases
    total = 0
    for together in itertools.zip_longest(*work.values()):
        total += false({scene: (lambda path, one=one: forge(path, *one), "/" + one[0])
                        for scene, one in zip(work, together) if one})
    assert total > (300 if more else 200), total
    print(f"{total} false numbers")


# ---- what agrees with itself ---------------------------------------------------------------------------------------


def edit(change):
    def changed(path):
        with h5py.File(path, "r+") as file:
            change(file)
    return changed


def later(file):
    """A front that is later as a whole: all of its marks agree."""
    for mark in ("t10", "t_peak", "t_zero"):
        file["/results/front/" + mark][...] = file["/results/front/" + mark][()] + 3


def softer(file):
    """Another modulus, with the speed that follows from it."""
    for name, factor in (("c22", 0.9), ("c_l", np.sqrt(0.9))):
        file["/results/moduli/" + name][...] = factor * file["/results/moduli/" + name][()]


def swapped(file):
    """Two frequencies, moved such that their sum of squares stays."""
    omega = file["/results/spectrum/omega"][()]
    k = len(omega) // 2
    step = 0.1 * (omega[k + 1]**2 - omega[k]**2) + 1e-6 * omega[-1]**2
    omega[k], omega[k + 1] = np.sqrt(omega[k]**2 - step), np.sqrt(omega[k + 1]**2 + step)
    file["/results/spectrum/omega"][...] = np.sort(omega)


def text(path, old, new):
    def change(file):
        said = file[path][()].decode().rstrip("\0")
        assert old in said, (old, said)
        del file[path]
        said = said.replace(old, new, 1).encode()
        file.create_dataset(path, data=said, dtype=h5py.string_dtype("utf-8", len(said)))
    return change


def silent(file):
    file["/signal/F"][...] = 0


def loud(file):
    file["/signal/F"][...] = 1.5 * file["/signal/F"][()]


def as_a_whole():
    for change, field in ((later, "/results/front/t10"), (softer, "/results/moduli/c22"), (swapped, "/results/spectrum/omega"),
                          (silent, None), (text("/results/sample/scene", "friction = 0.5", "friction = 0.4"), None),
                          (text("/sonopack/scene", "friction = 0.5", "friction = 0.4"), "/sonopack/friction"),
                          (text("/signal/method", "chebyshev", "loud"), None)):
        assert false({"disks": (edit(change), field)}) == 1
    assert false({"short": (edit(loud), "/signal/F")}) == 1
    assert false({"chain": (lambda path: forge(path, "sonopack/seed", "more"), "/sonopack/seed")}) == 1


def many():
    """The same table for any number of jobs, and an end between two samples."""
    store, samples = pathlib.Path("many"), 6
    run("study", "-q", "--store", store, *sets(f"study.samples={samples}", 'study.want=["moduli","spectrum"]', grains=150,
                                               width=10))
    process = start("study", "--store", store, "--verify", "--jobs", "1",
                    preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
    wait_for_work(process, 0.05)
    process.send_signal(signal.SIGINT)
    out, said = process.communicate()
    assert process.returncode == 1 and names_all(said, samples) and out == "", (process.returncode, out, said)
    for path in sorted(store.glob("*.h5"))[::2]:
        assert forge(path, "results/moduli/c11", "more")
    found = {run("study", "-q", "--store", store, "--verify", "--jobs", jobs, status=1).stdout for jobs in (1, 2, 100)}
    assert len(found) == 1 and found.pop().count("/results/moduli/c11 =") == samples / 2
    assert not list(store.glob("*.bad"))


if __name__ == "__main__":
    main(honest, every_number, as_a_whole, many)
