"""sonopack front: packings and traces, told apart by their content; the rule against one written here; what has no front.

usage: test_front.py COMMAND SOURCE_DIR
"""
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

from common import names_all

COMMAND, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
REFERENCE = SOURCE / "packings" / "reference"
COLUMNS = ["file", "distance", "t10", "t_peak", "t_zero", "amplitude", "width"]


def run(*args, status=0):
    done = subprocess.run([COMMAND, *map(str, args)], capture_output=True, text=True)
    assert done.returncode == status, (args, done.returncode, done.stderr)
    return done


def front(*args, status=0):
    lines = [line for line in run("front", *args, status=status).stdout.splitlines() if not line.startswith("#")]
    assert not lines or lines[0].split("\t") == COLUMNS, lines
    return [dict(zip(COLUMNS, line.split("\t"))) for line in lines[1:]]


def numbers(row):
    return np.array([float(row[name]) for name in COLUMNS[1:]])


def marks(t, f):
    """The rule for clean traces, without interpolated peaks: t10, t_peak, t_zero and height on the grid."""
    peak = next(k for k in range(1, len(f) - 1) if f[k] > 0.2 * f.max() and f[k - 1] < f[k] >= f[k + 1])
    up = next(k for k in range(len(f)) if f[k] >= 0.1 * f[peak])
    down = next(k for k in range(peak, len(f)) if f[k] <= 0)

    def at(k, level):
        return t[k - 1] + (level - f[k - 1]) / (f[k] - f[k - 1]) * (t[k] - t[k - 1])

    return at(up, 0.1 * f[peak]), t[peak], at(down, 0), f[peak]


def reference_packings(folder):
    for size, height in ((200, 8.6958069203285007), (600, 24.663840944980521)):
        signal = np.loadtxt(REFERENCE / f"signal_N{size}_p1e-4.txt")
        packing = REFERENCE / f"packing_N{size}_p1e-4.txt"
        for source, column in (("impulse", 2), ("velocity", 1)):
            (row,) = front(packing, "--source", source)
            found = numbers(row)
            assert abs(found[0] - height) < 1e-12 and found[5] == found[3] - found[1]
            # the published signals have steps of 0.5: straight lines and grid peaks are that coarse
            t10, t_peak, t_zero, height_of_peak = marks(signal[:, 0], signal[:, column])
            assert abs(found[1] - t10) < 0.02 and abs(found[2] - t_peak) <= 0.25 and abs(found[3] - t_zero) < 0.01, row
            assert 0 < found[4] / height_of_peak - 1 < 1.5e-3, (row, height_of_peak)
            # the same trace as a file: rows apart by blanks, no header
            (row,) = front(REFERENCE / f"signal_N{size}_p1e-4.txt", "--column", column + 1, "--window", 240)
            assert row["distance"] == "nan"
            assert np.allclose(numbers(row)[1:4], found[1:4], rtol=1.5e-3), (row, found)
        (moved,) = front(packing, "--set", "network.prestress=true")
        assert numbers(moved)[1] != found[1]
        (plain,), (by_key,) = front(packing, "--source", "velocity"), front(packing, "--set", "signal.source=velocity")
        assert plain == by_key


def packing_and_its_signal(folder):
    """A packing in HDF5 form under a name that says nothing, and the signal that `signal' makes of it."""
    packing = folder / "p.h5"
    run("convert", REFERENCE / "packing_N200_p1e-4.txt", packing)
    nameless = folder / "nothing"
    nameless.write_bytes(packing.read_bytes())
    (text,), (hdf5,) = front(REFERENCE / "packing_N200_p1e-4.txt"), front(nameless)
    assert [text[c] for c in COLUMNS[1:]] == [hdf5[c] for c in COLUMNS[1:]]
    trace = folder / "trace.tsv"
    run("signal", packing, "--until", 109.56, "--points", 1097, "-o", trace)
    (row,) = front(trace)
    assert np.allclose(numbers(row)[1:], numbers(text)[1:], rtol=1e-4), (row, text)


def traces(folder):
    t = np.arange(0, 200, 0.25)
    first = np.exp(-((t - 40) / 8) ** 2 / 2) * np.cos((t - 40) / 16)
    late = 3 * np.exp(-((t - 150) / 8) ** 2 / 2)
    path = folder / "lab.tsv"

    def write(columns, names, comments=()):
        with open(path, "w") as out:
            out.writelines(f"# {line}\n" for line in comments)
            if names:
                out.write("\t".join(names) + "\n")
            out.writelines("\t".join(f"{x:.17g}" for x in row) + "\n" for row in zip(*columns))

    write([t, first], ["t", "F"])
    (row,) = front(path)
    expected = marks(t, first)
    assert np.allclose(numbers(row)[1:5], expected, rtol=0, atol=0.13), row
    assert row["distance"] == "nan"
    (row,) = front(path, "--distance", 12.5)
    assert float(row["distance"]) == 12.5
    # the window: eight heights + 40 at p = 1e-4; ten times as long in time at p = 1e-10
    write([t, first + 20 * late], ["t", "F"], ["height = 7", "pressure = 1e-4"])
    (row,) = front(path)
    assert float(row["distance"]) == 7 and abs(float(row["t_peak"]) - expected[1]) < 0.5
    (row,) = front(path, "--window", 200)
    assert abs(float(row["t_peak"]) - 150) < 0.5
    write([t, first + 20 * late], ["t", "F"], ["height = 7", "pressure = 1e-10"])
    (row,) = front(path)
    assert abs(float(row["t_peak"]) - 150) < 0.5
    # columns by name and number; words beside numbers
    write([t, np.sin(t), first], ["time", "microphone", "force"])
    by_name, by_number = front(path, "--column", "force"), front(path, "--column", "3")
    assert by_name == by_number and abs(float(by_name[0]["t_peak"]) - expected[1]) < 0.5
    done = run("front", path, "--column", "farce", status=1)
    assert names_all(done.stderr, "farce") and str(path) in done.stderr
    run("front", path, "--column", "4", status=1)


def units_and_notes(folder):
    """Units are the trace's own, or none; what says nothing, or may be wrong, is told on stderr."""
    t = np.arange(0, 100, 0.25)
    pulse = np.exp(-((t - 60) / 8) ** 2 / 2) * np.cos((t - 60) / 16)
    packing, ours, lab, noisy = REFERENCE / "packing_N200_p1e-4.txt", *(folder / f"{k}.tsv" for k in range(3))
    run("signal", packing, "-o", ours)

    def write(path, f, comment=""):
        path.write_text(comment + "t\tF\n" + "".join(f"{x:.17g}\t{y:.17g}\n" for x, y in zip(t, f)))

    def units(*paths):
        lines = [line for line in run("front", *paths).stdout.splitlines() if line.startswith("# units: ")]
        return lines[0] if lines else ""

    times = "t10 [{0}] t_peak [{0}] t_zero [{0}]"
    write(lab, pulse)
    assert units(lab) == "" and units(lab, packing) == "" and units(packing, lab) == ""
    assert units(packing) == ("# units: distance [d] " + times.format("d/sqrt(E* / rho)")
                              + " amplitude [E* d^2] width [d/sqrt(E* / rho)]")
    assert units(ours) == units(packing, ours) == units(packing)
    write(lab, pulse, "# units: t [ms] F [N]\n")
    assert units(lab) == units(lab, lab) == "# units: " + times.format("ms") + " amplitude [N] width [ms]"
    # a column has one unit: files of different units are refused, and so is another material of what is in SI already
    seen = run("front", lab, ours, status=1)
    assert names_all(seen.stderr, f"{ours} ms") and len(seen.stdout.splitlines()) == 4, seen
    material = "E=70e9,nu=0.22,rho=2500,d=1e-3"
    run("signal", packing, "--units", "si", "--material", material, "-o", noisy)
    assert "# material" in run("front", noisy, "--units", "si", "--material", material).stdout
    assert names_all(run("front", noisy, "--units", "si", "--material", "E=200e9,nu=0.3,rho=7800,d=1e-3", status=1).stderr,
                     f"{noisy}")
    noisy.unlink()
    # options that are for the other kind of file
    for args, reasons in ((["--source", "velocity"], ["--source"]),
                          (["--set", "signal.source=velocity"], ["--set"]), ([], [])):
        lines = run("front", lab, *args).stderr.splitlines()
        assert len(lines) == len(reasons) and all(names_all(line, r) for r, line in zip(reasons, lines)), (args, lines)
        assert run("front", lab, *args).stdout == run("front", lab).stdout
        assert not run("front", packing, *args).stderr and not run("front", lab, *args, "-q").stderr
    assert names_all(run("front", packing, "--column", 2).stderr, "--column")
    # a precursor above a tenth: t10 is its, and that is told; an offset has no front
    write(noisy, pulse + 0.15 * np.exp(-((t - 20) / 2) ** 2 / 2))
    done = run("front", noisy)
    assert names_all(done.stderr, f"{noisy} 2"), done.stderr
    assert len(done.stderr.splitlines()) == 1
    (row,) = front(noisy)
    assert 15 < float(row["t10"]) < 20 and abs(float(row["t_peak"]) - 60) < 0.5
    write(noisy, pulse + 0.3)
    assert names_all(run("front", noisy, status=1).stderr, noisy)


with tempfile.TemporaryDirectory() as name:
    for test in (reference_packings, packing_and_its_signal, traces, units_and_notes):
        test(pathlib.Path(name))
        print(test.__name__, "ok")
