"""Writes the samples of programs that are not Debian packages that run here, in the forms that their manuals describe,
from the layer that LAMMPS made (lammps/layer_*.dump): LIGGGHTS, MercuryDPM, extended XYZ, CSV, and a photoelastic
experiment, whose lengths are rounded to 0.01 pixel and forces to 1e-6 N. Run it here: python3 make_by_hand.py."""
import math
import os

WIDTH, TOP = 8.0, 8.8661880014055292


def dump(path):
    with open(path) as f:
        lines = f.read().split("\n")
    at = next(k for k, line in enumerate(lines) if line.startswith(("ITEM: ATOMS", "ITEM: ENTRIES")))
    return lines[at].split()[2:], [line.split() for line in lines[at + 1:] if line]


names, rows = dump("lammps/layer_grains.dump")
grains = [dict(zip(names, row)) for row in rows if row[1] == "1"]
by_id = {g["id"]: g for g in grains}
names, rows = dump("lammps/layer_contacts.dump")
contacts = []  # ids, n from 1 to 2, dist, fn, ft on 1: as texts where LAMMPS wrote them
for row in rows:
    c = dict(zip(names, row))
    i, j = c["c_sp_id[1]"], c["c_sp_id[2]"]
    if i not in by_id or j not in by_id or float(c["c_sp_contact[2]"]) == 0:
        continue
    d = [float(by_id[j][a]) - float(by_id[i][a]) for a in "xy"]
    d[0] -= WIDTH * round(d[0] / WIDTH)
    dist = math.hypot(*d)
    contacts.append((i, j, [d[0] / dist, d[1] / dist], dist, c["c_sp_contact[2]"], c["c_sp_contact[3]"], c["c_sp_contact[4]"]))
walls = []  # id, force on the grain, point, side
for g in grains:
    for side, fix in ((-1, "f_floor"), (1, "f_roof")):
        if float(g[fix + "[1]"]):
            walls.append((g["id"], g[fix + "[2]"], g[fix + "[3]"], [float(g[fix + "[5]"]), float(g[fix + "[6]"])], side))


def folder(name):
    os.makedirs(name, exist_ok=True)
    return name


def write(path, lines):
    with open(path, "w") as f:
        f.write("\n".join(lines) + "\n")


def overlap(i, j, dist):
    return repr(float(by_id[i]["radius"]) + float(by_id[j]["radius"]) - dist)


# ---- LIGGGHTS: dump custom, and dump local of compute pair/gran/local id force force_normal force_tangential delta ----
to = folder("liggghts")
box = ["ITEM: BOX BOUNDS pp ff pp", f"0 {WIDTH:g}", f"0 {TOP!r}", "-0.5 0.5"]
write(f"{to}/grains.dump", ["ITEM: TIMESTEP", "400000", "ITEM: NUMBER OF ATOMS", str(len(grains)), *box,
                            "ITEM: ATOMS id type x y z radius mass "]
      + [" ".join(g[k] for k in ("id", "type", "x", "y", "z", "radius", "mass")) + " " for g in grains])
lines = ["ITEM: TIMESTEP", "400000", "ITEM: NUMBER OF ENTRIES", str(len(contacts)), *box,
         "ITEM: ENTRIES " + " ".join(f"c_sp_gran[{k}]" for k in range(1, 14)) + " "]
for i, j, n, dist, fn, fx, fy in contacts:
    normal = [-float(fn) * n[0], -float(fn) * n[1]]
    total = [repr(normal[0] + float(fx)), repr(normal[1] + float(fy)), "0"]
    lines.append(" ".join([i, j, "0"] + total + [repr(normal[0]), repr(normal[1]), "0", fx, fy, "0", overlap(i, j, dist)]) + " ")
write(f"{to}/contacts.dump", lines)
write(f"{to}/walls.dump", ["ITEM: TIMESTEP", "400000", "ITEM: NUMBER OF ENTRIES", str(len(walls)), *box,
                           "ITEM: ENTRIES " + " ".join(f"c_sp_wall[{k}]" for k in range(1, 7)) + " "]
      + [f"0 0 {i} {fx} {fy} 0 " for i, fx, fy, _, _ in walls])

# ---- MercuryDPM: .data with a line 'N time xmin ymin zmin xmax ymax zmax' and 14 columns; .fstat with 16 ------------
to = folder("mercury")
head = f"{len(grains)} 400 0 0 -0.5 {WIDTH:g} {TOP!r} 0.5"
write(f"{to}/layer.data", [head] + [f"{g['x']} {g['y']} 0 0 0 0 {g['radius']} 0 0 0 0 0 0 0" for g in grains])
index = {g["id"]: k for k, g in enumerate(grains)}
lines = ["# 400 0", f"# 0 0 -0.5 {WIDTH:g} {TOP!r} 0.5", "# 0.4 0.6 0 0 0 0"]
for i, j, n, dist, fn, fx, fy in contacts:
    ft = math.hypot(float(fx), float(fy))
    t = [float(fx) / ft, float(fy) / ft] if ft else [0, 0]
    at = [float(by_id[i]["x"]) + n[0] * float(by_id[i]["radius"]), float(by_id[i]["y"]) + n[1] * float(by_id[i]["radius"])]
    lines.append(f"400 {index[i]} {index[j]} {at[0]!r} {at[1]!r} 0 {overlap(i, j, dist)} 0 {fn} {ft!r} {-n[0]!r} {-n[1]!r} 0 "
                 f"{t[0]!r} {t[1]!r} 0")
for i, fx, fy, at, side in walls:
    depth = float(by_id[i]["radius"]) - (float(by_id[i]["y"]) if side < 0 else TOP - float(by_id[i]["y"]))
    lines.append(f"400 {index[i]} {-1 if side < 0 else -2} {at[0]!r} {at[1]!r} 0 {depth!r} 0 {abs(float(fy))!r} "
                 f"{abs(float(fx))!r} 0 {-side} 0 {math.copysign(1, float(fx)):g} 0 0")
write(f"{to}/layer.fstat", lines)

# ---- extended XYZ, as ASE and OVITO write it; contacts as CSV -------------------------------------------------------
to = folder("xyz")
write(f"{to}/layer.xyz", [str(len(grains)), f'Lattice="{WIDTH:g} 0 0 0 {TOP!r} 0 0 0 1" Origin="0 0 -0.5" '
                          'Properties=species:S:1:id:I:1:pos:R:3:radius:R:1 pbc="T F T"']
      + [f"Gl {g['id']} {g['x']} {g['y']} {g['z']} {g['radius']}" for g in grains])
to = folder("csv")
write(f"{to}/grains.csv", ["id,x,y,radius"] + [f"{g['id']},{g['x']},{g['y']},{g['radius']}" for g in grains])
write(f"{to}/contacts.csv", ["id1,id2,fn,ft_x,ft_y"] + [",".join([i, j, fn, fx, fy]) for i, j, _, _, fn, fx, fy in contacts])
write(f"{to}/walls.csv", ["id,f_x,f_y"] + [f"{i},{fx},{fy}" for i, fx, fy, _, _ in walls])

# ---- photoelastic disks: pixels and newtons -------------------------------------------------------------------------
PIXELS, NEWTONS = 120.0, 2000.0
to = folder("photoelastic")
edge = {w[0] for w in walls}  # and the grains at the sides, which touched across the period that an experiment has not


def across(i, j):
    return abs(float(by_id[i]["x"]) - float(by_id[j]["x"])) > WIDTH / 2


edge |= {k for i, j, *_ in contacts if across(i, j) for k in (i, j)}
lines = ["frame,id,x,y,radius,boundary"]
for frame in (1, 2):
    for g in grains:
        lines.append(f"{frame},{g['id']},{PIXELS * float(g['x']):.2f},{PIXELS * float(g['y']):.2f},"
                     f"{PIXELS * float(g['radius']):.2f},{int(g['id'] in edge)}")
write(f"{to}/particles.csv", lines)
lines = ["frame,id1,id2,Ft,Fn"]
for frame in (1, 2):
    for i, j, n, dist, fn, fx, fy in contacts:
        ft = -n[1] * float(fx) + n[0] * float(fy)
        if not across(i, j):
            lines.append(f"{frame},{i},{j},{NEWTONS * frame * ft:.6f},{NEWTONS * frame * float(fn):.6f}")
write(f"{to}/contacts.csv", lines)
