"""The command on packings in periodic cells and boxes: columns, comments, waves, and what is refused.

usage: test_cells.py COMMAND SOURCE_DIR
"""
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from common import names_all

COMMAND = sys.argv[1]
OVERLAP = 0.01
ETA = (1 - 0.2) / (1 - 0.1)


def run(*args, status=0):
    done = subprocess.run([COMMAND, *map(str, args)], capture_output=True, text=True)
    assert done.returncode == status, (args, done.returncode, done.stderr)
    return done.stdout if status == 0 else done.stderr


def table(*args):
    lines = run(*args).splitlines()
    comments = dict(line[2:].split(" = ", 1) for line in lines if line.startswith("# ") and " = " in line)
    rows = [line.split("\t") for line in lines if not line.startswith("#")]
    return comments, [dict(zip(rows[0], row)) for row in rows[1:]]


def triangular(path, columns, rows, friction, cell="periodic"):
    """A lattice of equal disks, in a cell that leans by half a column where the number of rows is odd; or in a box."""
    a = 1 - OVERLAP
    width, height = columns * a, rows * a * np.sqrt(0.75)
    lean = 0.5 * a * (rows % 2)
    grains = [((c + 0.5 * (r % 2) + 0.2) * a, (r + 0.5) * a * np.sqrt(0.75)) for r in range(rows) for c in range(columns)]
    contacts = []
    if cell == "box":
        width += (0.5 - 0.2) * a + 0.2  # leaves no grain outside
        grains = [(x + 0.3, y) for x, y in grains]
    for i, p in enumerate(grains):
        for j in range(i + 1, len(grains)):
            dx, dy = grains[j][0] - p[0], grains[j][1] - p[1]
            if cell == "periodic":
                turns = round(dy / height)
                dx, dy = dx - turns * lean, dy - turns * height
                dx -= width * round(dx / width)
            r = np.hypot(dx, dy)
            if r < 1 - 0.5 * OVERLAP:
                contacts.append(f"{i + 1}\t{j + 1}\t{dx / r:.17g}\t{dy / r:.17g}\t{1 - r:.17g}")
        if cell == "box":
            for wall, out, n in (("bottom", p[1], "0\t-1"), ("top", height - p[1], "0\t1"),
                                 ("left", p[0], "-1\t0"), ("right", width - p[0], "1\t0")):
                if out < 0.5:
                    contacts.append(f"{i + 1}\t{wall}\t{n}\t{0.5 - out:.17g}")
    keys = {"dimension": 2, "cell": cell, "width": width, "height": height, "pressure": 1e-3, "friction": friction,
            "poisson": 0.2, **({"xy": lean} if lean and cell == "periodic" else {})}
    folder = path.parent
    (folder / "g.tsv").write_text("".join(f"# {k} = {v}\n" for k, v in keys.items()) + "id\tx\ty\tradius\n" +
                                  "".join(f"{k + 1}\t{x:.17g}\t{y:.17g}\t0.5\n" for k, (x, y) in enumerate(grains)))
    (folder / "c.tsv").write_text("i\tj\tnx\tny\toverlap\n" + "".join(c + "\n" for c in contacts))
    run("convert", "-q", "--grain-table", folder / "g.tsv", "--contact-table", folder / "c.tsv", "-", path)
    return path


def stiffness():
    return 2 * 0.5 * np.sqrt(0.25) * np.sqrt(OVERLAP)  # 2 E12 sqrt(R12 overlap), E12 = 1/2, R12 = 1/4


def moduli(cells, folder):
    for path in cells:
        _, (row,) = table("moduli", path)
        k = stiffness() * np.sqrt(3) / 4
        for name, value in (("C11", 3 * k), ("C22", 3 * k), ("C12", k), ("C33", k), ("K", 2 * k), ("G", k), ("C13", 0),
                            ("C23", 0), ("anisotropy", 0)):
            assert abs(float(row[name]) - value) < 1e-10 * (1 if name == "anisotropy" else k), (name, row)
        assert 0 < float(row["C_err"]) < 1e-10 and 0 < float(row["K_err"]) < 1e-10 and 0 < float(row["G_err"]) < 1e-10
        _, (si,) = table("moduli", path, "--units", "si", "--material", "E=70e9,nu=0.22,rho=2500,d=1e-3")
        unit = 70e9 / (1 - 0.22**2) / 1e3  # kPa
        for name in ("K", "K_err", "G", "C13", "C_err"):
            assert np.isclose(float(si[name]), float(row[name]) * unit, rtol=1e-9, atol=1e-6), (name, si)
    piston = folder / "piston.h5"
    run("pack", "--set", "packing.grains=60", "--set", "packing.width=8", "--set", "packing.pressure=1e-3", "-q", "-o", piston)
    for order in ((piston, cells[0]), (cells[0], piston)):
        assert names_all(run("moduli", *order, status=1), "piston")
    assert "K" not in table("moduli", piston)[1][0]
    assert names_all(run("moduli", cells[0], "--probe", "sine:1", status=1), "piston")
    return piston


def statics(cells, piston):
    _, rows = table("statics", *cells, piston)
    a = 1 - OVERLAP
    force = 4 / 3 * 0.5 * 0.5 * OVERLAP**1.5
    for row in rows[:-1]:
        assert np.isclose(float(row["Phi2"]), np.pi / 4 / (a * a * np.sqrt(0.75)), rtol=1e-12)
        assert float(row["zs"]) == 6 and float(row["f0"]) == 0
        for name, value in (("s_xx", np.sqrt(3) * force / a), ("s_yy", np.sqrt(3) * force / a), ("s_xy", 0)):
            assert abs(float(row[name]) - value) < 1e-12, (name, row)
        assert row["s_zz"] == row["s_yz"] == row["s_xz"] == "nan"
    assert np.isclose(float(rows[-1]["s_yy"]), 1e-3, rtol=1e-3)
    assert "s_yy" not in table("statics", piston, cells[0])[1][0]


def modes(cells, rough):
    for path in (*cells, rough):
        comments, rows = table("modes", path)
        assert comments["rigid_motions"] == "2" and comments["zero_modes"] == "2" and comments["mechanisms"] == "0"
        assert comments["source"] == "none" and comments["detector"] == "none"
        assert [float(row["omega"]) for row in rows[:3]] == [0, 0, float(rows[2]["omega"])] and float(rows[2]["omega"]) > 0
        few, low = table("modes", path, "--lowest", 3)
        assert few["zero_modes"] == "2" and np.isclose(float(low[0]["omega"]), float(rows[2]["omega"]), rtol=1e-8)
        dos, _ = table("spectrum", "dos", path)
        assert dos["rigid_motions"] == "2"
        table("spectrum", "participation", path)


def waves(cells):
    for path in cells:
        _, (row,) = table("moduli", path)
        for direction in ("x", "up"):
            comments, rows = table("spectrum", "dispersion", path, "--direction", direction, "--waves", 1)
            assert comments["direction"] == direction and "node" not in comments
            speed = {r["polarization"]: float(r["rms"]) / float(r["k"]) for r in rows}
            if direction == "up":  # k is upright in every cell
                assert np.isclose(speed["longitudinal"], float(row["c_l"]), rtol=0.05)
                assert np.isclose(speed["transverse"], float(row["c_t"]), rtol=0.05)
        assert names_all(run("spectrum", "dispersion", path, "--direction", "up", "--node", 0.5, status=2), "--node")
        assert names_all(run("spectrum", "dispersion", path, "--direction", "y", status=2), "y")


def signals(cells, folder):
    for path in cells:
        for words in ((), ("--from", "plane:2"), ("--detector", "plane:2"), ("--from", "part:0:1")):
            assert names_all(run("signal", path, *words, status=1), "plane:Y")
        for words in (("front", path), ("modes", path, "--damping", 0.1)):  # none of them has these options itself
            assert names_all(run(*words, status=1), "signal --from --detector plane:Y"), words
        comments, rows = table("signal", path, "--from", "plane:2:shear", "--detector", "plane:3.2:shear", "--until", 20,
                               "--points", 41)
        assert comments["F"].startswith("from plane:2:shear to plane:3.2:shear")
        assert len(rows) == 41 and float(rows[0]["F"]) == 0
        one = table("signal", path, "--source", "velocity:plane:2", "--detector", "plane:4", "--until", 20)[1]
        two = table("signal", path, "--source", "impulse:plane:2", "--detector", "plane:4", "--until", 20)[1]
        height = float(comments["height"])
        assert comments["cell"] == "periodic"
        planes = folder / "planes.tsv"
        planes.unlink(missing_ok=True)
        run("signal", path, "--from", "plane:2", "--detector", "plane:2.9", "--detector", f"plane:{height - 0.5}",
            "--detector", "grain:3", "--until", 60, "-q", "-o", planes)
        _, fronts = table("front", planes)  # by the shorter way around the cell
        assert np.allclose([float(r["distance"]) for r in fronts[:2]], [0.9, 2.5])
        assert fronts[2]["distance"] == "nan"
        for a, b in zip(one, two):  # equal grains: unit velocity is unit momentum times the mass
            assert np.isclose(float(a["F"]), np.pi / 6 * float(b["F"]), rtol=1e-9, atol=1e-12)
    for kind in ("transmission", "harmonic", "continuum"):
        assert run("spectrum", kind, cells[0], status=1)


def boxes(folder):
    box = triangular(folder / "box.h5", 8, 7, 0.3, "box")
    _, (row,) = table("moduli", box)
    assert float(row["K"]) > 0 and abs(float(row["C13"])) < float(row["C11"])
    comments, _ = table("modes", box)
    assert comments["zero_modes"] == "0" and comments["source"] == "impulse"
    _, rows = table("signal", box, "--until", 30)
    peak = max(abs(float(r["F"])) for r in rows)
    _, nonlinear = table("signal", box, "--until", 30, "--method", "dynamics", "--prestress")
    assert peak > 0 and len(nonlinear) == len(rows)
    comments, rows = table("spectrum", "dispersion", box, "--waves", 1)
    assert float(comments.get("omega_max", 0)) > 0 and np.isfinite(float(rows[0]["peak"]))


def low_cells(folder):
    """A cell without walls is not told that its walls decide; a box is."""
    for cell, lines in (("periodic", 0), ("box", 1)):
        path = triangular(folder / f"low_{cell}.h5", 8, 4, 0.3, cell)
        done = subprocess.run([COMMAND, "modes", path, "--lowest", "3"], capture_output=True, text=True, check=True)
        assert len(done.stderr.splitlines()) == lines, (cell, done.stderr)


def studies(folder):
    """What needs walls is refused before any packing is made."""
    store, words = folder / "store", ["--set", "packing.grains=60", "--set", "study.samples=1", "--set"]
    for cell, wants, status in (("periodic", "ctof scaling signal planes probes", 2), ("box", "probes", 2),
                                ("periodic", "statics moduli spectrum", 0), ("box", "ctof signal moduli", 0)):
        for want in wants.split():
            args = [*words, f'study.want=["{want}"]', "--set", "packing.cell=" + cell, "--store", store]
            if want == "planes":
                args += ["--set", "signal.planes=2"]
            said = run("study", *args, *(() if status else ("--dry-run",)), status=status)
            assert names_all(said, "study.want packing.cell" if status else "packings"), (cell, want, said)
            assert not store.exists(), (cell, want)


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        cells = [triangular(folder / f"{rows}.h5", 8, rows, 0) for rows in (8, 9)]  # rectangular and tilted
        rough = triangular(folder / "rough.h5", 8, 9, 0.3)
        piston = moduli(cells, folder)
        statics(cells, piston)
        modes(cells, rough)
        waves(cells)
        signals(cells, folder)
        boxes(folder)
        low_cells(folder)
        studies(folder)


main()
