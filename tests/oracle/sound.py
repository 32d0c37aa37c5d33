"""Checks of modes, signals, fronts, spectra and sensitivities: sums over the oracle's own modes."""
import math

import numpy as np
from scipy.linalg import expm

from physics import EPS, LONG


class Signal:
    """F(t) = sum of c_n sin(omega_n t)/omega_n, or of c_n cos(omega_n t), and its derivatives."""

    def __init__(self, modes, source, detector, kind="impulse"):
        values, x = modes
        size = np.abs(values).max()
        keep = values > 1e-16 * size
        self.omega = np.sqrt(values[keep])
        self.a, self.b = x.T[keep] @ source, x.T[keep] @ detector
        self.cosine = kind == "displacement"
        self.weight = self.a * self.b / (1 if self.cosine else self.omega)

    def at(self, t, order=0):
        phase = np.outer(np.atleast_1d(t).astype(LONG), self.omega)
        turn = (order + (1 if self.cosine else 0)) * np.arctan(LONG(1)) * 2
        return np.sin(phase + turn) @ (self.weight * self.omega**order)

    def rounding(self, t):
        """Error by the rounding of stiffnesses to doubles, each mode on its own."""
        terms = np.outer(np.atleast_1d(t).astype(LONG), self.omega) + 1
        return 2 * EPS * np.sqrt((terms * self.weight)**2 @ np.ones(len(self.omega)))


def network_signal(case, kind="impulse", **places):
    net = case.network
    source = net.source(kind, **places.get("source", {}))
    return Signal(case.modes, source, net.detector(**places.get("detector", {})), kind)


def modes(case):
    kind = str(case.rng.choice(["impulse", "velocity", "displacement"]))
    if not (table := case.run("modes", "P.h5", f"--source={kind}", "-q")):
        return
    net, values = case.network, case.modes[0]
    top = table.comment("zero_below")
    omega = np.sqrt(np.abs(values))
    zeros = int(np.sum(omega < top))
    loose = case.packing.count - len(net.grains)
    case.compare("zero_modes", table.comment("zero_modes"), zeros + loose * len(net.axes), 0)
    case.compare("carrying", table.comment("carrying"), len(net.grains), 0)
    skip = loose * len(net.axes)
    omega[omega < top] = 0
    case.compare("rows", len(table.rows), skip + len(omega), 0)
    got, error = table["omega"][skip:], table["error"][skip:]
    case.compare("omega", got[zeros:], omega[zeros:], error[zeros:] + 4 * EPS * omega[zeros:])
    case.compare("omega of zero modes", got[:zeros], 0, 1e-300)
    spread = table.comment("residual") * values.max()
    compare_vectors(case, table, skip, zeros, kind, spread + 8 * EPS * values.max())


def compare_vectors(case, table, skip, zeros, kind, spread):
    """Amplitudes and participation, within what the residual lets eigenvectors turn."""
    net, (values, x) = case.network, case.modes
    gap = np.full(len(values), np.inf, dtype=LONG)
    gap[1:] = np.diff(values)
    gap[:-1] = np.minimum(gap[:-1], np.diff(values))
    turn = np.sqrt(2) * spread / np.maximum(gap, 1e-30) + 10 * EPS
    omega = np.sqrt(values[zeros:])
    wall = np.any(net.wall == -1) and np.any(net.wall == -2)
    if wall:
        a, b = net.source(kind), net.detector()
        size = np.linalg.norm(a.astype(float)) * np.linalg.norm(b.astype(float))
        ab = ((x.T @ a) * (x.T @ b))[zeros:] / (1 if kind == "displacement" else omega)
        case.compare("ab", table["ab"][skip + zeros:], ab,
                     2 * size * turn[zeros:] / (1 if kind == "displacement" else omega))
    w = (x**2).reshape(len(net.grains), len(net.axes), -1).sum(1)[:, zeros:]
    part = 1 / (len(net.grains) * (w**2).sum(0))
    bound = 6 * turn[zeros:] * part / (w**2).sum(0)**0.25
    case.compare("participation", table["participation"][skip + zeros:], part, bound)


def dashpots(case, most):
    """The word of --damping of any kind, up to so much of the critical, and what Network.dashpots takes."""
    kind, net = str(case.rng.choice(["zeta", "gamma", "mass"])), case.network
    zeta, side = (round(float(x), 3) for x in case.rng.uniform(0.005, most, 2))
    if kind == "zeta":
        return str(zeta), (kind, zeta, zeta)
    unit = np.median(net.dashpots("zeta", 1, 1)[1]) if kind == "gamma" else 2 * np.sqrt(np.median(net.kn))
    values = [float(f"{x * unit:.3g}") for x in (zeta, side)]
    return f"{kind}:{values[0]!r}:{values[1]!r}", (kind, *values)


def damped_modes(case):
    net = case.network
    if net.size > 220:
        return
    word, of = dashpots(case, 1.2)
    if not (table := case.run("modes", "P.h5", f"--damping={word}", "-q")):
        return
    c = net.dashpots(*of)[0]
    root = np.sqrt(net.mass)
    a, c = net.matrix().astype(float), (c / root[:, None] / root).astype(float)
    n = len(a)
    values = np.linalg.eigvals(np.block([[np.zeros((n, n)), np.eye(n)], [-a, -c]]))
    top = np.sqrt(np.abs(a).sum(0).max())
    keep = (values.imag >= 0) & (np.abs(values) > 1e-6 * top)
    want = sorted(values[keep], key=lambda v: (abs(v), v.imag))
    rows = sorted(zip(-table["decay"] + 1j * table["omega"], table["error"]), key=lambda v: (abs(v[0]), v[0].imag))
    rows = [row for row in rows if abs(row[0]) > 1e-6 * top]
    case.compare("values without a row", sum(not any(near_by(v, r, top, n) for r, _ in rows) for v in want), 0, 0)
    for value, error in rows:
        near = min(want, key=lambda v, value=value: abs(v - value))
        # A double eigenvalue is known to the root of rounding: by both.
        gap = sorted(abs(v - near) for v in [*want, *np.conj(want)])[1]
        oracle = 30 * EPS * n * top * max(1, top / abs(near)) / max(1e-8, min(1, gap / top))
        case.compare("lambda", abs(value - near), 0, error + oracle)


def near_by(a, b, top, n):
    """Equal within the root of rounding, to which double eigenvalues are known."""
    return abs(a - b) < np.sqrt(30 * EPS * n) * top * max(1, top / abs(a))**0.5


def points_signal(case, arguments, signal, count, until, method=None):
    """One signal: the whole trace within the stated error."""
    full = ["signal", "P.h5", *arguments, f"--points={count}", f"--until={until}", "-q"]
    if method:
        full.append(f"--method={method}")
    if not (table := case.run(*full)):
        return None
    want = signal.at(table["t"])
    stated = table.comment("error")
    name = f"F by {method}" if method else "F"
    case.compare(name, table["F"], want, stated + signal.rounding(table["t"]))
    case.compare("error over tolerance", stated / table.comment("tolerance"), 0, np.abs(want).max())
    return table


def window(p):
    return float((8 * p.height + 40) * (p.p / 1e-4)**(-1 / 6))


def signals(case):
    p, rng = case.packing, case.rng
    until = round(window(p) * float(rng.uniform(0.3, 1.5)), 3)
    low, high = (round(float(p.height) * f, 3) for f in (0.37, 0.71))
    if p.kind != "periodic":
        for kind in ("impulse", "velocity", "displacement"):
            signal = network_signal(case, kind)
            method = [None, "chebyshev", "dense", "sparse", "verlet", "lax-wendroff"][rng.integers(6)]
            loose = {"verlet": ["--tolerance=1e-4"], "lax-wendroff": ["--tolerance=1e-7"]}.get(method, [])
            points_signal(case, [f"--source={kind}", *loose], signal, 61, until, method)
    for component in ("shear", "normal"):
        axis = p.up if component == "normal" else 0
        signal = network_signal(case, source={"plane": low, "axis": axis}, detector={"plane": high, "axis": axis})
        points_signal(case, [f"--from=plane:{low}", f"--detector=plane:{high}", f"--component={component}"],
                      signal, 41, until)
    if p.kind != "periodic":
        pulses(case, until)
        damped(case, until)
        stressed(case, until)


def pulses(case, until):
    """A pulse in place of the delta: an integral by Gauss's rule over panels."""
    rng, base = case.rng, network_signal(case)
    width = round(until * float(rng.uniform(0.01, 0.1)), 4)
    omega = round(float(base.omega.max()) * float(rng.uniform(0.1, 0.4)), 4)
    kinds = {f"square:{width}": (0, width, lambda t: t * 0 + 1 / LONG(width)),
             f"gauss:{width}": (-10 * width, 10 * width, lambda t: np.exp(-t * t / (2 * LONG(width)**2))
                                / (width * np.sqrt(2 * case.packing.pi))),
             f"ricker:{omega}": (-16 / omega, 16 / omega, lambda t: (1 - omega * omega * t * t / 2)
                                 * np.exp(-omega * omega * t * t / 4)),
             f"sine:{omega}:3": (0, 6 * math.pi / omega, lambda t: np.sin(omega * t)
                                 * (1 - np.cos(omega * t / 3)) / 2)}
    name = list(kinds)[rng.integers(4)]
    lo, hi, strength = kinds[name]
    if not (table := case.run("signal", "P.h5", f"--pulse={name}", "--points=9", f"--until={until}", "-q")):
        return
    nodes, weights = np.polynomial.legendre.leggauss(40)
    want = [0.0 if t <= lo else convolve(base, strength, lo, min(hi, t), t, nodes, weights) for t in table["t"]]
    size = max(np.abs(want))
    case.compare("F of " + name.split(":")[0], table["F"], want, table.comment("error") + 1e-13 * size)


def convolve(signal, strength, lo, hi, t, nodes, weights):
    panels = int(math.ceil((hi - lo) * float(signal.omega.max()) / 4)) + 8
    edges = np.linspace(LONG(lo), LONG(hi), panels + 1)
    half = (edges[1:] - edges[:-1]) / 2
    s = (half[:, None] * nodes + (edges[1:] + edges[:-1])[:, None] / 2).reshape(-1)
    return np.sum((half[:, None] * weights).reshape(-1) * strength(s) * signal.at(t - s))


def march(a, c, u, v, read_u, read_v, step, count):
    """F at equal steps of u'' + c u' + a u = 0, by the exponential of one step."""
    n = len(a)
    block = np.block([[np.zeros((n, n)), np.eye(n)], [-a, -c]]).astype(float)
    once, y, out = expm(block * step), np.concatenate([u, v]).astype(float), []
    for _ in range(count):
        out.append(read_u @ y[:n] + read_v @ y[n:])
        y = once @ y
    return np.array(out, float)


def damped(case, until):
    net = case.network
    if net.size > 260:
        return
    (word, of), kind = dashpots(case, 1), str(case.rng.choice(["impulse", "displacement"]))
    table = case.run("signal", "P.h5", f"--damping={word}", f"--source={kind}", "--points=9", f"--until={until}", "-q")
    if not table:
        return
    c, cn, _ = net.dashpots(*of)
    root, start = np.sqrt(net.mass), net.source(kind)
    c = c / root[:, None] / root
    u, v = (start, 0 * start) if kind == "displacement" else (0 * start, start)
    times = table["t"]
    want = march(net.matrix(), c, u, v, net.detector(), net.wall_vector(-2, cn) / root, times[1], len(times))
    case.compare("F damped", table["F"], want, table.comment("error") + 1e-11 * np.abs(want).max())


def stressed(case, until):
    net = case.prestressed
    if net.size > 260:
        return
    if not (table := case.run("signal", "P.h5", "--prestress", "--points=9", f"--until={until}", "-q")):
        return
    a = net.matrix()
    start, times = net.source(), table["t"]
    want = march(a, np.zeros_like(a), 0 * start, start, net.detector(), 0 * start, times[1], len(times))
    case.compare("F with prestress", table["F"], want, table.comment("error") + 1e-10 * np.abs(want).max())


def first_peak(t, f):
    """Index of the first front's maximum by the documented rule."""
    top = f.max()
    best = 0
    for k in range(1, len(f)):
        if f[k] > f[best]:
            best = k
        elif f[best] > 0.2 * top and f[best] - f[k] >= 0.01 * top:
            return best
        elif f[k] < f[best] and f[best] <= 0.2 * top:
            # A maximum too low to count: what follows begins anew.
            best = k
    return None


def grid_front(t, f):
    """The front of a trace: parabola at the peak, straight lines at the crossings."""
    k = first_peak(t, f)
    if k is None:
        return None
    step = t[1] - t[0]
    a, b, c = f[k - 1:k + 2]
    shift = (a - c) / (a - 2 * b + c) / 2
    height = b - (a - c) * shift / 4
    peak, level = t[k] + shift * step, height / 10
    rise = int(np.argmax(f[:k + 1] >= level))
    t10 = t[rise - 1] + (level - f[rise - 1]) / (f[rise] - f[rise - 1]) * step
    down = k + int(np.argmax(f[k:] <= 0))
    zero = t[down - 1] + f[down - 1] / (f[down - 1] - f[down]) * step if f[down] <= 0 else math.nan
    return {"t10": t10, "t_peak": peak, "t_zero": zero, "amplitude": height, "width": zero - t10}


def exact_front(signal, until, start=None):
    """The front of the continuous signal: Newton's method from the points of a dense grid."""
    t = np.linspace(0, until, 6001)
    guess = grid_front(t, signal.at(t).astype(float))
    if guess is None or math.isnan(guess["t_zero"]):
        return None
    def newton(x, value, slope, goal=0):
        for _ in range(8):
            x = x - (value(x) - goal) / slope(x)
        return x
    def derivative(k):
        return lambda x: signal.at(x, k)[0]
    peak = newton(LONG(guess["t_peak"]), derivative(1), derivative(2))
    height = signal.at(peak)[0]
    t10 = newton(LONG(guess["t10"]), derivative(0), derivative(1), height / 10)
    zero = newton(LONG(guess["t_zero"]), derivative(0), derivative(1))
    return {"t10": t10, "t_peak": peak, "t_zero": zero, "amplitude": height, "peak": height, "width": zero - t10}


def front(case):
    p = case.packing
    if p.kind == "periodic":
        return
    for kind in ("impulse", "velocity", "displacement"):
        signal = network_signal(case, kind)
        want = exact_front(signal, window(p))
        table = case.run("front", "P.h5", f"--source={kind}", "-q", quiet=want is None)
        if table and want:
            compare_front(case, table, want, signal, 0.1 * (p.p / 1e-4)**(-1 / 6))
    if not (trace := case.run("signal", "P.h5", "--points=301", "-q")):
        return
    with open(case.folder + "/T.tsv", "w", encoding="utf-8") as f:
        f.write(trace.text)
    want = grid_front(trace["t"], trace["F"])
    if want and (table := case.run("front", "T.tsv", "-q")):
        for name, value in want.items():
            case.compare(name + " of a trace", table[name][0], value, 1e-12 * abs(value))


def compare_front(case, table, want, signal, step):
    """Times from points at a distance `step`, within the errors of interpolation."""
    def most(t, order):
        return np.abs(signal.at(np.linspace(t - 2 * step, t + 2 * step, 21), order)).max()
    third, second = most(want["t_peak"], 3), np.abs(signal.at(want["t_peak"], 2)[0])
    height = 0.065 * third * step**3 + most(want["t_peak"], 4) * step**4 / 24
    allowed = {"amplitude": height,
               "t_peak": (third * step**2 / 6 + most(want["t_peak"], 4) * step**3 / 4) / second * 1.5}
    for name, extra in (("t10", height / 10), ("t_zero", 0)):
        slope = np.abs(signal.at(want[name], 1)[0])
        allowed[name] = (most(want[name], 2) * step**2 / 8 + extra) / slope * 1.5
    allowed["width"] = allowed["t10"] + allowed["t_zero"]
    for name, bound in allowed.items():
        case.compare(name, table[name][0], want[name], bound + 1e-12 * abs(want[name]))


CHECKS = [("modes", modes), ("modes", damped_modes), ("signal", signals), ("front", front)]
