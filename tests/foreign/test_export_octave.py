"""Octave reads packings (HDF5 and MAT-files), signals and tables.

usage: test_export_octave.py COMMAND SOURCE_DIR
"""
import pathlib
import shutil
import subprocess
import sys
import tempfile

COMMAND = sys.argv[1]
OCTAVE = shutil.which("octave-cli") or shutil.which("octave")
if not OCTAVE:
    print("no octave")
    sys.exit(77)

import h5py
import numpy as np


def run(folder, *words):
    result = subprocess.run([str(word) for word in words], cwd=folder, text=True, capture_output=True, timeout=1200)
    assert result.returncode == 0, f"{words}: {result.stdout} {result.stderr}"
    return result.stdout


# Each line prints numbers as %.17g, which the test compares.
SCRIPT = r"""1; % a script, not a function
function show(varargin) for k = 1:numel(varargin) printf('%.17g ', varargin{k}); end; printf('\n'); end
h = load('-hdf5', 'P.h5');
show(h.particles.grains.radius); show(h.particles.grains.position.value); show(h.connectivity.contacts);
show(h.sonopack.contacts.normal_force); show(h.sonopack.pressure); printf('%s\n', h.sonopack.wall);
p = load('P.mat');
show(p.grains.radius); show([p.grains.x p.grains.y]'); show([p.contacts.i p.contacts.j]');
show(p.contacts.Fn); show(p.pressure); printf('%s\n', p.wall);
s = load('F.mat');
show(s.t); show(s.F); printf('%s\n', s.units.F); printf('%d\n', numel(s.comments));
c = importdata('F.csv', ',', 1); show(c.data(:, 1)); show(c.data(:, 2)); printf('%s %s\n', c.colheaders{:});
m = load('modes.mat'); show(m.omega); v = load('-hdf5', 'V.h5'); show(v.modes.omega); show(v.modes.vector(:, 1));
k = load('check.mat'); printf('%s %s\n', k.file{1}, k.ok{1});
"""


def numbers(line):
    return np.array(line.split(), float)


with tempfile.TemporaryDirectory(prefix="sonopack-octave-") as name:
    folder = pathlib.Path(name)
    run(folder, COMMAND, "pack", "--quiet", "--set", "packing.grains=60", "--set", "packing.width=8", "-o", "P.h5")
    run(folder, COMMAND, "convert", "P.h5", "P.mat")
    for ending in ("tsv", "csv", "mat"):
        run(folder, COMMAND, "signal", "P.h5", "--points", 101, "-o", "F." + ending)
    run(folder, COMMAND, "modes", "P.h5", "--lowest", 5, "--vectors", "V.h5", "-o", "modes.mat")
    run(folder, COMMAND, "check", "P.h5", "-o", "check.mat")
    (folder / "read.m").write_text(SCRIPT)
    # an old Octave says something about its own exit where it has no screen, with a status of 1
    result = subprocess.run([OCTAVE, "--no-gui", "-q", "--eval", "source('read.m')"], cwd=folder, text=True, capture_output=True)
    lines = result.stdout.split("\n")
    assert len(lines) == 24, f"{len(lines)} lines: {result.stderr[-3000:]}"
    with h5py.File(folder / "P.h5") as f, h5py.File(folder / "V.h5") as v:
        pairs = f["connectivity/contacts"][:]
        contacts = np.concatenate([pairs, f["sonopack/walls/contacts"][:]])
        table = np.loadtxt(folder / "F.tsv", skiprows=1 + sum(line.startswith("#") for line in open(folder / "F.tsv")))
        shared = [f["particles/grains/radius"][:], f["particles/grains/position/value"][0]]
        forces = [f["sonopack/contacts/normal_force"][:], [f["sonopack/pressure"][()]], "rigid"]
        expected = [*shared, pairs, *forces, *shared, contacts, *forces, table[:, 0], table[:, 1], "E* d^2", None, table[:, 0],
                    table[:, 1], "t F", v["modes/omega"][:], v["modes/omega"][:], v["modes/vector"][0], "P.h5 yes"]
    assert len(expected) == 23
    for k, (line, what) in enumerate(zip(lines, expected)):
        if isinstance(what, str):
            assert line == what, f"line {k}: {line}, must be {what}"
        elif what is not None:
            found, what = numbers(line), np.ravel(what)
            assert found.shape == what.shape and (found == what).all(), f"line {k}: {found[:4]}, must be {what[:4]}"
    assert int(lines[15]) > 5, "comments"
    print("octave:", len(expected), "things read")
