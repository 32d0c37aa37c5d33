"""The triangular lattice has the speed of sound of Eqs. (18) and (19) of Somfai et al. 2005, and walls of the stiffness
that Hertz's law gives them.

usage: test_lattice.py COMMAND SOURCE_DIR

Two heights tell rows from walls: under a strain between the walls all rows and walls carry the same stress, so that
H/C22 = (rows - 1)/k_row + 2/k_wall per area of wall, exactly.
"""
import math
import pathlib
import subprocess
import sys
import tempfile

COMMAND = sys.argv[1]
PRESSURE, ROW = 1e-8, 8
# relative overlap of a contact, which the equations neglect: (3/4 F / (E12 sqrt(R12)))^(2/3), F = p/sqrt(3)
OVERLAP = (0.75 * PRESSURE / math.sqrt(3) / 0.25) ** (2 / 3)


def run(folder, *arguments):
    result = subprocess.run([COMMAND, *arguments], cwd=folder, text=True, capture_output=True)
    assert result.returncode == 0, f"{arguments}: {result.stderr}"
    lines = [line for line in result.stdout.splitlines() if not line.startswith("#")]
    return dict(zip(lines[0].split("\t"), lines[1].split("\t")))


def lattice(folder, rows, friction, poisson):
    """Height and C22 of a lattice."""
    name = f"{rows}_{friction}_{poisson}.h5"
    made = run(folder, "pack", "--set", "packing.kind=triangular", "--set", f"packing.grains={ROW * rows}", "--set",
               f"packing.width={ROW}", "--set", f"packing.pressure={PRESSURE}", "--set", f"packing.friction={friction}",
               "--set", f"packing.poisson={poisson}", "-o", name)
    return float(made["height"]), float(run(folder, "moduli", name)["C22"])


def close(value, expected, what):
    print(f"{what}: {value:.10g}, expected {expected:.10g}")
    # lengths, areas and stiffnesses each shift by some multiples of the overlap
    assert abs(value / expected - 1) < 10 * OVERLAP, what


def main():
    with tempfile.TemporaryDirectory(prefix="sonopack-lattice-") as folder:
        for friction, poisson in ((0, 0), (0.5, 0), (0.5, 0.3)):
            (h1, c1), (h2, c2) = (lattice(pathlib.Path(folder), rows, friction, poisson) for rows in (10, 30))
            row = (h2 / c2 - h1 / c1) / 20  # compliance of a row
            walls = h1 / c1 - 9 * row
            eta = (1 - poisson) / (1 - poisson / 2) if friction else 0
            # density of spheres: one of mass pi/6 on 1 x sqrt(3)/2 in a layer of thickness 1
            speed = math.sqrt((h2 - h1) / 20 / row / (math.pi / 6 / (math.sqrt(3) / 2)))
            theory = 3 ** (19 / 12) / (2**1.5 * math.pi**0.5) * math.sqrt(1 + eta / 3) * PRESSURE ** (1 / 6)
            name = f"friction {friction}, Poisson {poisson}"
            close(speed, theory, f"{name}: speed")
            # a rigid wall: k = 2 E* sqrt(R n) under the force p d^2; between rows 3^(7/6)/4 p^(1/3) (section V B)
            close(row / (walls / 2), 4 / 3 ** (5 / 6) / (1 + eta / 3), f"{name}: wall over row")


if __name__ == "__main__":
    main()
