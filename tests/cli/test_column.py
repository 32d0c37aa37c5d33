"""column: the tables of every output, the reference trajectory and numbers of the tapped column, scenes, and the end by
Ctrl-C. The numerics are in tests/unit/test_column*.c.

usage: test_column.py COMMAND SOURCE_DIR
"""
import json
import pathlib
import signal

import numpy as np

from command import REFERENCE, SOURCE, Table, main, refused, run, sets, start
from common import PATIENCE, names_all, wait_for_work

FIVE = SOURCE / "packings/column.cfg"
# positions at .99T of the first tap, work of the floor and dissipation there: of an independent program, as the
# trajectory of packings/reference
STROBE = [0.499205348314, 2.093203277325, 3.784435777282, 5.576736210942, 7.474198032402]
WORK, DISSIPATED = 6994.497407, 6993.618476


def words(*keys, scene=None, options=()):
    return ["column", *([scene] if scene else []), *sets(*(f"column.{key}" for key in keys)), *options]


def column(*keys, warnings=0, **more):
    """The table of a run, and whether as many warnings as that are in it and on stderr."""
    done = run(*words(*keys, **more))
    found = Table(done.stdout)
    told = [line for line in found.comments if line.startswith("warning: ")]
    assert len(told) >= warnings and done.stderr == "".join(f"sonopack: {line}\n" for line in told), (keys, done.stderr)
    return found


def numbers(found):
    return np.array([found[name] for name in found.names]).T


def trajectory():
    found, reference = column(scene=FIVE), np.loadtxt(REFERENCE / "column_N5_trajectory.tsv")
    assert found.names == "t y0 y1 y2 y3 y4 y5".split() and numbers(found).shape == reference.shape
    assert np.abs(numbers(found) - reference).max() < 1e-8  # the reference has 9 digits behind the point
    assert found.note("stiffness") == 2 * 5 * 980.67 and found.notes["model"] == "lattice" and found.notes["method"] == "event"
    for key, value in dict(particles=5, frequency=7.5, period=1, taps=4, e=0.09, gravity=980.67, mass=1, drop=-1).items():
        assert found.note(key) == value, key
    assert run("column").stdout == run("column", FIVE).stdout  # the defaults
    # rows are multiples of the step, up to the end and no further
    found = column("taps=1", "step=0.3", scene=FIVE)
    assert np.allclose(found["t"], [0, 0.3, 0.6, 0.9], atol=1e-15)
    assert np.abs(numbers(found)[:, 1:] - reference[:91:30, 1:]).max() < 1e-8


def strobe_and_energy():
    found = column("output=strobe", scene=FIVE)
    assert found.names == "tap t y1 y2 y3 y4 y5 density".split() and np.allclose(found["t"], np.arange(4) + 0.99, rtol=1e-15)
    assert np.abs(numbers(found)[0, 2:7] - STROBE).max() < 1e-10  # given to 12 digits, agree to 9 by their own account
    assert np.allclose(found["density"], 5 / (found["y5"] + 1), rtol=1e-14)
    # unlike particles, from the floor upwards
    found = column("output=strobe", "mass=[1, 2]", "radius=1, 0.5, 1", "particles=3", "taps=1", "amplitude=0")
    stiffness = 2 * 4 * 980.67 / 0.5
    gaps = np.array([1, 1.5, 1.5]) - np.array([4, 3, 1]) * 980.67 / stiffness
    assert found.notes["mass"] == "(1, 2)" and found.note("stiffness") == stiffness
    assert np.allclose(numbers(found)[0, 2:5], np.cumsum(gaps), rtol=1e-13)
    found = column("output=energy", scene=FIVE)
    assert found.names == "tap work dissipated energy residual rest separation separation_time contact".split()
    assert abs(found["work"][0] / WORK - 1) < 1e-9 and abs(found["dissipated"][0] / DISSIPATED - 1) < 1e-9
    assert np.all(np.abs(found["residual"]) < 1e-9) and found.note("separation") == found["separation"].min()
    # a column that is tapped twice as often passes through itself by the fourth tap
    found = column("output=energy", "period=0.5", scene=FIVE, warnings=1)
    assert found["separation"].min() == found.note("separation") < -0.2
    assert run(*words("output=energy", "period=0.5", options=["--quiet"])).stderr == ""


def other_models():
    """Warnings of what is not exact; the equations as printed are refused."""
    assert names_all(run(*words("method=rk4", "taps=1")).stderr, "rk4")
    assert column("method=smooth", "taps=1", "alpha_v=3").note("alpha_v") == 3
    for model in ("eq35", "eq37"):
        refused(f"column.model {model}", *words(f"model={model}"), status=1)
    for bsr in ("literal", "signed"):
        assert "collapse" in str(column("model=bsr", f"bsr={bsr}", "taps=1", warnings=1).comments)
    for model in ("longwave", "bsr", "lattice"):
        found = column(f"model={model}", "output=density", "taps=1", "step=0.1", scene=FIVE)
        assert found.names == ["t", *(f"y{k}" for k in range(1, 6)), *(f"rho{k}" for k in range(1, 6))]
        assert len(found) == 11 and (np.diff(numbers(found)[:, 1:6], axis=1) > 0).all() and found.notes["model"] == model
        assert 0.5 < numbers(found)[0, 6:].mean() < 0.65, model  # m/h, and a quarter more at the bottom
    found = column("output=compare", "step=0.05")
    assert found.names == "t mean_longwave max_longwave mean_bsr max_bsr".split() and len(found) == 81
    assert np.isclose(found.note("mean_longwave over time"), found["mean_longwave"].mean(), rtol=1e-12)
    assert 0.03 < found["mean_longwave"].mean() < 0.4  # 0.14 against the smooth lattice


def diagrams():
    keys = ["particles=1", "parameter=period", "from=0.2", "to=0.7", "points=2", "transient=300"]
    found = column("output=lyapunov", "taps=200", *keys)
    assert found.names == ["parameter", "lambda", "error", "cycle"] and list(found["parameter"]) == [0.2, 0.7]
    # the map of one tap has the determinant 0.688060 at a fixed point with complex multipliers; 0.7 has period 2
    assert abs(found["lambda"][0] - np.log(0.688060) / 2) < 1e-6 and list(found["cycle"]) == [1, 2]
    found = column("output=bifurcation", "taps=4", *keys)
    y = found["y1"]
    assert len(found) == 8 and np.ptp(y[:4]) < 1e-6  # the fixed point
    assert abs(y[4] - y[6]) < 1e-6 < 1e-3 < abs(y[4] - y[5])  # period 2
    one, two = (run(*words("output=bifurcation", "taps=3", "points=7", *keys[:4], "transient=50",
                           options=["--threads", threads])).stdout for threads in (1, 2))
    assert one == two
    for output in ("lyapunov", "bifurcation"):
        for wrong in ("model=bsr", "method=rk4"):
            refused("column.model lattice", *words(f"output={output}", wrong))


def scenes():
    scene = pathlib.Path("two.cfg")
    scene.write_text("packing = { pressure = 1e-5; };\ncolumn = {\n  particles = 2;\n  taps = 1; e = 0.2;\n  mass = 2; };")
    found = column(scene=scene)
    assert found.names == ["t", "y0", "y1", "y2"] and found.notes["e"] == "0.2" and found.notes["mass"] == "2"
    for text, names in (("particles = 5;\n  stiffness = 4903;", "column.stiffness 4903"), ("e = 1.0;", "column.e 1 0"),
                        ("partcles = 5;", "column.partcles column.particles")):
        scene.write_text("column = {\n  " + text + "\n};")
        refused(f"{scene}:{2 + text.count(chr(10))} {names}", "column", scene)
    for example in SOURCE.glob("packings/column*.cfg"):
        assert len(column("points=3", "transient=5", "taps=2", "step=0.1", scene=example)) >= 6, example


def formats():
    small = ["particles=2", "taps=1", "step=0.25"]
    found = column(*small)
    lines = run(*words(*small, options=["--format=csv"])).stdout.split()
    assert lines[0].split(",") == found.names and np.array_equal(np.array([r.split(",") for r in lines[1:]], float), numbers(found))
    data = json.loads(run(*words(*small, options=["--format=json"])).stdout)
    assert np.array_equal(np.array(data["rows"]), numbers(found)) and data["units"] == ["s", "cm", "cm", "cm"]
    assert not run(*words(*small, options=["-o", "out.tsv"])).stdout
    assert pathlib.Path("out.tsv").read_text() == run(*words(*small)).stdout
    refused("out.tsv", *words(*small, options=["-o", "out.tsv"]))
    refused("", *words("particles=0", options=["-o", "none.tsv"]))
    assert not pathlib.Path("none.tsv").exists()


def stopped():
    """Ctrl-C ends it at once, nothing half written."""
    for keys in (["particles=30", "taps=100000", "step=0.5"],
                 ["particles=1", "output=bifurcation", "from=0.1", "to=1", "points=200000", "taps=1"]):
        process = start(*words(*keys))
        wait_for_work(process, 0.3)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=PATIENCE)
        assert process.returncode == 1 and not out and err.count("\n") == 2, (process.returncode, out[:100], err)


main(trajectory, strobe_and_energy, other_models, diagrams, scenes, formats, stopped)
