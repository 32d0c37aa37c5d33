"""sonopack column: the tables of every output, the reference trajectory and numbers of the tapped column, overrides,
formats, and what is refused.

usage: test_column.py COMMAND SOURCE_DIR
"""
import csv
import io
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile

import numpy as np

from common import PATIENCE, names_all, wait_for_work

COMMAND, SOURCE = str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2]).resolve()
FIVE = SOURCE / "packings/column.cfg"
# positions at .99T of the first tap, work of the floor and dissipation there: of an independent program, as the
# trajectory of packings/reference
STROBE = [0.499205348314, 2.093203277325, 3.784435777282, 5.576736210942, 7.474198032402]
WORK, DISSIPATED = 6994.497407, 6993.618476


def column(*sets, scene=None, options=(), status=0, reason="", **arguments):
    words = [word for text in sets for word in ("--set", f"column.{text}")]
    done = subprocess.run([COMMAND, "column", *([str(scene)] if scene else []), *words, *map(str, options)], text=True,
                          capture_output=True, stdin=subprocess.DEVNULL, timeout=PATIENCE, **arguments)
    line = done.stderr.split("\n")[0]
    assert done.returncode == status, (sets, options, done.returncode, done.stderr)
    assert not (status or reason) or names_all(line, reason), (sets, options, done.stderr)
    assert status == 0 or (line.startswith("sonopack: ") and not done.stdout and done.stderr.count("\n") == 1), done
    return done


def table(text):
    """Names, rows of numbers, comments by key, warnings."""
    lines = text.splitlines()
    comments = [line[2:] for line in lines if line.startswith("#")]
    notes = dict(line.split(" = ", 1) for line in comments if " = " in line and not line.startswith("warning"))
    rows = [line.split("\t") for line in lines if not line.startswith("#")]
    values = np.array([[float(word) for word in row] for row in rows[1:]])
    return rows[0], values, notes, [line for line in comments if line.startswith("warning: ")]


def check_trajectory():
    names, rows, notes, warnings = table(column(scene=FIVE).stdout)
    reference = np.loadtxt(SOURCE / "packings/reference/column_N5_trajectory.tsv")
    assert names == "t y0 y1 y2 y3 y4 y5".split() and rows.shape == reference.shape == (401, 7)
    error = np.abs(rows - reference).max()
    assert error < 1e-8, error  # the reference has 9 digits behind the point
    assert float(notes["stiffness"]) == 2 * 5 * 980.67 and not warnings
    for key, value in dict(particles=5, frequency=7.5, period=1, taps=4, amplitude=1.06, e=0.09, gravity=980.67, mass=1,
                           radius=1, drop=-1).items():
        assert float(notes[key]) == value, (key, notes)
    assert notes["model"] == "lattice" and notes["method"] == "event"
    assert float(notes["separation"]) > 0 and 0 <= float(notes["separation_time"]) <= 4
    assert column().stdout == column(scene=FIVE).stdout  # the defaults
    # rows are multiples of the step, up to the end and no further
    names, rows, *_ = table(column("taps=1", "step=0.3", scene=FIVE).stdout)
    assert np.allclose(rows[:, 0], [0, 0.3, 0.6, 0.9], atol=1e-15)
    assert np.abs(rows[:, 1:] - reference[:91:30, 1:]).max() < 1e-8
    names, rows, *_ = table(column("particles=1", "taps=3", "period=0.7", "step=0.7").stdout)
    assert names == ["t", "y0", "y1"] and np.allclose(rows[:, 0], [0, 0.7, 1.4, 2.1], atol=1e-15)
    assert (rows[:, 1] == 0).all()


def check_strobe():
    names, rows, _, _ = table(column("output=strobe", scene=FIVE).stdout)
    assert names == "tap t y1 y2 y3 y4 y5 density".split() and (rows[:, 0] == [1, 2, 3, 4]).all()
    assert np.allclose(rows[:, 1], [0.99, 1.99, 2.99, 3.99], rtol=1e-15)
    assert np.abs(rows[0, 2:7] - STROBE).max() < 1e-10, rows[0]  # given to 12 digits, agree to 9 by their own account
    assert np.allclose(rows[:, 7], 5 / (rows[:, 6] + 1), rtol=1e-14)  # the floor is at 0, the top one radius higher
    # unlike particles, from the floor upwards
    names, rows, notes, _ = table(column("output=strobe", "mass=[1, 2]", "radius=1, 0.5, 1", "particles=3", "taps=1",
                                         "amplitude=0").stdout)
    mass, radius = np.array([1, 2, 1]), np.array([1, 0.5, 1])
    stiffness = 2 * mass.sum() * 980.67 / 0.5
    gaps = np.array([1, 1.5, 1.5]) - np.array([4, 3, 1]) * 980.67 / stiffness
    assert notes["mass"] == "(1, 2)" and notes["radius"] == "(1, 0.5, 1)" and float(notes["stiffness"]) == stiffness
    assert np.allclose(rows[0, 2:5], np.cumsum(gaps), rtol=1e-13) and radius[2] == 1
    assert np.isclose(rows[0, 5], 4 / (np.cumsum(gaps)[-1] + 1), rtol=1e-13)


def check_energy():
    names, rows, notes, warnings = table(column("output=energy", scene=FIVE).stdout)
    assert names == "tap work dissipated energy residual rest separation separation_time contact".split()
    assert rows.shape == (4, 9) and abs(rows[0, 1] / WORK - 1) < 1e-9 and abs(rows[0, 2] / DISSIPATED - 1) < 1e-9
    assert (np.abs(rows[:, 4]) < 1e-9).all() and not warnings  # the balance
    before = np.concatenate(([float(notes["initial_energy"])], rows[:-1, 3]))
    assert np.allclose(rows[:, 3] - before, rows[:, 1] - rows[:, 2], atol=1e-8 * WORK)
    assert (rows[:, 5] < 1).all() and (rows[:, 5] > 0.0667).all()  # at rest before the next tap
    least = rows[:, 6].argmin()
    assert float(notes["separation"]) == rows[least, 6] and float(notes["separation_contact"]) == rows[least, 8]
    # a column that is tapped twice as often passes through itself by the fourth tap
    done = column("output=energy", "period=0.5", scene=FIVE, reason="")
    _, rows, notes, warnings = table(done.stdout)
    assert len(warnings) == 1 and done.stderr == f"sonopack: {warnings[0]}\n"
    assert rows[:, 6].min() == float(notes["separation"]) < -0.2 and "between " in warnings[0]
    assert column("output=energy", "period=0.5", scene=FIVE, options=["--quiet"]).stderr == ""


def check_drop():
    """A ball on K, dropped: the first peak, from formulas of both halves of the contact, elsewhere to 9 digits."""
    _, rows, _, _ = table(column("particles=1", "amplitude=0", "drop=1", "taps=1", "step=1e-4").stdout)
    begun = rows[:, 2].argmin()
    peak = rows[begun:, 2].max()
    # the step misses the peak by g (step/2)^2/2 at the most
    assert 1.583734480 - 980.67 * 0.5e-4 ** 2 / 2 - 1e-9 < peak < 1.583734480 + 1e-9, peak


def check_other_methods():
    """Warnings of what is not exact; the equations as printed are refused."""
    *_, warnings = table(column("method=rk4", "taps=1", scene=FIVE, reason="rk4").stdout)
    assert len(warnings) >= 1 and "first order" in warnings[0]
    _, rows, notes, _ = table(column("method=smooth", "taps=1", "alpha_v=3", scene=FIVE).stdout)
    assert notes["method"] == "smooth" and float(notes["alpha_v"]) == 3 and rows.shape == (101, 7)
    for model in ("eq35", "eq37"):
        column(f"model={model}", scene=FIVE, status=1, reason=f"column.model {model}")


def check_continua():
    for model in ("longwave", "bsr"):
        names, rows, notes, _ = table(column(f"model={model}", "taps=1", "cells=4", scene=FIVE).stdout)
        assert names == "t y0 y1 y2 y3 y4 y5".split() and rows.shape == (101, 7) and notes["model"] == model
        assert (np.diff(rows[:, 1:], axis=1) > 0).all() and float(notes["steps"]) > 0
    for bsr in ("literal", "signed"):
        *_, warnings = table(column("model=bsr", f"bsr={bsr}", "taps=1", scene=FIVE, reason=f"{bsr}").stdout)
        assert any("collapse" in line for line in warnings)
    names, rows, _, _ = table(column("model=longwave", "output=density", "taps=1", "step=0.1", scene=FIVE).stdout)
    assert names == ["t", *(f"y{k}" for k in range(1, 6)), *(f"rho{k}" for k in range(1, 6))] and rows.shape == (11, 11)
    # long waves at rest: rho = m/(h y_z), y_z = 1 - (N - z/h) M/h at the labels z = (2k - 1) r of the balls
    strain = (5 - (2 * np.arange(1, 6) - 1) / 2) * 0.1 / 2
    assert np.allclose(rows[0, 6:], 0.5 / (1 - strain), rtol=0.02), rows[0]
    for sets in (["model=bsr"], []):
        names, rows, *_ = table(column("output=density", "taps=1", "step=0.1", *sets, scene=FIVE).stdout)
        assert rows.shape == (11, 11) and np.isfinite(rows).all() and (np.diff(rows[:, 1:6]) > 0).all()
        assert 0.5 < rows[0, 6:].mean() < 0.65, rows[0]  # m/h, and a quarter more at the bottom
    names, rows, notes, _ = table(column("output=compare", "step=0.05", scene=FIVE).stdout)
    assert names == "t mean_longwave max_longwave mean_bsr max_bsr".split() and rows.shape == (81, 5)
    assert (rows[:, 1] <= rows[:, 2]).all() and (rows[:, 3] <= rows[:, 4]).all()
    mean = rows[:, 1:].mean(axis=0)
    assert np.isclose(float(notes["mean_longwave over time"]), mean[0], rtol=1e-12)
    assert 0.03 < mean[0] < 0.4 and 0.03 < mean[2] < 1, mean  # 0.14 against the smooth lattice


def check_diagrams():
    sets = ["particles=1", "parameter=period", "from=0.2", "to=0.7", "points=2", "transient=300"]
    names, rows, notes, _ = table(column("output=lyapunov", "taps=200", *sets).stdout)
    assert names == ["parameter", "lambda", "error", "cycle"] and (rows[:, 0] == [0.2, 0.7]).all()
    # the map of one tap has the determinant 0.688060 at a fixed point with complex multipliers; 0.7 has period 2
    assert abs(rows[0, 1] - np.log(0.688060) / 2) < 1e-6 and rows[1, 1] < 0 and list(rows[:, 3]) == [1, 2], rows
    assert "period" not in notes and notes["parameter"] == "period" and float(notes["points"]) == 2
    names, rows, _, _ = table(column("output=bifurcation", "taps=4", *sets).stdout)
    assert names == ["parameter", "tap", "y1"] and rows.shape == (8, 3) and (rows[4:, 0] == 0.7).all()
    assert np.ptp(rows[:4, 2]) < 1e-6  # the fixed point
    assert abs(rows[4, 2] - rows[6, 2]) < 1e-6 < 1e-3 < abs(rows[4, 2] - rows[5, 2])  # period 2
    one, two = (column("output=bifurcation", "taps=3", "points=7", *sets[:4], "transient=50",
                       options=["--threads", threads]).stdout for threads in (1, 2))
    assert one == two
    for output in ("lyapunov", "bifurcation"):
        for wrong in ("model=bsr", "method=rk4"):
            column(f"output={output}", wrong, status=2, reason="column.model lattice")


def check_scene(folder):
    scene = folder / "two.cfg"
    scene.write_text("packing = { pressure = 1e-5; };\ncolumn = {\n  particles = 2;\n  taps = 1; e = 0.2;\n  mass = 2; };")
    names, rows, notes, _ = table(column(scene=scene).stdout)
    assert names == ["t", "y0", "y1", "y2"] and rows.shape[0] == 101 and notes["e"] == "0.2" and notes["mass"] == "2"
    names, _, notes, _ = table(column("particles=3", "e=0", scene=scene).stdout)
    assert len(names) == 5 and notes["e"] == "0"
    scene.write_text("column = {\n  particles = 5;\n  stiffness = 4903; };")
    column(scene=scene, status=2, reason=f"{scene}:3 column.stiffness 4903 g/s^2")
    column("stiffness=0", "taps=1", scene=scene)
    scene.write_text("column = {\n  e = 1.0;\n};")
    column(scene=scene, status=2, reason=f"{scene}:2 column.e 1 0 1")
    scene.write_text("column = {\n  partcles = 5;\n};")
    column(scene=scene, status=2, reason=f"{scene}:2 column.partcles column.particles")
    column(scene=folder / "absent.cfg", status=2, reason="No such file")
    for example in SOURCE.glob("packings/column*.cfg"):
        small = ["points=3", "transient=5", "taps=2", "step=0.1"]
        assert table(column(*small, scene=example).stdout)[1].shape[0] >= 6, example


def check_files(folder):
    small = ["particles=2", "taps=1", "step=0.25"]
    names, rows, notes, _ = table(column(*small).stdout)
    read = list(csv.reader(io.StringIO(column(*small, options=["--format", "csv"]).stdout)))
    assert read[0] == names and np.array_equal(np.array(read[1:], float), rows)
    data = json.loads(column(*small, options=["--format", "json"]).stdout)
    assert data["columns"] == names and np.array_equal(np.array(data["rows"]), rows)
    assert data["units"] == ["s", "cm", "cm", "cm"] and f"stiffness = {notes['stiffness']}" in data["comments"]
    out = folder / "out.tsv"
    done = column(*small, options=["-o", out])
    assert not done.stdout and out.read_text() == column(*small).stdout
    column(*small, options=["-o", out], status=2, reason=out)
    column(*small, options=["-o", out, "--force"])
    column(*small, options=["-o", folder / "out.png"], status=2, reason=".tsv .csv .json")
    column("particles=0", options=["-o", folder / "none.tsv"], status=2)
    assert not (folder / "none.tsv").exists()


def check_other_commands(folder):
    """What makes packings takes no notice of the group, and is not led astray by what would be no column."""
    scene = folder / "both.cfg"
    text = "packing = { kind = \"chain\"; grains = 4; };\nstudy = { samples = 1; want = [\"packings\"]; };\n"
    names = []
    for more in ("", "column = { e = 1; mass = [1, 2]; };"):
        scene.write_text(text + more)
        store = folder / f"store{len(names)}"
        subprocess.run([COMMAND, "study", scene, "--store", store, "--quiet"], check=True, timeout=PATIENCE)
        names.append(sorted(path.name for path in store.glob("*.h5")))
    assert names[0] == names[1] and len(names[0]) == 1, names


def check_stop():
    """Ctrl-C ends it at once, nothing half written."""
    for words in (["particles=30", "taps=100000", "step=0.5"],
                  ["particles=1", "output=bifurcation", "from=0.1", "to=1", "points=200000", "taps=1"]):
        stop_one(words)


def stop_one(words):
    process = subprocess.Popen([COMMAND, "column", *(word for text in words for word in ("--set", f"column.{text}"))],
                               text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    wait_for_work(process, 0.3)
    process.send_signal(signal.SIGINT)
    output, error = process.communicate(timeout=PATIENCE)
    assert process.returncode == 1 and not output, (process.returncode, output[:100])
    assert error.startswith("sonopack: ") and error.count("\n") == 2, error


def main():
    check_trajectory()
    check_strobe()
    check_energy()
    check_drop()
    check_other_methods()
    check_continua()
    check_diagrams()
    check_stop()
    with tempfile.TemporaryDirectory(prefix="sonopack-column-") as name:
        folder = pathlib.Path(name)
        os.chdir(folder)
        check_scene(folder)
        check_files(folder)
        check_other_commands(folder)
        os.chdir("/")


if __name__ == "__main__":
    main()
