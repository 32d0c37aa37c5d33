"""From arrays of positions and contacts to a signal: grains that another program, or a camera, has found.

The arrays here are those of a triangular lattice of disks, whose every number is known.
"""
import numpy as np
import numpy.typing as npt

import sonopack

ROWS, COLUMNS, OVERLAP = 20, 12, 1e-3
A = 1 - OVERLAP  # distance of neighbours [d]
FORCE = OVERLAP**1.5 / 3  # of two equal disks, by Hertz's law [E* d^2]
PRESSURE = np.sqrt(3) * FORCE / A  # two oblique contacts carry the load of a wall of length A [E*]
WALL_OVERLAP = (0.75 * PRESSURE * A / np.sqrt(0.5)) ** (2 / 3)


def lattice() -> tuple[npt.NDArray[np.float64], tuple[float, float]]:
    """Centres [n][2], and the box: the period along x, and the height between the walls."""
    row, column = np.divmod(np.arange(ROWS * COLUMNS), COLUMNS)
    x = (column + 0.5 * (row % 2)) * A
    y = 0.5 - WALL_OVERLAP + row * A * np.sqrt(0.75)
    return np.stack([x, y], axis=1), (COLUMNS * A, y[-1] + 0.5 - WALL_OVERLAP)


def touching(x: npt.NDArray[np.float64], box: tuple[float, float]) -> dict[str, npt.NDArray[np.int64]]:
    """Pairs of disks that overlap, and disks that touch a wall. (For many grains: scipy.spatial.cKDTree.)"""
    away = x[None] - x[:, None]
    away[..., 0] -= box[0] * np.round(away[..., 0] / box[0])
    i, j = np.nonzero(np.triu(np.hypot(away[..., 0], away[..., 1]) < 1, 1))
    low, high = np.nonzero(x[:, 1] < 0.5)[0], np.nonzero(x[:, 1] > box[1] - 0.5)[0]
    return {"i": np.concatenate([i, low, high]),
            "j": np.concatenate([j, np.full(len(low), sonopack.BOTTOM), np.full(len(high), sonopack.TOP)])}


def main() -> None:
    x, box = lattice()
    packing = sonopack.Packing.from_arrays(x, np.full(len(x), 0.5), touching(x, box), box=box, pressure=PRESSURE,
                                           friction=0.5)
    print(packing)
    print(f"{len(packing.contacts)} contacts; a grain is out of balance by {packing.audit().force_residual:.1g} p d^2")
    network = packing.network()
    signal = network.signal()
    front = signal.front()
    print(f"the front arrives at t10 = {front.t10:.3f} and is {front.width:.3f} wide, error of F {signal.error:.1g}")


if __name__ == "__main__":
    main()
