#!/usr/bin/python3
"""A loose gas of spheres between two walls as LAMMPS data: gas.py DIMENSION GRAINS WIDTH PRESSURE SEED FILE.

Units of sonopack: mean diameter 1, density 1, E* = 1. In 2D diameters are uniform in 0.8 .. 1.2, in 3D all are 1. Each
grain has its own cell of a grid of spacing 1.25 and velocities up to sqrt(p). This gas is denser than sonopack's, so
LAMMPS has less to compress. Atom GRAINS + 1, of type 2, is the piston: its height is that of the wall, its mass that of
a layer.
"""
import math
import sys

import numpy as np

CELL, SMALLEST = 1.25, {2: 0.8, 3: 1.0}


def write_gas(dim, grains, width, pressure, seed, path):
    random = np.random.default_rng(seed)
    columns = int(width / CELL)
    layers = math.ceil(grains / columns ** (dim - 1))
    cell = random.permutation(layers * columns ** (dim - 1))[:grains]
    diameter = random.uniform(SMALLEST[dim], 2 - SMALLEST[dim], grains)
    place = np.zeros((grains, 3))
    velocity = np.zeros((grains, 3))
    for axis in range(dim):
        size = CELL if axis == dim - 1 else width / columns
        index = cell // columns ** axis % (layers if axis == dim - 1 else columns)
        place[:, axis] = index * size + 0.5 * diameter + (size - diameter) * random.uniform(0.02, 0.98, grains)
        velocity[:, axis] = math.sqrt(pressure) * random.uniform(-1, 1, grains)
    height = layers * CELL
    lid = [width / 2] * (dim - 1) + [height] + [0] * (3 - dim)
    mass = width if dim == 2 else math.pi / 4 * width ** 2
    bounds = [f"0 {width!r}"] * (dim - 1) + [f"-1 {height + 20!r}"] + ["-0.7 0.7"] * (3 - dim)
    with open(path, "w", encoding="utf-8") as out:
        out.write(f"# {grains} grains, seed {seed}\n\n{grains + 1} atoms\n2 atom types\n\n")
        for axis, (name, bound) in enumerate(zip("xyz", bounds)):
            out.write(f"{bound} {name}lo {name}hi\n")
        out.write("\nAtoms # sphere\n\n")
        for i, (d, x) in enumerate(zip(diameter, place), 1):
            out.write(f"{i} 1 {d:.17g} 1 {x[0]:.17g} {x[1]:.17g} {x[2]:.17g}\n")
        # diameter 1: mass is density times pi/6
        out.write(f"{grains + 1} 2 1 {mass / (math.pi / 6):.17g} {lid[0]:.17g} {lid[1]:.17g} {lid[2]:.17g}\n\n"
                  "Velocities\n\n")
        for i, v in enumerate(velocity, 1):
            out.write(f"{i} {v[0]:.17g} {v[1]:.17g} {v[2]:.17g} 0 0 0\n")
        out.write(f"{grains + 1} 0 0 0 0 0 0\n")


if __name__ == "__main__":
    if len(sys.argv) != 7:
        sys.exit(__doc__)
    dim, grains, width, pressure, seed, path = sys.argv[1:]
    write_gas(int(dim), int(grains), float(width), float(pressure), int(seed), path)
