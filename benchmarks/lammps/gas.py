#!/usr/bin/python3
"""A loose gas of polydisperse spheres between two walls as LAMMPS data: gas.py GRAINS WIDTH PRESSURE SEED FILE.

Units of sonopack: mean diameter 1, density 1, E* = 1; diameters uniform in 0.8 .. 1.2. Each grain has its own cell of a
square grid of spacing 1.25 (area fraction 0.5) and velocities up to sqrt(p). This gas is denser than sonopack's, so
LAMMPS has less to compress. Atom GRAINS + 1, of type 2, is the piston: its y is the height of the wall, its mass that
of a layer.
"""
import math
import sys

import numpy as np

CELL, LARGEST = 1.25, 1.2


def write_gas(grains, width, pressure, seed, path):
    random = np.random.default_rng(seed)
    columns = int(width / CELL)
    rows = math.ceil(grains / columns)
    cell = random.permutation(rows * columns)[:grains]
    diameter = random.uniform(0.8, LARGEST, grains)
    corner = np.stack((cell % columns * (width / columns), cell // columns * CELL), axis=1)
    room = np.stack((width / columns - diameter, CELL - diameter), axis=1)
    centre = corner + 0.5 * diameter[:, None] + room * random.uniform(0.02, 0.98, (grains, 2))
    velocity = math.sqrt(pressure) * random.uniform(-1, 1, (grains, 2))
    height = rows * CELL
    with open(path, "w", encoding="utf-8") as out:
        out.write(f"# {grains} grains, seed {seed}\n\n{grains + 1} atoms\n2 atom types\n\n0 {width!r} xlo xhi\n"
                  f"-1 {height + 20!r} ylo yhi\n-0.7 0.7 zlo zhi\n\nAtoms # sphere\n\n")
        for i, (d, (x, y)) in enumerate(zip(diameter, centre), 1):
            out.write(f"{i} 1 {d:.17g} 1 {x:.17g} {y:.17g} 0\n")
        # diameter 1: mass is density times pi/6
        out.write(f"{grains + 1} 2 1 {width / (math.pi / 6):.17g} {width / 2:.17g} {height:.17g} 0\n\nVelocities\n\n")
        for i, (vx, vy) in enumerate(velocity, 1):
            out.write(f"{i} {vx:.17g} {vy:.17g} 0 0 0 0\n")
        out.write(f"{grains + 1} 0 0 0 0 0 0\n")


if __name__ == "__main__":
    if len(sys.argv) != 6:
        sys.exit(__doc__)
    write_gas(int(sys.argv[1]), float(sys.argv[2]), float(sys.argv[3]), int(sys.argv[4]), sys.argv[5])
