# A packing between two plates in a periodic box, compressed by the upper plate, to rest.
#   yade -n -x -j1 pack.py
import math
import sys; sys.path.insert(0, ".")
from yade_tables import write_tables

L, p = 4.0, 1e-4
O.periodic = True
O.cell.setBox(L, L, 40)
m = O.materials.append(FrictMat(young=1, poisson=0.2, frictionAngle=math.atan(.5), density=1))
plates = [O.bodies.append(box((L / 2, L / 2, z), (10 * L, 10 * L, .5), fixed=True, material=m)) for z in (4.5, 15.2)]
k = 0
for c in range(7):
    for b in range(3):
        for a in range(3):
            k += 1
            r = .5 * (1 + .15 * math.sin(2.399963 * k * k))
            x = [(i + .5) * 4 / 3 + .03 * math.sin(11.7 * k * k * (n + 1)) for n, i in enumerate((a, b, c))]
            O.bodies.append(sphere((x[0], x[1], x[2] + 5.1), r, material=m))
grains = [b.id for b in O.bodies if isinstance(b.shape, Sphere)]
for i in grains:
    O.bodies[i].state.vel = (.01 * math.sin(17.3 * i * i), .01 * math.sin(11.7 * i * i), 0)
lid = O.bodies[plates[1]]
lid.state.blockedDOFs = 'xyXYZ'
lid.state.mass = L * L
O.forces.setPermF(lid.id, (0, 0, -p * L * L))
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Box_Aabb()], verletDist=.1, allowBiggerThanPeriod=True),
    InteractionLoop([Ig2_Sphere_Sphere_ScGeom(), Ig2_Box_Sphere_ScGeom()],
                    [Ip2_FrictMat_FrictMat_MindlinPhys(betan=.5, betas=.5)],
                    [Law2_ScGeom_MindlinPhys_Mindlin()]),
    NewtonIntegrator(damping=.2, kinSplit=False)]
O.dt = .2
for _ in range(100):
    O.run(5000, True)
    worst = max(O.forces.f(i).norm() / O.bodies[i].state.mass for i in grains)
    print(O.iter, lid.state.pos[2], worst, flush=True)
    if worst < 3e-12 and O.iter > 10000:
        break
write_tables('grains.tsv', 'contacts.tsv', friction=.5)
from yade import export
export.text('packing.xyzr')
export.textExt('packing_id.txt', format='id_x_y_z_r_matId')
