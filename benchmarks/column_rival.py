#!/usr/bin/python3
"""The tapped column with general tools: Newton's equations (19) of Blackmore et al. (J. Mech. Mater. Struct. 6, 2011)
by the solvers of SciPy's solve_ivp, restarted where the velocity of the floor jumps.

    column_rival.py METHOD RTOL ALPHA [--particles N] [--period T] [--taps n] [--limit s] [--strobe TRANSIENT]

METHOD: RK45, DOP853, LSODA, Radau. ALPHA: tanh(ALPHA w) replaces the sign of the opening velocity; inf: the sign
itself. Times exclude the start of Python. The comments give the calls of the right-hand side, CPU seconds and the time
reached. The rows are t y1 .. yN every T/100, or with --strobe at .99T of each tap after the transient ones.
"""
import argparse
import math
import time

import numpy as np
from scipy.integrate import DOP853, LSODA, RK45, Radau

METHODS = {"RK45": RK45, "DOP853": DOP853, "LSODA": LSODA, "Radau": Radau}
GRAVITY, AMPLITUDE, E, FREQUENCY = 980.67, 1.06, 0.09, 7.5  # m = r = 1


class Column:
    def __init__(self, particles, alpha):
        self.n, self.alpha, self.stiffness = particles, alpha, 2 * particles * GRAVITY
        self.distance = np.full(particles, 2.0)
        self.distance[0] = 1
        self.below, self.speed = np.empty(particles), np.empty(particles)
        self.calls, self.tapping, self.begin = 0, False, 0.0

    def rest(self):
        k, m = np.arange(1, self.n + 1), GRAVITY / self.stiffness
        return np.concatenate([2 * k - 1 - k * (2 * self.n - k + 1) / 2 * m, np.zeros(self.n)])

    def slope(self, t, state):
        self.calls += 1
        y, v = state[:self.n], state[self.n:]
        phase, omega = 2 * math.pi * FREQUENCY * (t - self.begin), 2 * math.pi * FREQUENCY
        self.below[0] = AMPLITUDE * math.sin(phase) if self.tapping else 0
        self.speed[0] = AMPLITUDE * omega * math.cos(phase) if self.tapping else 0
        self.below[1:], self.speed[1:] = y[:-1], v[:-1]
        w = v - self.speed
        sign = np.sign(w) if math.isinf(self.alpha) else np.tanh(self.alpha * w)
        force = self.stiffness * (1 - E * sign) * np.maximum(self.distance - (y - self.below), 0)
        out = np.empty(2 * self.n)
        out[:self.n] = v
        out[self.n:] = force - GRAVITY
        out[self.n:-1] -= force[1:]
        return out


def pieces(taps, period):
    """Between jumps of the floor's velocity."""
    for k in range(taps):
        yield k * period, k * period + 0.5 / FREQUENCY, True
        yield k * period + 0.5 / FREQUENCY, (k + 1) * period, False


def solve(column, make, rtol, taps, period, rows, limit):
    """Positions at the rows reached, the time reached, and the reason for stopping."""
    state, found, begun = column.rest(), [], time.process_time()
    for begin, end, column.tapping in pieces(taps, period):
        if column.tapping:
            column.begin = begin
        solver = make(column.slope, begin, state, end, rtol=rtol, atol=rtol)
        while solver.status == "running":
            why = solver.step()
            if solver.status == "failed":
                return found, solver.t, why
            if len(found) < len(rows) and rows[len(found)] <= solver.t:
                dense = solver.dense_output()
                while len(found) < len(rows) and rows[len(found)] <= solver.t:
                    found.append(dense(rows[len(found)])[:column.n])
            if time.process_time() - begun > limit:
                return found, solver.t, "limit"
        state = solver.y
    return found, solver.t, "end"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("method", choices=METHODS)
    parser.add_argument("rtol", type=float)
    parser.add_argument("alpha", type=float)
    parser.add_argument("--particles", type=int, default=5)
    parser.add_argument("--period", type=float, default=1)
    parser.add_argument("--taps", type=int, default=4)
    parser.add_argument("--limit", type=float, default=60)
    parser.add_argument("--strobe", type=int, metavar="TRANSIENT")
    given = parser.parse_args()
    if given.strobe is None:
        rows = np.round(np.arange(100 * given.taps + 1) * 0.01, 12) * given.period
    else:
        rows = (np.arange(given.strobe, given.taps) + 0.99) * given.period
    column, begun = Column(given.particles, given.alpha), time.process_time()
    found, reached, why = solve(column, METHODS[given.method], given.rtol, given.taps, given.period, rows, given.limit)
    print(f"# calls = {column.calls}\n# cpu = {time.process_time() - begun:.6g}\n# reached = {reached:.9g}")
    print(f"# stopped: {why}")
    print("t", *(f"y{k + 1}" for k in range(given.particles)), sep="\t")
    for t, y in zip(rows, found):
        print(f"{t:.17g}", *(f"{x:.17g}" for x in y), sep="\t")


if __name__ == "__main__":
    main()
