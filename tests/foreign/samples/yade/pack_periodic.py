# A packing in a cell that is periodic along all axes: compressed, sheared, and brought to rest.
#   yade -n -x -j1 pack_periodic.py
import math
import sys; sys.path.insert(0, ".")
from yade_tables import write_tables

L, rate = 5.2, 2e-3
O.periodic = True
O.cell.setBox(L, L, L)
m = O.materials.append(FrictMat(young=1, poisson=0.2, frictionAngle=math.atan(.5), density=1))
for k in range(64):
    r = .5 * (1 + .15 * math.sin(2.399963 * k * k))
    cell = (k % 4, k // 4 % 4, k // 16)
    O.bodies.append(sphere([(i + .5) * L / 4 + .03 * math.sin(11.7 * k * k * (n + 1)) for n, i in enumerate(cell)], r,
                           material=m))
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb()], verletDist=.1),
    InteractionLoop([Ig2_Sphere_Sphere_ScGeom()], [Ip2_FrictMat_FrictMat_MindlinPhys(betan=.5, betas=.5)],
                    [Law2_ScGeom_MindlinPhys_Mindlin()]),
    NewtonIntegrator(damping=.2, kinSplit=False)]
O.dt = .2
small = 3.75  # edge of the cell at the end
O.cell.velGrad = Matrix3(-rate, 0, 0, 0, -rate, 0, 0, 0, -rate)
O.run(int(round(math.log(L / small) / rate / O.dt)), True)
O.cell.velGrad = Matrix3(0, rate, 0.5 * rate, 0, 0, -0.5 * rate, 0, 0, 0)
O.run(int(round(0.2 / rate / O.dt)), True)
O.cell.velGrad = Matrix3.Zero
for _ in range(60):
    O.run(5000, True)
    worst = max(O.forces.f(b.id).norm() / b.state.mass for b in O.bodies)
    print(O.iter, worst, flush=True)
    if worst < 3e-12:
        break
write_tables('grains.tsv', 'contacts.tsv', friction=0.5)
