"""HDF5 packings in periodic cells, tilted ones and boxes: the layout as h5py writes and reads it, and forged files, each
of which must give its reason (exit status 1) and never a wrong packing."""
import os
import shutil
import subprocess
import sys
import tempfile

import h5py
import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "cli"))
from cells import box_of_disks, lattice, write_packing  # noqa: E402
from common import expect, faults, names_all  # noqa: E402

COMMAND = sys.argv[1]
FOLDER = tempfile.mkdtemp(prefix="sonopack-hdf5-cells-")


def path(name):
    return os.path.join(FOLDER, name)


def run(*words):
    return subprocess.run([COMMAND, *words], capture_output=True, text=True, timeout=600)


def made(name, packing, **changes):
    write_packing(path(name), {**packing, **changes})
    return path(name)


TILTED = lattice(2, tilt=0.3)
SHEARED = lattice(3, tilt=0.2)
BOX = box_of_disks()


# ---- the layout ------------------------------------------------------------------------------------------------------
def test_files_of_h5py_are_read_and_written_again():
    for name, packing in (("tilted", TILTED), ("sheared", SHEARED), ("box", BOX), ("straight", lattice(2))):
        first, second = made(name + ".h5", packing), path(name + "-again.h5")
        result = run("convert", first, second)
        expect(result.returncode == 0, f"{name}: {result.stderr}")
        with h5py.File(first) as a, h5py.File(second) as b:
            expect(b["sonopack"].attrs["format"] == 3, f"{name}: format")
            expect(b["sonopack/cell"][()] == a["sonopack/cell"][()], f"{name}: cell")
            words = [b"none" if name == "box" else b"periodic"] * packing["dim"]
            expect(list(b["particles/grains/box"].attrs["boundary"]) == words, f"{name}: boundary")
            for part in ("particles/grains/box/edges", "particles/grains/position/value", "sonopack/gravity",
                         "sonopack/contacts/normal", "connectivity/contacts"):
                expect(np.array_equal(a[part][()], b[part][()]), f"{name}: {part}, bit for bit")
        expect(run("check", second).returncode == 0, f"{name}: the audit")


def test_edges_are_a_matrix_only_where_they_must():
    shapes = {"tilted": (2, 2), "sheared": (3, 3), "box": (2,), "straight": (2,)}
    for name, shape in shapes.items():
        with h5py.File(path(name + "-again.h5")) as f:
            expect(f["particles/grains/box/edges"].shape == shape, f"{name}: edges of H5MD")


# ---- forgeries -------------------------------------------------------------------------------------------------------
def forgery(source, forge, *parts):
    copy = path("forged.h5")
    shutil.copy(path(source + "-again.h5"), copy)
    with h5py.File(copy, "r+") as f:
        forge(f)
    result = run("check", copy)
    expect(result.returncode == 1, f"{source} {parts}: exit status {result.returncode}")
    text = result.stdout + result.stderr
    for part in ("forged.h5",) + parts:
        expect(names_all(text, part), f"'{part}' in: {text}")


def replace(f, name, data):
    del f[name]
    f.create_dataset(name, data=data)


def edges(change):
    def forge(f):
        matrix = f["particles/grains/box/edges"][()]
        change(matrix)
        replace(f, "particles/grains/box/edges", matrix)
    return forge


def test_forgeries():
    for source in ("tilted", "sheared", "box", "straight"):
        forgery(source, lambda f: f.pop("sonopack/cell"), "/sonopack/cell")
        forgery(source, lambda f: f.pop("sonopack/gravity"), "/sonopack/gravity")
        forgery(source, lambda f: replace(f, "sonopack/cell", "sphere"), "/sonopack/cell", "sphere")
        forgery(source, lambda f: replace(f, "sonopack/cell", 1), "/sonopack/cell")
        forgery(source, lambda f: replace(f, "sonopack/gravity", np.nan), "gravity")
        forgery(source, lambda f: replace(f, "sonopack/gravity", 1), "/sonopack/gravity")
        forgery(source, lambda f: replace(f, "sonopack/cell", "piston"), "boundary")
        forgery(source, lambda f: f["sonopack"].attrs.__setitem__("format", 1), "boundary")
        forgery(source, lambda f: replace(f, "particles/grains/box/edges", np.ones(4)), "/particles/grains/box/edges")
        forgery(source, lambda f: replace(f, "particles/grains/box/edges", 5.0), "/particles/grains/box/edges")
    forgery("box", lambda f: replace(f, "sonopack/cell", "periodic"), "boundary")
    forgery("box", lambda f: replace(f, "particles/grains/box/edges", np.eye(2)), "/particles/grains/box/edges")

    def upper(m):
        m[0, 1] = 1e-3
    forgery("tilted", edges(upper), "/particles/grains/box/edges")
    forgery("sheared", edges(upper), "/particles/grains/box/edges")

    def far(m):
        m[1, 0] = 0.6 * m[0, 0]
    forgery("tilted", edges(far), "tilt")
    forgery("sheared", edges(far), "tilt")

    def undefined(m):
        m[1, 0] = np.nan
    forgery("tilted", edges(undefined))

    def outside(f):
        x = f["particles/grains/position/value"][()]
        x[0, 3, 0] += 50
        replace(f, "particles/grains/position/value", x)
    forgery("tilted", outside, "3")

    def wall(number):
        def forge(f):
            walls = f["sonopack/walls/contacts"][()]
            walls[-1, 1] = number
            replace(f, "sonopack/walls/contacts", walls)
        return forge
    for number in (-5, -7):  # of three dimensions; of none
        forgery("box", wall(number), str(number))

    def wall_in_periodic(f):
        pairs = f["connectivity/contacts"][()]
        pairs[-1, 1] = -1
        replace(f, "connectivity/contacts", pairs)
    forgery("straight", wall_in_periodic)


for name, test in list(globals().items()):
    if name.startswith("test_"):
        before = len(faults)
        test()
        print("ok" if len(faults) == before else "FAILED", name)
shutil.rmtree(FOLDER)
print(*faults, sep="\n")
sys.exit(1 if faults else 0)
