"""Packings in periodic cells and boxes for the tests: lattices at rest, made here, not by the program. They are
dictionaries of numpy arrays in the program's units (d, E*); write_packing writes one as HDF5."""
import itertools

import h5py
import numpy as np

BOTTOM, TOP, LEFT, RIGHT, FRONT, BACK = -1, -2, -3, -4, -5, -6
OVERLAP = 0.01


def hertz(radius, overlap):
    """Force of two equal grains in contact, E12 = 1/2 and R12 = R/2; at a rigid wall E12 = 1 and R12 = R."""
    return 2 / 3 * np.sqrt(radius / 2) * overlap**1.5


def wall_overlap(radius, force):
    return (force / (4 / 3 * np.sqrt(radius))) ** (2 / 3)


def matrix_of(box, tilt):
    """Lattice vectors as rows."""
    m = np.diag(box).astype(float)
    m[1, 0] = tilt[0]
    if len(box) == 3:
        m[2, :2] = tilt[1:]
    return m


def links(x, matrix, reach):
    """Pairs i < j closer than reach, each by its nearest image: i, j, and the vector between them."""
    dim = len(matrix)
    shifts = np.array(list(itertools.product((-1, 0, 1), repeat=dim))) @ matrix
    out = []
    for i in range(len(x)):
        for j in range(i + 1, len(x)):
            d = x[j] - x[i] + shifts
            near = d[np.argmin((d**2).sum(axis=1))]
            if near @ near < reach**2:
                out.append((i, j, near))
    return out


def mean_pressure(p):
    """Trace of the stress over the dimension: sum F.r / (dim V)."""
    reach = [p["r"][i] + (p["r"][j] if j >= 0 else 0) - o for (i, j), o in zip(p["pairs"], p["overlap"])]
    return float(np.sum(p["fn"] * np.array(reach))) / (p["dim"] * abs(np.linalg.det(matrix_of(p["box"], p["tilt"]))))


def finish(p, contacts):
    contacts.sort(key=lambda c: (-min(c[1], 0), c[0], c[1]))
    p["pairs"] = np.array([c[:2] for c in contacts], dtype=np.int32)
    p["normal"] = np.array([c[2] for c in contacts], dtype=float)
    p["overlap"] = np.array([c[3] for c in contacts])
    p["fn"] = np.array([c[4] for c in contacts])
    p["pressure"] = mean_pressure(p)
    return p


def lattice(dim, tilt=0.0, cells=6):
    """Rows of equal grains: a square or simple cubic lattice of tangent rows, where each row lies `tilt` of a grain
    beside the one below. Every grain has the same surroundings, so that all forces balance."""
    spacing = 1 - OVERLAP
    step = np.eye(dim) * spacing
    step[1, 0] = tilt
    step[1, 1] = np.sqrt(spacing**2 - tilt**2)
    if dim == 3:
        step[2, 1] = tilt
        step[2, 2] = np.sqrt(spacing**2 - tilt**2)
    matrix = step * cells
    tilts = np.array([matrix[1, 0], matrix[2, 0] if dim == 3 else 0, matrix[2, 1] if dim == 3 else 0])
    x = np.array(list(itertools.product(range(cells), repeat=dim)), dtype=float) @ step + 1e-3 * matrix.sum(axis=0)
    p = {"dim": dim, "cell": "periodic", "x": x, "r": np.full(len(x), 0.5), "box": np.diag(matrix).copy(), "tilt": tilts,
         "gravity": 0.0}
    return finish(p, [(i, j, d / np.linalg.norm(d), 1 - np.linalg.norm(d), hertz(0.5, 1 - np.linalg.norm(d)))
                      for i, j, d in links(x, matrix, 1)])


def box_of_disks(columns=5, rows=4):
    """A square lattice in two dimensions between four rigid walls."""
    force = hertz(0.5, OVERLAP)
    spacing, inset = 1 - OVERLAP, 0.5 - wall_overlap(0.5, force)
    x = np.array([(inset + spacing * a, inset + spacing * b) for b in range(rows) for a in range(columns)])
    box = np.array([2 * inset + spacing * (columns - 1), 2 * inset + spacing * (rows - 1)])
    contacts = [(i, j, d / np.linalg.norm(d), OVERLAP, force)
                for i, j, d in links(x, 1e3 * np.eye(2), 0.999)]
    for wall, axis, outer in ((BOTTOM, 1, -1), (TOP, 1, 1), (LEFT, 0, -1), (RIGHT, 0, 1)):
        at = x[:, axis] if outer < 0 else box[axis] - x[:, axis]
        normal = np.zeros(2)
        normal[axis] = outer
        contacts += [(i, wall, normal, 0.5 - at[i], force) for i in np.flatnonzero(at < 0.5)]
    return finish({"dim": 2, "cell": "box", "x": x, "r": np.full(len(x), 0.5), "box": box, "tilt": np.zeros(3),
                   "gravity": 0.0}, contacts)


def write_packing(path, p):
    """The layout of docs/file-format.md, written by h5py alone."""
    dim, n = p["dim"], len(p["x"])
    walls = p["pairs"][:, 1] < 0
    with h5py.File(path, "w") as f:
        f.attrs["made"] = np.bytes_("by hand")
        box = f.create_group("particles/grains/box")
        box.attrs["dimension"] = np.int32(dim)
        box.attrs["boundary"] = np.array([b"none" if p["cell"] == "box" else b"periodic"] * dim)
        box["edges"] = matrix_of(p["box"], p["tilt"]) if np.any(p["tilt"]) else p["box"]
        f["particles/grains/position/value"] = p["x"][np.newaxis]
        f["particles/grains/radius"] = p["r"]
        f["connectivity/contacts"] = p["pairs"][~walls]
        if walls.any():
            f["sonopack/walls/contacts"] = p["pairs"][walls]
        s = f.require_group("sonopack")
        s.attrs["format"] = np.int32(3)
        s["cell"], s["wall"] = np.bytes_(p["cell"]), np.bytes_("rigid")
        s["dimension"] = np.int32(dim)
        for name, value in (("gravity", p["gravity"]), ("pressure", p["pressure"]), ("friction", p.get("friction", 0.0)),
                            ("poisson", 0.0), ("residual", np.nan)):
            s[name] = float(value)
        s["seed"], s["steps"] = np.uint64(0), np.int64(0)
        s["contacts/normal"], s["contacts/overlap"] = p["normal"], p["overlap"]
        s["contacts/normal_force"] = p["fn"]
        s["contacts/tangential_force"] = np.zeros((len(p["fn"]), dim))
    return path
