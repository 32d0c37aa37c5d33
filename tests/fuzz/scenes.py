"""Random scenes of packings, and a judge of what comes out that shares nothing with the program but the file format."""
import collections
import math
import pathlib
import random
import re
import resource
import subprocess
import tempfile

SIZES = ("equal", "uniform", "bidisperse", "lognormal")


def log_uniform(rng, low, high):
    return math.exp(rng.uniform(math.log(low), math.log(high)))


def random_sizes(rng):
    """Keys of a law of sizes with mean near 1, its largest diameter last."""
    law, ratio = rng.choice(SIZES), log_uniform(rng, 1.02, 10) if rng.random() < 0.97 else 100
    if law == "equal":
        return {"sizes": "uniform", "diameter_min": 1, "diameter_max": 1}
    if law == "uniform":
        return {"sizes": law, "diameter_min": 2 / (1 + ratio), "diameter_max": 2 * ratio / (1 + ratio)}
    if law == "lognormal":
        return {"sizes": law, "size_spread": min(2, 0.2 * math.log(ratio)), "diameter_min": ratio ** -0.5,
                "diameter_max": ratio ** 0.5}
    part = rng.uniform(0, 1)
    small = 1 / (1 - part + part * ratio)
    return {"sizes": law, "large_fraction": part, "diameter_min": small, "diameter_max": small * ratio}


def random_scene(rng, most_grains):
    """Values of packing.*; not all of them fit together."""
    kind = rng.choice(("piston", "piston", "piston", "piston", "triangular", "chain"))
    scene = {"kind": kind, "dimension": {"chain": 1, "triangular": 2}.get(kind) or rng.choice((2, 2, 3)),
             "grains": round(log_uniform(rng, 1, most_grains)), "pressure": log_uniform(rng, 1e-9, 1e-2),
             "friction": rng.choice((0, 0.1, 0.5, rng.uniform(0, 1), rng.uniform(0, 10), 1e6)),
             "poisson": rng.choice((0, 0.5, rng.uniform(0, 0.5))), "seed": rng.randrange(1 << 32)}
    if rng.random() < 0.8:
        scene.update(random_sizes(rng))
    largest = scene.get("diameter_max", 1.2)
    if kind != "chain":
        scene["width"] = log_uniform(rng, 4 * largest if rng.random() < 0.9 else 4, 30 * max(1, largest / 3))
    if kind == "triangular":
        scene["width"] = row = rng.randint(4, 12)
        scene["grains"] = row * max(1, round(scene["grains"] / row)) + (rng.random() < 0.05)
    if scene["dimension"] == 3 and rng.random() < 0.5:
        scene["depth"] = scene["width"] * rng.uniform(1, 2)
    if kind != "chain" and rng.random() < 0.25:
        scene["compression"] = "isotropic"
    if rng.random() < 0.3:
        scene["protocol"] = "somfai2005"
    if rng.random() < 0.1:
        others = [min(1e-2, max(1e-9, scene["pressure"] * log_uniform(rng, 0.1, 10))) for _ in range(rng.randint(1, 3))]
        scene["history"] = "[" + ", ".join(repr(p) for p in others) + "]"
    return scene


def settings(scene):
    return [word for key, value in scene.items() for word in ("--set", f"packing.{key}={value}")]


# Scenes that a random search has found to go wrong, and what must become of them.
ONCE_WRONG = (
    # the sides closed up, turned over and went on
    ("refused", dict(kind="piston", dimension=2, grains=5, pressure=3e-9, width=18.5, compression="isotropic")),
    ("refused", dict(kind="piston", dimension=2, grains=1, pressure=3e-3, width=8, compression="isotropic")),
    # a load that the grains cannot carry was found out only when they were flat
    ("refused", dict(kind="piston", dimension=3, grains=4, pressure=6.6e-3, width=25.5)),
    ("gave up", dict(kind="piston", dimension=2, grains=2, pressure=9.5e-3, width=28.58, diameter_min=1, diameter_max=1,
                     protocol="somfai2005", seed=3904452093, poisson=0.5, friction=0.7)),
    # beside the walls there was no room for the gas
    ("packed", dict(kind="piston", dimension=2, grains=18, pressure=3.8e-7, friction=0, poisson=0.5, seed=2595161220,
                    sizes="uniform", diameter_min=0.702171868921938, diameter_max=1.297828131078062,
                    width=6.834691184746246)),
    # the piston struck too hard
    ("packed", dict(kind="piston", dimension=2, grains=600, pressure=1e-2, width=24, seed=1)),
    # grains much smaller and larger than the unit of length, in the narrowest box
    ("packed", dict(kind="piston", dimension=2, grains=40, pressure=1e-5, width=0.6, diameter_min=0.1,
                    diameter_max=0.15, seed=1)),
    ("packed", dict(kind="piston", dimension=2, grains=40, pressure=1e-5, width=48, diameter_min=8, diameter_max=12,
                    seed=1)),
)


def known(command):
    """The scenes above; those that end otherwise."""
    faults = []
    with tempfile.TemporaryDirectory(prefix="sonopack-scenes-") as scratch:
        for wanted, scene in ONCE_WRONG:
            what, why = outcome(command, {"seed": 1, **scene}, pathlib.Path(scratch), 60)
            if what != wanted:
                faults.append(f"{what} {why}, not {wanted}: {scene}")
    print(*faults, sep="\n")
    return faults


# ---- the judge ------------------------------------------------------------------------------------------------------


class Fault(Exception):
    pass


def read_text(path):
    """Box, grains (centre, radius) and contacts (i, j, n, overlap, normal force, tangential force) of a text file."""
    lines = pathlib.Path(path).read_text().splitlines()[1:]
    words = lines[0].split()
    head = dict(zip(words[::2], words[1::2])) if len(words) % 2 == 0 else None
    if head is None:
        raise Fault("odd header: " + lines[0])
    count = int(head["N"])
    edges = [float(head[key]) for key in ("Lx", "Ly", "Lz") if key in head]
    dim = len(edges)
    rows = [[float(word) for word in line.split()] for line in lines[1:]]
    if not all(math.isfinite(value) for row in rows for value in row):
        raise Fault("a number that is not finite")
    grains = [(row[:dim], row[dim]) for row in rows[:count]]
    contacts = []
    for row in rows[count:]:
        n, rest = row[2:2 + dim], row[2 + dim:]
        ft = [0.0] if dim == 1 else [-rest[2] * n[1], rest[2] * n[0]] if dim == 2 else rest[2:5]
        contacts.append((int(row[0]), int(row[1]), n, rest[0], rest[1], ft))
    return head, edges, grains, contacts


def images(dim, edges):
    if dim == 1:
        return [(0.0,)]
    shifts = [(-1, 0, 1)] * (dim - 1)
    out = [()]
    for a, shift in enumerate(shifts):
        out = [one + (s * edges[a],) for one in out for s in shift]
    return [one + (0.0,) for one in out]


def overlaps(edges, grains, like_grain):
    """All that overlap, whatever the file lists: {(i, j): (overlap, normal)}. Every periodic image counts."""
    dim, up, found = len(edges), len(edges) - 1, {}
    order = sorted(range(len(grains)), key=lambda i: grains[i][0][up])
    r_max = max(r for _, r in grains)
    shifts = images(dim, edges)
    for k, one in enumerate(order):
        (x, r) = grains[one]
        for other in order[k:]:
            (y, s) = grains[other]
            if y[up] - x[up] > r + r_max:
                break
            i, j = min(one, other), max(one, other)
            a, b = grains[i][0], grains[j][0]
            for shift in shifts:
                if i == j and not any(shift):
                    continue
                d = [q - p + t for p, q, t in zip(a, b, shift)]
                far = math.sqrt(sum(v * v for v in d))
                if far < r + s:
                    if (i, j) in found or i == j:
                        raise Fault(f"grains {i} and {j} touch through more than one side of the box")
                    found[i, j] = (r + s - far, [v / far for v in d])
        for wall, distance in ((-1, x[up]), (-2, edges[up] - x[up])):
            if distance < r:
                found[one, wall] = (r - distance, [0.0] * up + [-1.0 if wall == -1 else 1.0])
    return found


def stiffness(grains, i, j, like_grain):
    """E12 sqrt(R12) in units of E* of one grain."""
    r = grains[i][1]
    if j < 0 and not like_grain:
        return math.sqrt(r)
    s = grains[j][1] if j >= 0 else r
    return 0.5 * math.sqrt(r * s / (r + s))


def turning(n, ft):
    """n x ft, the torque over R."""
    if len(n) == 1:
        return [0.0]
    if len(n) == 2:
        return [n[0] * ft[1] - n[1] * ft[0]]
    return [n[(a + 1) % 3] * ft[(a + 2) % 3] - n[(a + 2) % 3] * ft[(a + 1) % 3] for a in range(3)]


def norm(v):
    return math.sqrt(sum(x * x for x in v))


def judge(path, scene):
    """Raises Fault unless the file is the packing in equilibrium that the scene asks for."""
    head, edges, grains, contacts = read_text(path)
    dim, up, p, mu = len(edges), len(edges) - 1, float(head["p"]), float(head["mu"])
    if dim != scene["dimension"] or len(grains) != scene["grains"] or p != float(scene["pressure"]):
        raise Fault(f"asked for {scene}, got {head}")
    like_grain = head.get("wall") == "grain"
    found = overlaps(edges, grains, like_grain)
    rounding = 1e-14 * max(edges + [r for _, r in grains])
    listed = {(c[0], c[1]): c for c in contacts}
    if len(listed) != len(contacts):
        raise Fault("a contact is there twice")
    for pair, (overlap, _) in found.items():
        if pair not in listed and overlap > rounding:
            raise Fault(f"{pair} overlap by {overlap} and are no contact")
    # exact packings are balanced to rounding, compressed ones to the tolerance of the default rule
    tolerance = min(1e-10, 1e-6 * p)
    force = [[0.0] * dim for _ in grains]
    turn = [[0.0] * len(turning([0.0] * dim, [0.0] * dim)) for _ in grains]
    slack = [rounding * rounding] * len(grains)
    walls, stress = {-1: 0.0, -2: 0.0}, [0.0] * dim
    for (i, j), c in listed.items():
        overlap, n = found.get((i, j), (0.0, c[2]))
        e = stiffness(grains, i, j, like_grain)
        kn, hertz = 2 * e * math.sqrt(max(overlap, rounding)), 4 / 3 * e * overlap ** 1.5
        if abs(c[3] - overlap) > rounding or norm([a - b for a, b in zip(c[2], n)]) > rounding / grains[i][1]:
            raise Fault(f"contact {i} {j}: overlap {c[3]}, but {overlap} from the positions")
        if abs(c[4] - hertz) > 2 * kn * rounding:
            raise Fault(f"contact {i} {j}: force {c[4]}, but Hertz gives {hertz}")
        ft = c[5]
        if norm(ft) > mu * c[4] * (1 + 1e-12) + 1e-300:
            raise Fault(f"contact {i} {j}: tangential force {norm(ft)} above {mu} times {c[4]}")
        if abs(sum(a * b for a, b in zip(ft, n))) > 1e-12 * (norm(ft) + hertz):
            raise Fault(f"contact {i} {j}: tangential force along the normal")
        q = turning(n, ft)
        for a in range(dim):
            f = ft[a] - hertz * n[a]
            force[i][a] += f
            if j >= 0:
                force[j][a] -= f
                reach = grains[i][1] + grains[j][1] - overlap
                stress[a] -= f * n[a] * reach
        for grain in (i, j) if j >= 0 else (i,):
            turn[grain] = [a + b for a, b in zip(turn[grain], q)]
            slack[grain] += 4 * kn * rounding + 1e-15 * norm(ft)
        if j < 0:
            walls[j] += hertz
    area = edges[0] * edges[1] if dim == 3 else edges[0] if dim == 2 else 1.0
    total = 0.0
    for i, (_, r) in enumerate(grains):
        m = 4 / 3 * math.pi * r ** 3
        total += m * tolerance + slack[i]
        if norm(force[i]) > m * tolerance + slack[i]:
            raise Fault(f"grain {i}: force {norm(force[i])}, at most {m * tolerance}")
        if 2.5 * norm(turn[i]) > m * tolerance + 3 * slack[i]:
            raise Fault(f"grain {i}: torque over R {norm(turn[i])}, at most {m * tolerance / 2.5}")
    for wall, carried in walls.items():
        if abs(carried - p * area) > tolerance * area + total:
            raise Fault(f"wall {wall} carries {carried}, not {p * area}")
    volume = area * edges[up]
    if scene.get("compression") == "isotropic" and dim > 1 and scene["kind"] == "piston":
        for a in range(dim - 1):
            if abs(stress[a] / volume - p) > 1.01e-3 * p:
                raise Fault(f"pressure {stress[a] / volume} along axis {a}, not {p}")
    elif scene["kind"] == "piston" and edges[0] != float(scene["width"]):
        raise Fault(f"width {edges[0]}, not {scene['width']}")
    low, high = (scene.get("diameter_min", 0) / 2, scene.get("diameter_max", 100) / 2)
    if not all(low * (1 - 1e-12) <= r <= high * (1 + 1e-12) for _, r in grains):
        raise Fault("a radius beyond the limits")


# ---- running --------------------------------------------------------------------------------------------------------


def limited(seconds):
    def limit():
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 5))
    return limit


def outcome(command, scene, folder, seconds):
    """(packed | refused before work | gave up | FAULT, why)"""
    file = folder / "p.txt"
    for old in folder.glob("p*"):
        old.unlink()
    threads = str(1 + scene["seed"] % 3)
    result = subprocess.run([command, "pack", "-q", "--threads", threads, *settings(scene), "-o", str(file)],
                            capture_output=True, text=True, preexec_fn=limited(seconds), stdin=subprocess.DEVNULL)
    reasons = result.stderr.strip().splitlines()
    if result.returncode in (1, 2):
        if len(reasons) != 1 or not (field := re.search(r"packing\.\w+", reasons[0])):
            return "FAULT", f"refused without one reason that names a field: {result.stderr!r}"
        if re.search(r"(?i)\bnan\b|\binf\b", reasons[0]):
            return "FAULT", f"refused for a number that is none: {reasons[0]}"
        return ("refused" if result.returncode == 2 else "gave up"), re.sub(r"seed \d+: ", "", reasons[0])
    if result.returncode != 0:
        return "FAULT", f"ended with {result.returncode}: {result.stderr!r}"
    try:
        judge(file, scene)
    except Fault as fault:
        return "FAULT", str(fault)
    checked = subprocess.run([command, "check", str(file)], capture_output=True, text=True)
    if checked.returncode != 0:
        return "FAULT", "check says: " + checked.stdout + checked.stderr
    return "packed", ""


def campaign(command, seed, cases, most_grains, seconds, spread=True):
    """Runs the scenes, prints what became of them; the faults."""
    print(f"seed {seed}, {cases} scenes of up to {most_grains} grains")
    counts, reasons, faults, slow = collections.Counter(), collections.Counter(), [], []
    with tempfile.TemporaryDirectory(prefix="sonopack-scenes-") as scratch:
        for case in range(cases):
            scene = random_scene(random.Random(f"{seed} {case}"), most_grains)
            before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
            what, why = outcome(command, scene, pathlib.Path(scratch), seconds)
            took = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
            counts[what] += 1
            slow.append((took, case))
            line = " ".join(f"{key}={value}" for key, value in scene.items())
            if why and what != "FAULT":
                reasons[what + ": " + re.sub(r"-?\d[\d.e+-]*", "#", why)] += 1
            if what == "FAULT":
                faults.append(f"case {case}: {why}\n    {line}")
            if what in ("FAULT", "gave up") or took > 10:
                print(f"case {case}: {what} after {took:.1f} s: {why}\n    {line}", flush=True)
    print(dict(counts))
    for reason, count in reasons.most_common():
        print(f"{count:5d} {reason}")
    print("slowest [s]:", ", ".join(f"case {case} {took:.2f}" for took, case in sorted(slow)[-5:]))
    return counts, faults
