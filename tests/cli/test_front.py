"""front: packings and traces, told apart by their content; the rule against one written here; units; what has no front.

usage: test_front.py COMMAND SOURCE_DIR
"""
import pathlib
import re

import numpy as np

from command import MATERIAL, N200, REFERENCE, main, pack, refused, run, table, tried
from common import names_all

COLUMNS = ["file", "distance", "t10", "t_peak", "t_zero", "amplitude", "width"]
T = np.arange(0, 200, 0.25)


def write(path, f, comment="", t=T):
    pathlib.Path(path).write_text(comment + "t\tF\n" + "".join(f"{x:.17g}\t{y:.17g}\n" for x, y in zip(t, f)))


def pulse(at, width=8):
    return np.exp(-((T - at) / width) ** 2 / 2) * np.cos((T - at) / (2 * width))


def marks(t, f):
    """The rule for clean traces, without interpolated peaks: t10, t_peak, t_zero and height on the grid."""
    peak = next(k for k in range(1, len(f) - 1) if f[k] > 0.2 * f.max() and f[k - 1] < f[k] >= f[k + 1])
    up = next(k for k in range(len(f)) if f[k] >= 0.1 * f[peak])
    down = next(k for k in range(peak, len(f)) if f[k] <= 0)

    def at(k, level):
        return t[k - 1] + (level - f[k - 1]) / (f[k] - f[k - 1]) * (t[k] - t[k - 1])

    return at(up, 0.1 * f[peak]), t[peak], at(down, 0), f[peak]


def numbers(found):
    return np.array([found[name][0] for name in COLUMNS[2:]])


def reference_packings():
    for size, height in ((200, 8.6958069203285007), (600, 24.663840944980521)):
        signal, packing = REFERENCE / f"signal_N{size}_p1e-4.txt", REFERENCE / f"packing_N{size}_p1e-4.txt"
        t, *forces = np.loadtxt(signal).T
        for source, column in (("impulse", 1), ("velocity", 0)):
            found = table("front", packing, "--source", source)
            ours, theirs = numbers(found), marks(t, forces[column])
            assert found.names == COLUMNS and abs(found["distance"][0] - height) < 1e-12 and ours[4] == ours[2] - ours[0]
            # the published signals have steps of 0.5: straight lines and grid peaks are that coarse
            assert np.all(np.abs(ours[:3] - theirs[:3]) < [0.02, 0.251, 0.01]) and 0 < ours[3] / theirs[3] - 1 < 1.5e-3
            # the same trace as a file: rows apart by blanks, no header
            trace = table("front", signal, "--column", column + 2, "--window", 240)
            assert np.isnan(trace["distance"][0]) and np.allclose(numbers(trace)[:3], ours[:3], rtol=1.5e-3)
        by_option, by_key, moved = (table("front", packing, *words).body for words in (
            ["--source=velocity"], ["--set=signal.source=velocity"], ["--set=network.prestress=true", "--source=velocity"]))
        assert by_option == by_key != moved


def packing_and_its_signal():
    """A packing in HDF5 form under a name that says nothing, and the signal that `signal' makes of it."""
    pathlib.Path("nothing").write_bytes(pathlib.Path(pack("p.h5", grains=60, width=8)).read_bytes())
    nameless, named = table("front", "nothing"), table("front", "p.h5")
    assert nameless.rows[0][1:] == named.rows[0][1:]
    run("signal", "p.h5", "--points", 2001, "-o", "trace.tsv")
    assert np.allclose(numbers(table("front", "trace.tsv")), numbers(named), rtol=2e-4)


def traces():
    first, late = pulse(40), 60 * np.exp(-((T - 150) / 8) ** 2 / 2)
    write("lab.tsv", first)
    found, expected = table("front", "lab.tsv"), marks(T, first)
    assert np.allclose(numbers(found)[:4], expected, rtol=0, atol=0.13) and np.isnan(found["distance"][0])
    assert table("front", "lab.tsv", "--distance", 12.5)["distance"][0] == 12.5
    # the window: eight heights + 40 at p = 1e-4; ten times as long in time at p = 1e-10
    for pressure, words, peak in (("1e-4", (), expected[1]), ("1e-4", ("--window=200",), 150), ("1e-10", (), 150)):
        write("lab.tsv", first + late, f"# height = 7\n# pressure = {pressure}\n")
        found = table("front", "lab.tsv", *words)
        assert found["distance"][0] == 7 and abs(found["t_peak"][0] - peak) < 0.5, (pressure, words)
    # columns by name and number; words beside numbers
    rows = "".join(f"{x}\t{np.sin(x)}\t{y}\n" for x, y in zip(T, first))
    pathlib.Path("lab.tsv").write_text("time\tmicrophone\tforce\n" + rows)
    by_name = table("front", "lab.tsv", "--column=force")
    assert by_name.body == table("front", "lab.tsv", "--column=3").body and abs(by_name["t_peak"][0] - expected[1]) < 0.5
    for column in ("farce", "4"):
        refused(f"lab.tsv {column}", "front", "lab.tsv", "--column", column, status=1)


def units():
    """They are the trace's own, or none; files of different units are refused."""
    write("lab.tsv", pulse(60))
    run("signal", N200, "-o", "ours.tsv")
    times = "t10 [{0}] t_peak [{0}] t_zero [{0}]"

    def of(*paths):
        return next((line for line in table("front", *paths).comments if line.startswith("units: ")), "")

    assert of("lab.tsv") == of("lab.tsv", N200) == of(N200, "lab.tsv") == ""
    assert of(N200) == of("ours.tsv") == of(N200, "ours.tsv") == (
        "units: distance [d] " + times.format("d/sqrt(E* / rho)") + " amplitude [E* d^2] width [d/sqrt(E* / rho)]")
    write("lab.tsv", pulse(60), "# units: t [ms] F [N]\n")
    assert of("lab.tsv") == "units: " + times.format("ms") + " amplitude [N] width [ms]"
    done = tried("front", "lab.tsv", "ours.tsv")
    assert done.returncode == 1 and names_all(done.stderr, "ours.tsv ms") and len(done.stdout.splitlines()) == 4, done
    run("signal", N200, "--units=si", MATERIAL, "-o", "si.tsv")
    assert "material" in table("front", "si.tsv", "--units=si", MATERIAL).notes
    refused("si.tsv", "front", "si.tsv", "--units=si", "--material=E=200e9,nu=0.3,rho=7800,d=1e-3", status=1)


def warnings():
    """What is for the other kind of file, and fronts that may be none, are told."""
    for words, names in ((["--source=velocity"], "--source"), (["--set=signal.source=velocity"], "--set")):
        done = run("front", "lab.tsv", *words)
        assert names_all(done.stderr, names) and done.stdout == run("front", "lab.tsv").stdout
        assert not run("front", N200, *words).stderr and not run("front", "lab.tsv", *words, "-q").stderr
    assert names_all(run("front", N200, "--column", 2).stderr, "--column")
    # a precursor above a tenth: t10 is its, and that is told; an offset has no front
    write("noisy.tsv", pulse(60) + 0.15 * np.exp(-((T - 20) / 2) ** 2 / 2))
    done = run("front", "noisy.tsv")
    found = table("front", "noisy.tsv")
    assert names_all(done.stderr, "noisy.tsv 2") and 15 < found["t10"][0] < 20 and abs(found["t_peak"][0] - 60) < 0.5
    write("noisy.tsv", pulse(60) + 0.3)
    refused("noisy.tsv", "front", "noisy.tsv", status=1)
    # errors of a signal that reach its front
    run("signal", N200, "--method=sparse", "--modes=20", "-o", "few.tsv")
    refused("few.tsv error", "front", "few.tsv", status=1)
    text, peak = pathlib.Path("ours.tsv").read_text(), table("front", "ours.tsv")["amplitude"][0]
    for part, status in ((0, 0), (0.03, 0), (0.3, 1)):
        pathlib.Path("error.tsv").write_text(re.sub(r"(error = |error )[\d.e+-]+$", rf"\g<1>{part * peak!r}", text, flags=re.M))
        assert len(run("front", "error.tsv", status=status).stderr.splitlines()) == (part > 0), part


main(reference_packings, packing_and_its_signal, traces, units, warnings)
