"""Transport of energy: the command's numbers bit for bit, and balances that hold."""

import numpy as np
from common import equal, raised, table

import sonopack


def network():
    scene = sonopack.Scene(packing={"grains": 100, "width": 12})
    sonopack.Packing.make(scene, seed=3).save("P.h5")
    return sonopack.Packing.read("P.h5").network()


def test_command():
    net = network()
    t, s = table("transport", "P.h5", "--at", "0.4", "--axis", "x"), net.diffusivity(0.4, axis=0)
    for name, value in (("D", s.d), ("D_err", s.d_err), ("shift", s.d_shift), ("half", s.d_half)):
        equal(t, name, value if not np.isnan(s.d) else np.nan)
    t, k = table("transport", "P.h5", "--at", "0.4", "--quantity", "kubo"), net.kubo(net.modes(solver="dense"), 0.4)
    for name, value in (("D", k.d), ("D_err", k.d_err), ("speed", k.speed), ("speed_err", k.speed_err)):
        equal(t, name, value)
    assert k.d > 0, k
    t, p = table("transport", "P.h5", "--at", "0.4", "--quantity", "split"), net.split(0.4)
    equal(t, "rotation", p.rest.rotation)
    equal(t, "pulse_along_err", p.pulse_err.along)


def test_balance():
    """What leaves the lower half arrives in the upper one."""
    net = network()
    u, v = np.zeros((net.n, net.dof)), np.zeros((net.n, net.dof))
    middle = 0.5 * net.x[:, 1].max()
    below = net.x[:, 1] < middle
    v[below, 1] = 1.0

    def part(u, v):
        e = net.energy(u, v)
        return sum(e[name][below].sum() for name in e.dtype.names), sum(e[name].sum() for name in e.dtype.names)

    nodes, weights = np.polynomial.legendre.leggauss(30)
    before, all_of_it = part(u, v)
    flow = 0.0
    for node, weight in zip(nodes, weights):
        j = net.flux(*net.advance(2.0 * (1 + node), u, v), [middle])[0]
        flow += 2.0 * weight * sum(j[name] for name in j.dtype.names)
    after, still = part(*net.advance(4.0, u, v))
    assert abs(still / all_of_it - 1) < 1e-12, still
    assert abs(before - after - flow) < 1e-9 * all_of_it and flow > 1e-3 * all_of_it, (before, after, flow)
    raised(ValueError, net.energy, u[:3], v)
    raised(sonopack.InvalidInput, net.spread, -1.0)
