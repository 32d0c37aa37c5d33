"""Checks of spectra, sensitivities, uncertainties, transport, chains and columns."""
import math

import numpy as np
from scipy.integrate import solve_ivp

import sound
from physics import EPS, LONG, eigen, product


def kpm(table, values, weights, name="moments"):
    """Jackson's smoothing of lines with weights, at the frequencies of a table."""
    top, n = LONG(table.comment("omega_max")), int(table.comment(name))
    angle = 2 * np.arcsin(np.sqrt(values) / top)
    k = np.arange(n)[:, None]
    moments = (np.cos(k * angle) * weights).sum(1)
    moments *= jackson(n)
    psi = np.arcsin(table["omega"] / top)
    terms = np.cos(2 * psi[:, None] * k.T) * moments * np.where(k.T > 0, 2, 1)
    return 2 / (math.pi * top * np.cos(psi)) * terms.sum(1)


def jackson(n):
    k, q = np.arange(n), LONG(math.pi) / (n + 1)
    return ((n - k + 1) * np.cos(q * k) + np.sin(q * k) / np.tan(q)) / (n + 1)


def dos(case):
    net, values = case.network, case.modes[0]
    for method in ("exact", "count"):
        table = case.run("spectrum", "dos", "P.h5", f"--method={method}", "--norm=modes", "--bins=15", "-q")
        if not table:
            continue
        omega = np.sqrt(np.abs(values))
        zero = omega < table.comment("zero_below")
        loose = (case.packing.count - len(net.grains)) * len(net.axes)
        case.compare("modes", table.comment("modes"), net.size, 0)
        case.compare("zero_modes", table.comment("zero_modes"), zero.sum() + loose, 0)
        below = np.array([np.sum(omega[~zero] < edge) for edge in table["high"]])
        offset = below[-1] - table["cumulative"][-1]
        case.compare("all counted", offset, 0, table["cumulative_err"][-1])
        clear = np.array([np.abs(omega - edge).min() > 1e-12 for edge in table["high"]])
        case.compare("cumulative", table["cumulative"][clear], below[clear], table["cumulative_err"][clear] + 1e-300)
        if method == "exact":
            want = kpm(table, values[~zero], 1)
            case.compare("smooth", table["smooth"], want, table["smooth_err"] + 1e-12 * np.abs(want).max())


def transmission(case):
    kind = str(case.rng.choice(["impulse", "velocity", "displacement"]))
    signal = sound.network_signal(case, kind)
    if not (table := case.run("spectrum", "transmission", "P.h5", f"--source={kind}", "--bins=11", "-q")):
        return
    top = LONG(table.comment("omega_max"))
    got = table["re"] + 1j * table["im"]
    case.compare("magnitude", table["magnitude"], np.abs(got), 1e-14 * np.abs(got).max())
    part = table["re"] if signal.cosine else table["im"]
    size = np.abs(got).max()
    case.compare("density", table["density"], 2 / math.pi * part, 1e-13 * size)
    n = int(table.comment("moments"))
    theta, psi = np.arcsin(signal.omega / top), np.arcsin(table["omega"] / top)
    orders = 2 * np.arange(n) + (0 if signal.cosine else 1)
    line = np.cos(np.outer(orders, theta)) if signal.cosine else np.sin(np.outer(orders, theta)) / np.sin(theta)
    moments = line @ (signal.a * signal.b) * jackson(2 * n)[orders]
    waves = np.exp(1j * np.outer(psi, orders).astype(float))
    if signal.cosine:
        moments[1:] *= 2
        want = waves @ moments.astype(float) / (top * np.cos(psi)).astype(float)
    else:
        want = waves @ moments.astype(float) * 2 / (top**2 * np.cos(psi)).astype(float)
    case.compare("spectrum of the signal", np.abs(got - want), 0, table["error"] + 1e-12 * size)


def dispersion(case):
    p, net = case.packing, case.network
    if p.dim == 1:
        return
    if not (table := case.run("spectrum", "dispersion", "P.h5", "--waves=3", "-q")):
        return
    if p.kind == "box":
        return
    a, x = net.matrix(), p.x[net.grains, 0]
    period = p.cell[0][0]
    inverse = np.linalg.inv(p.cell)[:, 0]
    for row, name in enumerate(r[0] for r in table.rows):
        n = int(table["n"][row])
        k = np.pad(inverse, (0, 3 - p.dim)) if p.kind == "periodic" else np.array([1 / period, 0, 0])
        k = 2 * math.pi * n * k
        size = np.linalg.norm(k)
        case.compare("k", table["k"][row], size, 1e-14 * size)
        along = k / size
        across = np.eye(3)[p.up] - along * along[p.up]
        push = np.zeros(6)
        if name == "longitudinal":
            push[:3] = along
        elif name == "transverse":
            push[:3] = across / np.linalg.norm(across)
        else:
            continue
        phase = (p.x[net.grains] @ k.astype(LONG))[:, None]
        root = np.sqrt(net.mass).reshape(len(x), -1)
        parts = [(f(phase) * push[net.axes] * root).reshape(-1) for f in (np.cos, np.sin)]
        norm = sum(q @ q for q in parts)
        first = sum(q @ a @ q for q in parts) / norm
        second = sum((a @ q) @ (a @ q) for q in parts) / norm
        case.compare(f"rms of {name}", table["rms"][row], np.sqrt(first), 1e-12 * float(np.sqrt(first)))
        spread = np.sqrt(second - first**2) / (2 * np.sqrt(first))
        case.compare(f"spread of {name}", table["spread"][row], spread, 1e-11 * float(spread))


def harmonic(case):
    net, rng = case.network, case.rng
    top = float(np.sqrt(case.modes[0].max()))
    at = sorted(round(top * float(f), 5) for f in rng.uniform(0.05, 0.95, 3))
    word, of = sound.dashpots(case, 0.5)
    table = case.run("spectrum", "harmonic", "P.h5", f"--damping={word}", "--at=" + ",".join(map(str, at)), "-q")
    if not table:
        return
    c, cn, _ = net.dashpots(*of)
    push, read = -net.wall_vector(-1, net.kn), net.wall_vector(-2, net.kn)
    rub = net.wall_vector(-2, cn)
    for row, w in enumerate(table["omega"]):
        h = (net.k - w * w * np.diag(net.mass)).astype(float) + 1j * w * c.astype(float)
        u = np.linalg.lstsq(h, push.astype(complex), rcond=None)[0]
        u += np.linalg.lstsq(h, push.astype(complex) - h @ u, rcond=None)[0]
        want = (read.astype(float) + 1j * w * rub.astype(float)) @ u
        got = table["re"][row] + 1j * table["im"][row]
        condition = np.linalg.norm(read.astype(float)) * np.linalg.norm(u) * np.linalg.cond(h) * EPS
        case.compare("harmonic F", abs(got - want), 0, table["error"][row] + condition)


class Gradient:
    """Derivatives by the logarithm of each stiffness, from all pairs of modes."""

    def __init__(self, case, kind):
        net = case.network
        self.net, self.kind, self.signal = net, kind, sound.network_signal(case, kind)
        values, x = case.modes
        keep = values > 1e-16 * values.max()
        self.values, self.x = values[keep], x[:, keep]
        normal, slip = case.stretch
        root = np.sqrt(net.mass)
        self.normal = product(normal / root, self.x)
        self.slip = np.stack([product(s / root, self.x) for s in slip])
        self.heavy = product(normal * root, self.x)

    def function(self, t, order):
        """f(lambda) of F's derivative of this order by time, and f'(lambda)."""
        w = np.sqrt(self.values)
        s, c = np.sin(w * t), np.cos(w * t)
        if self.kind != "displacement":
            return [(s / w, t * c / (2 * w**2) - s / (2 * w**3)), (c, -t * s / (2 * w))][order]
        return [(c, -t * s / (2 * w)), (-w * s, -s / (2 * w) - t * c / 2)][order]

    def by_stiffness(self, t, order=0):
        """dF(t)/dln k of every normal and every tangential spring."""
        net, a, b = self.net, self.signal.a, self.signal.b
        f, slope = self.function(t, order)
        gap = self.values[:, None] - self.values[None, :]
        near = np.abs(gap) < 3e-7 * self.values.max()
        steps = (f[:, None] - f[None, :]) / np.where(near, 1, gap)
        divided = np.where(near, (slope[:, None] + slope[None, :]) / 2, steps)
        pairs = divided * b[:, None] * a[None, :]
        by_kn = net.kn * np.sum(product(self.normal, pairs) * self.normal, 1)
        by_kt = net.kt * sum(np.sum(product(self.slip[:, k], pairs) * self.slip[:, k], 1) for k in range(3))
        top, bottom = net.wall == -2, net.wall == -1
        by_kn = by_kn - np.where(top, net.kn * (self.normal @ (f * a)), 0)
        start = self.normal if self.kind == "impulse" else self.heavy
        return by_kn + np.where(bottom, net.kn * (start @ (f * b)), 0), by_kt

    def front(self, front):
        """Gradients of the first front's numbers."""
        at = self.signal.at
        peak = np.array(self.by_stiffness(front["t_peak"]))
        ten, zero = (np.array(self.by_stiffness(front[k])) for k in ("t10", "t_zero"))
        out = {"peak": peak, "t10": (peak / 10 - ten) / at(front["t10"], 1)[0],
               "t_peak": -np.array(self.by_stiffness(front["t_peak"], 1)) / at(front["t_peak"], 2)[0],
               "t_zero": -zero / at(front["t_zero"], 1)[0]}
        out["width"] = out["t_zero"] - out["t10"]
        return out


def compare_gradient(case, of, value, gradient, *options, noise=0.0):
    table = case.run("sensitivity", "P.h5", f"--of={of}", *options, "-q")
    if not table:
        return
    what = of.split(":", maxsplit=1)[0]
    case.compare(f"value of {what}", table.comment("value"), value, table.comment("value_err")
                 + 8 * EPS * abs(value) + noise)
    case.compare("contacts", len(table.rows), len(case.network.c), 0)
    size = np.abs(gradient).max() + noise
    rows = table["contact"].astype(int)
    place = {c: k for k, c in enumerate(case.network.c)}
    pick = [place[c] for c in rows]
    for k, name in enumerate(("by_kn", "by_kt")):
        if name in table.columns:
            case.compare(f"{name} of {what}", table[name], gradient[k][pick], table[name + "_err"] + 1e-12 * size)


def modulus_gradient(case, a, b):
    net, total = case.network, case.moduli[1]
    stretch = np.einsum("ca,cas->cs", net.normal, total[:, :3])
    slip = np.einsum("cra,cas->crs", net.slip, total)
    by_kn = net.kn * stretch[:, a] * stretch[:, b]
    return np.array([by_kn, net.kt * np.sum(slip[..., a] * slip[..., b], 1)]) / case.packing.volume


def clear_mode(case):
    """A mode that is no zero mode and far from others."""
    values = case.modes[0]
    gap = np.diff(values)
    good = [k for k in range(1, len(values) - 1) if values[k] > 1e-6 * values.max()
            and min(gap[k - 1], gap[k]) > 1e-4 * values.max()]
    return int(case.rng.choice(good)) if good else None


def sensitivity(case):
    p, net = case.packing, case.network
    if (k := clear_mode(case)) is not None:
        value, x = case.modes[0][k], case.modes[1][:, k]
        normal, slip = case.stretch
        u = x / np.sqrt(net.mass)
        by = np.array([net.kn * (normal @ u)**2, net.kt * np.sum((slip @ u)**2, 1)])
        number = k + (p.count - len(net.grains)) * len(net.axes)
        compare_gradient(case, f"omega:{number}", value, by)
        table = case.run("sensitivity", "P.h5", f"--of=omega:{number}", "--by=mass", "-q")
        if table:
            want = -value * (x**2).reshape(len(net.grains), -1).sum(1)
            case.compare("by_mass of omega", table["by_mass"], want[net.number[table["grain"].astype(int)]],
                         table["by_mass_err"] + 1e-13 * value)
    c, up = case.moduli[0], p.dim - 1
    for a, b in {(0, 0), (0, up), (up, up)}:
        name = "C22" if p.dim == 1 else f"C{a + 1}{b + 1}"
        compare_gradient(case, name, c[a, b], modulus_gradient(case, a, b))
    if p.kind == "periodic" or net.size > 420:
        return
    kind = str(case.rng.choice(["impulse", "velocity", "displacement"]))
    gradient = Gradient(case, kind)
    t = round(float(case.rng.uniform(0.2, 1)) * sound.window(p), 3)
    compare_gradient(case, "F", gradient.signal.at(t)[0], np.array(gradient.by_stiffness(t)), f"--at={t}",
                     f"--source={kind}", noise=gradient.signal.rounding(t)[0])
    front = sound.exact_front(gradient.signal, sound.window(p))
    if front:
        for of, by in gradient.front(front).items():
            compare_gradient(case, of, front[of], by, f"--source={kind}")


def uncertainty(case):
    p = case.packing
    if p.kind != "piston" or case.network.size > 420:
        return
    each, force, all_ = (round(float(s), 4) for s in case.rng.uniform(0.001, 0.1, 3))
    table = case.run("uncertainty", "P.h5", "--samples=0", f"--stiffness={each}", f"--force={force}",
                     f"--calibration={all_}", f"--margin={case.margin}", "-q")
    if not table:
        return
    def sd(by):
        # Stiffnesses that the file gives do not follow the forces.
        by, own = by.sum(0), p.given[0][case.network.c] > 0
        alone = each**2 + np.where(own, 0, force**2 / 9)
        return float(np.sqrt(np.sum(alone * by**2) + all_**2 * by.sum()**2))
    names = [row[0] for row in table.rows]
    gradient = Gradient(case, "impulse")
    front = sound.exact_front(gradient.signal, sound.window(p))
    want = {k: sd(v) for k, v in gradient.front(front).items() if k != "t_zero"} if front else {}
    n = {1: 1, 2: 3, 3: 6}[p.dim]
    want.update({"C22" if n == 1 else f"C{a + 1}{b + 1}": sd(modulus_gradient(case, a, b))
                 for a in range(n) for b in range(a, n)})
    for name, got in zip(names, table["sd_first"]):
        if name in want and not math.isnan(got):
            case.compare(f"sd_first of {name}", got, want[name], 1e-9 * want[name] + 1e-15)


def transport(case):
    """A burst's energy below planes."""
    p, net = case.packing, case.network
    if p.kind != "piston" or net.size > 420:
        return
    w = round(float(np.sqrt(case.modes[0].max())) * float(case.rng.uniform(0.1, 0.5)), 4)
    table = case.run("transport", "P.h5", "--quantity=energy", f"--at={w}", "-q")
    if not table:
        return
    values, x = case.modes
    keep = values > 1e-16 * values.max()
    omega, x = np.sqrt(values[keep]), x[:, keep]
    filtered = (x.T @ net.source()) * np.exp(-((omega - w) / (LONG(0.1) * w))**2 / 4)
    filtered *= np.sqrt(2 / (filtered @ filtered))
    normal, slip = case.stretch
    root = np.sqrt(net.mass)
    for t in sorted(set(table["t"]))[::5]:
        u, v = x @ (filtered * np.sin(omega * t) / omega), x @ (filtered * np.cos(omega * t))
        energy = (v**2).reshape(len(net.grains), -1).sum(1) / 2
        stored = (net.kn * (normal @ (u / root))**2 + net.kt * np.sum((slip @ (u / root))**2, 1)) / 2
        pair = net.wall >= 0
        np.add.at(energy, net.number[p.i[net.c]], np.where(pair, stored / 2, stored))
        np.add.at(energy, net.number[p.j[net.c][pair]], stored[pair] / 2)
        rows = table["t"] == t
        want = [energy[p.x[net.grains, p.up] < f * p.height].sum() for f in table["plane"][rows]]
        case.compare("energy below", table["below"][rows], want, table["below_err"][rows] + 1e-12)


def kubo(case):
    """Diffusivity from the current's elements, with Gaussians that are not cut off (the program cuts them)."""
    p, net = case.packing, case.network
    if p.kind == "box" or p.dim == 1 or net.size > 420:
        return
    if not (table := case.run("transport", "P.h5", "--quantity=kubo", "-q", quiet=True)):
        return
    values, x = (m.astype(float) for m in case.modes)
    keep = values > 1e-16 * values.max()
    w = np.sqrt(values[keep])
    axes = range(p.dim) if p.kind == "periodic" else range(p.dim - 1)
    squares = sum((x[:, keep].T @ current(net, axis) @ x[:, keep])**2 for axis in axes) / len(axes)
    for at, got in zip(table["omega"], table["D"]):
        eta = 0.1 * at
        delta = np.exp(-(w[:, None] - w)**2 / (2 * eta**2)) / (eta * math.sqrt(2 * math.pi))
        each = (math.pi * squares / (w[:, None] + w)**2 * delta).sum(1)
        band = np.exp(-((w - at) / (0.1 * at))**2 / 2)
        if not math.isnan(got):
            want = (band @ each) / band.sum()
            case.compare("D of kubo", got, want, 2e-5 * want)


def current(net, axis):
    """[A, x] from the distances of touching grains, over the root of the masses."""
    p, f, out = net.p, len(net.axes), np.zeros((net.size, net.size))
    for row, c in enumerate(net.c):
        if p.is_wall[c]:
            continue
        motion, arm = net.motion[row].astype(float), p.arm[c].astype(float)
        levers = np.concatenate([motion[:3], -arm[0] * motion[3:6] - arm[1] * motion[6:]])
        block = levers.T @ (net.law[row].astype(float) @ motion) * float(p.branch[c, axis])
        i, j = (slice(f * k, f * k + f) for k in (net.number[p.i[c]], net.number[p.j[c]]))
        out[i, j] += block[i, j]
        out[j, i] -= block[j, i]
    root = np.sqrt(net.mass.astype(float))
    return out / root[:, None] / root


class Chain:
    """N balls, unit masses and springs, walls of another stiffness: a signal of sound.py's form."""

    def __init__(self, n, initial, wall=1.0):
        self.n, wall = n, LONG(wall)
        if wall == 1:
            pi = 4 * np.arctan(LONG(1))
            k = np.arange(1, n + 1)
            values = (2 * np.sin(k * pi / (2 * (n + 1))))**2
            x = np.sqrt(LONG(2) / (n + 1)) * np.sin(np.outer(k, k) * pi / (n + 1))
        else:
            matrix = 2 * np.eye(n, dtype=LONG) - np.eye(n, k=1) - np.eye(n, k=-1)
            matrix[0, 0] += wall - 1
            matrix[-1, -1] += wall - 1
            values, x = eigen(matrix)
        start, end = np.zeros(n, dtype=LONG), np.zeros(n, dtype=LONG)
        start[0], end[-1] = 1, wall
        self.signal = sound.Signal((values, x), start, end, "displacement" if initial == "B" else "impulse")


def chain(case):
    rng = case.rng
    n, initial = int(rng.integers(2, 90)), str(rng.choice(["A", "B"]))
    wall = round(float(rng.uniform(0.5, 2)), 3) if rng.random() < 0.5 else 1
    until = round(float(rng.uniform(1, 4)) * n, 3)
    arguments = [f"--grains={n}", f"--initial={initial}"]
    ideal, real = Chain(n, initial), Chain(n, initial, wall)
    if table := case.run("chain", "signal", *arguments, f"--wall={wall}", f"--until={until}", "--points=40"):
        want = real.signal.at(table["t"])
        case.compare("F of a chain", table["F"], want, table.comment("error") + real.signal.rounding(table["t"]))
    if table := case.run("chain", "modes", *arguments):
        case.compare("omega of a chain", table["omega"], ideal.signal.omega, 1e-15 * ideal.signal.omega)
        weight = ideal.signal.weight
        case.compare("a b of a chain", table["a"] * table["b"], weight, 3e-15 * np.abs(weight))
    p = float(f"{10 ** rng.uniform(-7, -3):.3g}")
    if table := case.run("chain", "signal", *arguments, f"--pressure={p}", "--points=30"):
        k = np.cbrt(3 * LONG(p)) / 2
        rate = np.sqrt(k / (4 * np.arctan(LONG(1)) / 6))
        want = ideal.signal.at(table["t"] * rate)
        scale = k * rate if initial == "A" else k * k
        case.compare("F of a chain at p", table["F"], want * scale,
                     table.comment("error") + (4 * EPS + ideal.signal.rounding(table["t"] * rate)) * scale)
    chain_front(case, n, initial)


def chain_front(case, n, initial):
    n = max(n, 4)
    if not (table := case.run("chain", "front", f"--grains={n}", f"--initial={initial}")):
        return
    signal = Chain(n, initial).signal
    front = first_crest(signal, n)
    for name in ("t10", "t_peak", "t_zero", "amplitude"):
        bound = 1e-14 * (1 + n**(2 / 3)) if name == "amplitude" else 1e-11 * front[name]
        case.compare(f"{name} of a chain", table[name][0], front[name], bound)
    twice = first_crest(Chain(2 * n, initial).signal, 2 * n)
    case.compare("gamma", table["gamma"][0], np.log(front["amplitude"] / twice["amplitude"]) / np.log(LONG(2)), 1e-10)
    case.compare("alpha", table["alpha"][0], np.log(twice["width"] / front["width"]) / np.log(LONG(2)), 1e-9)


def first_crest(signal, n):
    """The front whose crest is the first one, however high later ones are."""
    t = np.linspace(0, 2.0 * n + 6, 4001)
    f = signal.at(t)
    top = next(k for k in range(1, 4000) if f[k] > 0.01 * f.max() and f[k] > f[k + 1])
    end = top + int(np.argmax(f[top:] < 0)) + 2
    return sound.exact_front(signal, t[end])


def gaps(y, floor):
    return np.diff(np.concatenate([[floor - 1], y])) - 2


def integrate(rate, gap, begin, end, state, times):
    """Heights at some times; every opening and closing of a contact ends a stretch of the integration."""
    rows, closed, t = {}, gap(begin, state) < 1e-12, begin
    while t < end:
        def watch(i, direction):
            def event(t, s, _):
                return gap(t, s)[i]
            event.terminal, event.direction = True, direction
            return event
        run = solve_ivp(rate, (t, end), state, method="DOP853", t_eval=[*times[(times > t) & (times < end)], end],
                        rtol=1e-12, atol=1e-13, max_step=1e-3, args=(closed,),
                        events=[watch(i, 1 if c else -1) for i, c in enumerate(closed)])
        rows.update(zip(run.t, np.transpose(run.y)))
        if run.status == 0:
            return run.y[:, -1], rows
        hit = next(i for i, when in enumerate(run.t_events) if len(when))
        closed[hit] = not closed[hit]
        t, state = run.t_events[hit][0], run.y_events[hit][0]
    return state, rows


def column(case):
    rng = case.rng
    n, smooth = int(rng.integers(1, 6)), rng.random() < 0.5
    e = round(float(rng.uniform(0.02, 0.4)), 3) if smooth else 0
    slope, hz = round(float(rng.uniform(0.5, 3)), 3), round(float(rng.uniform(4, 12)), 3)
    tall = round(float(rng.uniform(0.1, 1)), 3)
    k, period, step = 2 * n * 980.67, 0.3, 0.02
    keys = {"particles": n, "e": e, "frequency": hz, "amplitude": tall, "taps": 1, "period": period, "step": step,
            "alpha_v": slope, "method": '"smooth"' if smooth else '"event"', "tolerance": 1e-13}
    table = case.run("column", *(f"--set=column.{a}={b}" for a, b in keys.items()), "-q")
    if not table:
        return
    y = np.array([(2 * i - 1) - i / 2 * (2 * n - i + 1) * 980.67 / k for i in range(1, n + 1)])
    state, turn, times = np.concatenate([y, 0 * y]), 2 * math.pi * hz, table["t"]
    half, rows = 0.5 / hz, {0: state}
    for begin, end, height in ((0, half, tall), (half, times[-1], 0.0)):
        def gap(t, s, height=height):
            return gaps(s[:n], height * math.sin(turn * t))

        def rate(t, s, closed, height=height, gap=gap):
            speed = np.diff(np.concatenate([[height * turn * math.cos(turn * t)], s[n:]]))
            f = np.where(closed, -k * (1 - e * np.tanh(slope * speed)) * gap(t, s), 0)
            return np.concatenate([s[n:], f - np.append(f[1:], 0) - 980.67])
        state, found = integrate(rate, gap, begin, end, state, times)
        rows.update(found)
    got = np.stack([table[f"y{i + 1}"] for i in range(n)], 1)
    want = np.array([rows[t][:n] for t in times])
    case.compare("heights by smooth" if smooth else "heights with e = 0", got, want, 1e-8)
    bounce(case)


def bounce(case):
    """One ball falls on a floor at rest: parabolas and half sines in closed form."""
    rng, g = case.rng, 980.67
    e, fall = round(float(rng.uniform(0.02, 0.5)), 3), round(float(rng.uniform(0.2, 2)), 3)
    k = round(float(rng.uniform(4e3, 4e4)), 1)
    if fall < 4 * g * e / (1 - e)**2 / k:
        return  # It would not leave the floor again.
    table = case.run("column", "--set=column.particles=1", f"--set=column.e={e}", f"--set=column.drop={fall}",
                     f"--set=column.stiffness={k}", "--set=column.amplitude=0", "--set=column.taps=1",
                     "--set=column.period=0.4", "--set=column.step=0.01", "-q")
    if not table:
        return
    t0, v0 = math.sqrt(2 * fall / g), math.sqrt(2 * g * fall)
    stiff, soft = math.sqrt(k * (1 + e)), math.sqrt(k * (1 - e))
    rest = g / stiff**2
    # Overlap d: d = rest + A sin(w t - phi) while closing, d = rest' + B cos(w' t) while opening.
    top = math.hypot(rest, v0 / stiff)
    t1 = t0 + (math.pi / 2 + math.asin(rest / top)) / stiff
    deep, rest2 = rest + top, g / soft**2
    t2 = t1 + math.acos(-rest2 / (deep - rest2)) / soft
    v2 = soft * (deep - rest2) * math.sin(soft * (t2 - t1))
    def height(t):
        if t < t0:
            return 1 + fall - g * t * t / 2
        if t < t1:
            return 1 - (rest + top * math.sin(stiff * (t - t0) - math.asin(rest / top)))
        if t < t2:
            return 1 - (rest2 + (deep - rest2) * math.cos(soft * (t - t1)))
        return 1 + v2 * (t - t2) - g * (t - t2)**2 / 2
    stop = t2 + 2 * v2 / g
    rows = table["t"] < stop
    case.compare("heights of a bounce", table["y1"][rows], [height(t) for t in table["t"][rows]], 1e-12 * (1 + fall))


PACKING = [("spectrum", dos), ("spectrum", transmission), ("spectrum", dispersion), ("spectrum", harmonic),
           ("sensitivity", sensitivity), ("uncertainty", uncertainty), ("transport", transport),
           ("transport", kubo)]
ALONE = [("chain", chain), ("column", column)]
