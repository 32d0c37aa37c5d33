"""Writes a packing of Yade as sonopack's two tables, with all digits: for scripts that run inside of Yade.

    from yade_tables import write_tables
    write_tables('grains.tsv', 'contacts.tsv', friction=0.5)

Then `sonopack convert grains.tsv P.h5 --contacts contacts.tsv`. Spheres are grains. Boxes, walls and facets that
spheres touch are the walls at the bottom and the top of the packing, by the side from which they push along the axis
`up`. Where spheres touch none of these in a periodic cell, the packing is periodic along all axes, sheared or not.
Contacts are those of ScGeom with forces normalForce and shearForce, such as MindlinPhys and FrictPhys. Lengths are
divided by the mean diameter d, forces by E* d^2 with E* = E/(1 - nu^2), both from the spheres' material, whose density
is the unit of density. The material itself goes into the tables when its numbers are in SI units.
"""
from yade import O, Sphere
import math


def _spheres():
    return [b for b in O.bodies if b is not None and isinstance(b.shape, Sphere)]


def _check(spheres):
    first = spheres[0].material
    for b in spheres:
        m = b.material
        if (m.young, m.poisson, m.density) != (first.young, first.poisson, first.density):
            raise ValueError(f"sphere {b.id} is of another material than sphere {spheres[0].id}: must be one material")
    return first


def _tilt():
    """xy, xz and yz: components of the second and third lattice vector, which are columns of Yade's matrix."""
    h = O.cell.hSize
    if any(abs(h[a, b]) > 1e-12 * h[b, b] for a, b in ((1, 0), (2, 0), (2, 1))):
        raise ValueError("the first vector of the cell must lie along x, the second in the plane of x and y")
    return [h[a, b] if abs(h[a, b]) > 1e-12 * h[a, a] else 0.0 for a, b in ((0, 1), (0, 2), (1, 2))]


def _periodic_box(axes, rows, spheres, d):
    """The keys of a cell without walls: edges, tilt, and the mean of the normal stresses, sum of F.r over dim V."""
    dimension, tilt = len(axes), _tilt()
    if axes != sorted(axes) and any(tilt):
        raise ValueError("a sheared cell needs the last axis up")
    edges = [O.cell.hSize[a, a] / d for a in axes]
    radius = {b.id: b.shape.radius / d for b in spheres}
    pushed = sum(r[3 + dimension] * (radius[r[0]] + radius[r[1]] - r[2 + dimension]) for r in rows)
    box = dict(zip(("width", "depth", "height") if dimension == 3 else ("width", "height"), edges))
    steps = tilt if dimension == 3 else tilt[:1]
    box.update((name, value / d) for name, value in zip(("xy", "xz", "yz"), steps) if value)
    return {"cell": "periodic", **box, "pressure": pushed / (dimension * math.prod(edges))}


def _stiffness(phys, hertz):
    """Stiffnesses of a contact that is not Hertz's."""
    return [] if hertz else [phys.kn, phys.ks]


def write_tables(grains, contacts, friction, up=2, dimension=3, si=False, bottom=None, top=None):
    """Writes both tables. up: axis of the walls' normals, 0, 1 or 2. dimension=2: spheres in the plane z = constant,
    with up = 1. si: the simulation is in m, kg, s. bottom, top: positions of the walls' surfaces; by default where the
    spheres touch them."""
    spheres = _spheres()
    material = _check(spheres)
    axes = [a for a in range(dimension) if a != up] + [up]
    d = sum(2 * b.shape.radius for b in spheres) / len(spheres)
    modulus = material.young / (1 - material.poisson**2)
    force = modulus * d * d
    real = [i for i in O.interactions if i.isReal]
    hertz = all(type(i.phys).__name__ == "MindlinPhys" for i in real)
    is_sphere = {b.id for b in spheres}
    rows, faces, kind = [], {"bottom": [], "top": []}, []
    for i in real:
        if i.id1 not in is_sphere and i.id2 not in is_sphere:
            continue
        # the forces act on the second body, along the normal from the first to the second
        first, second = (i.id1, i.id2) if i.id1 in is_sphere else (i.id2, i.id1)
        sign = 1 if first == i.id1 else -1
        n = [sign * i.geom.normal[a] for a in axes]
        fn = i.phys.normalForce.dot(i.geom.normal)
        shear = i.phys.shearForce - i.phys.shearForce.dot(i.geom.normal) * i.geom.normal  # Yade turns it nearly exactly
        ft = [-sign * shear[a] / force for a in axes]
        name, depth = second, i.geom.penetrationDepth
        if second not in is_sphere:
            if abs(n[-1]) < 0.7:
                continue  # a side wall
            name = "bottom" if n[-1] < 0 else "top"
            body = O.bodies[first]
            faces[name].append(body.state.pos[up] + (body.shape.radius - depth) * (1 if name == "top" else -1))
            star = math.sqrt(body.shape.radius) * depth**1.5 * 4 / 3 * modulus
            kind.append(fn / star if star > 0 else 0)
        rows.append([first, name] + n + [depth / d, fn / force] + ft
                    + [k / (modulus * d) for k in _stiffness(i.phys, hertz)])
    walled = any(r[1] in ("bottom", "top") for r in rows)
    if walled and O.periodic and any(_tilt()):
        raise ValueError("the periodic cell is sheared: must have right angles between walls")
    if not walled and O.periodic and bottom is None and top is None:
        head = {"dimension": dimension, **_periodic_box(axes, rows, spheres, d), "friction": friction,
                "poisson": material.poisson}
        _write(grains, contacts, head, rows, spheres, axes, 0.0, d, hertz, material if si else None)
        return
    low = bottom if bottom is not None else min(faces["bottom"], default=min(b.state.pos[up] - b.shape.radius for b in spheres))
    high = top if top is not None else max(faces["top"], default=max(b.state.pos[up] + b.shape.radius for b in spheres))
    area, box = 1.0, {}
    for key, a in zip(("width", "depth"), axes[:-1]):
        if O.periodic:
            box[key] = O.cell.hSize[a, a] / d
        else:  # wider than all spheres, so that none touches another across the sides
            lows = [b.state.pos[a] - b.shape.radius for b in spheres]
            highs = [b.state.pos[a] + b.shape.radius for b in spheres]
            box[key] = (max(highs) - min(lows)) / d + 0.5
        area *= box[key]
    push = [sum((r[2 + dimension + 1] * r[1 + dimension] - r[2 + dimension + 1 + dimension]) for r in rows if r[1] == s)
            for s in ("bottom", "top")]
    push = [abs(p) for p in push if p]
    if not push:
        raise ValueError("no sphere touches a wall: there is no pressure; must be a packing between walls")
    # Yade's walls have the radius of the sphere that touches them, or none
    wall = "grain" if kind and abs(sorted(kind)[len(kind) // 2] - 0.35355) < 0.01 else "elastic"
    head = {"dimension": dimension, **box, "height": (high - low) / d, "pressure": sum(push) / len(push) / area,
            "friction": friction, "poisson": material.poisson, "wall": wall}
    _write(grains, contacts, head, rows, spheres, axes, low, d, hertz, material if si else None)


def _write(grains, contacts, head, rows, spheres, axes, low, d, hertz, material):
    """The two tables. low: where the axis up begins; material: with its numbers in SI, or None."""
    dimension = len(axes)
    names = ["x", "y", "z"][:dimension]
    with open(grains, "w") as out:
        for key, value in head.items():
            out.write(f"# {key} = {value if isinstance(value, str) else repr(value)}\n")
        if material:
            out.write(f"# material = E={material.young!r},nu={material.poisson!r},rho={material.density!r},d={d!r}\n")
        out.write("\t".join(["id"] + names + ["radius"]) + "\n")
        for b in spheres:
            x = [b.state.pos[a] / d for a in axes]
            x[-1] = (b.state.pos[axes[-1]] - low) / d
            out.write("\t".join([str(b.id)] + [repr(float(v)) for v in x + [b.shape.radius / d]]) + "\n")
    with open(contacts, "w") as out:
        tangent = ["Ftx", "Fty", "Ftz"][:dimension]
        out.write("\t".join(["i", "j"] + ["n" + a for a in names] + ["overlap", "Fn"] + tangent
                            + ([] if hertz else ["kn", "kt"])) + "\n")
        for r in rows:
            out.write("\t".join([str(r[0]), str(r[1])] + [repr(float(v)) for v in r[2:]]) + "\n")
