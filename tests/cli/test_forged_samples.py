"""False numbers in the samples of a store: `study --verify` names each, and refuses no honest sample, for any number of
jobs; Ctrl-C stops it between samples.

usage: test_forged_samples.py COMMAND
"""
import pathlib
import shutil
import signal
import subprocess
import tempfile

import h5py
import numpy as np

from common import expect, faults, names_all, wait_for_work
from streams import COMMAND, run, tables

SCENES = {  # one sample each, with every part that it can have
    "disks": ("packing.grains=110", "packing.width=8", "signal.planes=[3.0,5.0]",
              'study.want=["ctof","statics","moduli","signal","probes","planes","spectrum"]'),
    "spheres": ("packing.dimension=3", "packing.grains=150", "packing.width=4", "packing.diameter_min=0.95",
                "packing.diameter_max=1", 'study.want=["ctof","statics","moduli"]'),
    "chain": ('packing.kind="chain"', "packing.grains=9", 'study.want=["ctof","signal","spectrum"]'),
    "cell": ("packing.grains=50", "packing.width=8", "packing.cell=periodic",
             'study.want=["statics","moduli","spectrum"]'),
    "prestress": ("packing.grains=60", "packing.width=8", "network.prestress=true",
                  'study.want=["statics","moduli","ctof"]'),
    "still": ('packing.kind="chain"', "packing.grains=30", "signal.until=40", "signal.points=41",
              'study.want=["signal"]'),  # it ends before the wave arrives
    "short": ("packing.grains=60", "packing.width=8", "signal.until=30", "signal.points=51", "signal.method=verlet",
              "signal.tolerance=1e-3", 'study.want=["ctof","signal"]'),
}


def make(folder):
    for name, sets in SCENES.items():
        run("study", "-q", "--store", folder / name, "--set", "study.samples=1",
            *(word for s in sets for word in ("--set", s)))


# ---- forgeries ------------------------------------------------------------------------------------------------------

def put(path, change):
    """The number times, plus, or in place of another."""
    def forge(file):
        data = file[path][()]
        file[path][...] = change(data)
    return forge


def to(path, value):
    return put(path, lambda old: np.full_like(old, value))


def times(path, factor):
    return put(path, lambda old: old * factor)


def entry(path, k, change):
    def forge(file):
        data = file[path][()]
        data[k] = change(data[k])
        file[path][...] = data
    return forge


def text(path, old, new):
    def forge(file):
        said = file[path][()].decode().rstrip("\\0")
        assert old in said, (old, said)
        del file[path]
        said = said.replace(old, new, 1).encode()
        file.create_dataset(path, data=said, dtype=h5py.string_dtype("utf-8", len(said)))
    return forge


def kind(number):
    def forge(file):
        file[OF + "kind"] = np.int32(number)  # absent under a piston
    return forge


def later(file):
    """A front that is later as a whole: all of its marks agree."""
    for mark in ("t10", "t_peak", "t_zero"):
        file["/results/front/" + mark][...] = file["/results/front/" + mark][()] + 3


def softer(file):
    """Another modulus, with the speed that follows from it."""
    file["/results/moduli/c22"][...] = 0.9 * file["/results/moduli/c22"][()]
    file["/results/moduli/c_l"][...] = np.sqrt(0.9) * file["/results/moduli/c_l"][()]


def swap(file):
    """Two frequencies, moved such that their sum of squares stays."""
    omega = file["/results/spectrum/omega"][()]
    k = len(omega) // 2
    step = 0.1 * (omega[k + 1]**2 - omega[k]**2) + 1e-6 * omega[-1]**2
    omega[k], omega[k + 1] = np.sqrt(omega[k]**2 - step), np.sqrt(omega[k + 1]**2 + step)
    file["/results/spectrum/omega"][...] = np.sort(omega)


F, S, M, P, W, L = (f"/results/{part}/" for part in ("front", "statics", "moduli", "probes", "spectrum", "planes"))
OF = "/results/sample/"

# (the scene, what is done, the field at fault)
FORGED = [
    # values that cannot be
    ("disks", to(F + "t10", -3), F + "t10"),
    ("disks", to(F + "t10", 0), F + "t10"),
    ("disks", to(F + "t10", np.nan), F + "t10"),
    ("disks", times(F + "t10", 3), F + "t10"),
    ("disks", to(F + "t_peak", np.inf), F + "t_peak"),
    ("disks", to(F + "t_peak", 1e9), F + "t_peak"),
    ("disks", to(F + "t_zero", 1), F + "t_zero"),
    ("disks", to(F + "amplitude", -1e-3), F + "amplitude"),
    ("disks", to(F + "amplitude", np.nan), F + "amplitude"),
    ("disks", times(F + "width", 2), F + "width"),
    ("disks", to(F + "width", -1), F + "width"),
    ("chain", to(F + "t10", -1e-9), F + "t10"),
    ("disks", to(S + "phi2", -0.1), S + "phi2"),
    ("disks", to(S + "phi3s", 7), S + "phi3s"),
    ("disks", to(S + "zs", 30), S + "zs"),
    ("disks", to(S + "f0", 101), S + "f0"),
    ("disks", to(S + "z2", 0.5), S + "z2"),
    ("disks", to(S + "f2", 1.5), S + "f2"),
    ("disks", to(S + "mobilised", 2), S + "mobilised"),
    ("disks", to(S + "s_yy", np.inf), S + "s_yy"),
    ("disks", to(M + "c_l", -0.1), M + "c_l"),
    ("disks", times(M + "c_l", 1.001), M + "c_l"),
    ("disks", times(M + "c_t", 1.001), M + "c_t"),
    ("spheres", times(M + "c_t", 1.001), M + "c_t"),
    ("spheres", times(M + "c33", 0.99), M + "c33"),
    ("disks", to(M + "c22", -1), M + "c22"),
    ("disks", to(M + "c33", np.inf), M + "c33"),
    ("disks", to(M + "residual", -1), M + "residual"),
    ("disks", to(M + "residual", np.nan), M + "residual"),
    ("disks", to(P + "along_sine_1", np.inf), P + "along_sine_1"),
    ("disks", to(P + "left_out_sine_1", 3), P + "left_out_sine_1"),
    ("disks", entry(L + "t10", 0, lambda t: -t), L + "t10"),
    ("disks", entry(L + "amplitude", 0, lambda a: -1), L + "amplitude"),
    ("disks", to(W + "zero_modes", -4), W + "zero_modes"),
    ("disks", to(W + "omega_max", np.nan), W + "omega_max"),
    ("disks", kind(9), None),
    # at odds with the rest of the file
    ("disks", times(OF + "pressure", 2), OF + "pressure"),
    ("disks", to(OF + "friction", 0.1), OF + "friction"),
    ("disks", to(OF + "seed", 77), OF + "seed"),
    ("disks", to(OF + "width", 9), OF + "width"),
    ("disks", to(OF + "height", 9), OF + "height"),
    ("disks", kind(1), OF + "kind"),
    ("disks", put(OF + "material", lambda m: m + np.uint64(1)), OF + "material"),
    ("disks", text(OF + "scene", "friction = 0.5", "friction = 0.4"), None),
    ("disks", text("/sonopack/scene", "friction = 0.5", "friction = 0.4"), "/sonopack/friction"),
    ("disks", to("/sonopack/seed", 77), "/sonopack/seed"),
    ("disks", times(S + "phi2", 1.001), S + "phi2"),
    ("disks", times(S + "zs", 0.99), S + "zs"),
    ("disks", times(S + "n_over_p", 1.001), S + "n_over_p"),
    ("disks", times(S + "s_xx", 1.001), S + "s_xx"),
    ("spheres", times(S + "s32_over_s2", 1.01), S + "s32_over_s2"),
    ("cell", times(S + "f0", 0.5), S + "f0"),
    ("disks", to(M + "c11", -1e-4), M + "c11"),
    ("disks", to(P + "shear_sine_2", -1e-4), P + "shear_sine_2"),
    ("disks", entry(W + "omega", 40, lambda o: 1.0001 * o), W + "omega"),
    ("disks", entry(W + "omega", 40, lambda o: 0 * o), W + "omega"),
    ("disks", times(W + "omega", 1.001), W + "omega"),
    ("disks", swap, W + "omega"),
    ("disks", times(W + "omega_max", 1.1), W + "omega_max"),
    ("disks", to("/signal/error", 1e9), "/signal/error"),
    ("disks", to("/signal/error", -1), "/signal/error"),
    ("disks", to("/signal/omega_max", np.inf), "/signal/omega_max"),
    ("disks", to("/signal/products", -5), "/signal/products"),
    ("disks", entry("/signal/F", 9, lambda f: np.nan), "/signal/F"),
    ("disks", entry("/signal/t", 9, lambda t: -t), "/signal/t"),
    ("disks", entry("/signal/t", 9, lambda t: t + 0.01), "/signal/t"),
    ("disks", times("/signal/F", 2), "/signal/F"),
    ("disks", times("/signal/F", 0), None),
    ("disks", later, F + "t10"),
    ("disks", times(F + "t_peak", 1.05), F + "t_peak"),
    ("disks", times(F + "amplitude", 1.1), F + "amplitude"),
    # what nothing else in the file contradicts
    ("disks", softer, M + "c22"),
    ("disks", times(M + "c11", 1.01), M + "c11"),
    ("disks", times(P + "along_lines_3", 1.01), P + "along_lines_3"),
    ("disks", times(F + "amplitude", 1.001), F + "amplitude"),
    ("disks", entry(L + "t_peak", 1, lambda t: 1.001 * t), L + "t_peak"),
    ("disks", entry("/signal/F", 700, lambda f: f + 1e-6), "/signal/F"),
    ("disks", times("/signal/error", 1e-3), "/signal/error"),
    ("disks", times("/signal/omega_max", 1.01), "/signal/omega_max"),
    ("spheres", times(M + "c11", 1.01), M + "c11"),
    ("short", entry("/signal/F", 30, lambda f: 1.5 * f), "/signal/F"),
]


def verify(store, *options, status):
    done = run("study", "--store", store, "--verify", "-q", *options, status=status)
    ((_, names, rows),) = tables(done.stdout)
    return [dict(zip(names, row)) for row in rows]


def honest(folder):
    """No false alarm, and no byte changed."""
    for name in SCENES:
        (path,) = (folder / name).glob("*.h5")
        before = path.read_bytes()
        (row,) = verify(folder / name, status=0)
        assert (row["ok"], row["field"]) == ("yes", "-"), (name, row)
        assert path.read_bytes() == before


def forged(folder, which, place):
    """The row of a false file names the field, and the file stays as it was, unless it cannot be read at all."""
    source, forge, field = which
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir()
    (path,) = (folder / source).glob("*.h5")
    path = pathlib.Path(shutil.copy(path, place / path.name))
    with h5py.File(path, "r+") as file:
        forge(file)
    before = path.read_bytes()
    (row,) = verify(place, status=1)
    now = path if path.exists() else path.with_suffix(".bad")
    expect(row["ok"] == "no" and now.read_bytes() == before and
           (field is None or row["field"] == field and "must" in row["reason"].split()), (which, row))


def many(folder):
    """The same table for any number of jobs, and an end between two samples."""
    store, samples = folder / "many", 6
    run("study", "-q", "--store", store, "--set", "packing.grains=150", "--set", "packing.width=10", "--set",
        f"study.samples={samples}", "--set", 'study.want=["moduli","spectrum"]')
    process = subprocess.Popen([COMMAND, "study", "--store", store, "--verify", "--jobs", "1"], text=True,
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                               preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
    wait_for_work(process, 0.05)
    process.send_signal(signal.SIGINT)
    out, said = process.communicate()
    assert process.returncode == 1 and names_all(said, samples) and out == "", (process.returncode, out, said)
    for path in sorted(store.glob("*.h5"))[::2]:
        with h5py.File(path, "r+") as file:
            times(M + "c11", 1.01)(file)
    found = {run("study", "-q", "--store", store, "--verify", "--jobs", jobs, status=1).stdout for jobs in (1, 2, 100)}
    assert len(found) == 1 and found.pop().count(M + "c11 =") == samples / 2
    assert not list(store.glob("*.bad"))
    for wrong in ("--retry", "--shard=1/2"):
        assert wrong[:6] in run("study", "--store", store, "--verify", wrong, status=2).stderr, wrong


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        make(folder)
        honest(folder)
        for which in FORGED:
            forged(folder, which, folder / "false")
        many(folder)
    assert not faults, "\n".join(map(str, faults))


main()
