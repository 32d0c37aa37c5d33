#!/usr/bin/python3
"""Properties and cost of the packings of a protocol: means of all quantities of Tables I and II of Somfai et al. 2005,
of t10 and, with --ctof, of c_tof, beside the paper's and beside those of another protocol.

    protocol.py build/release/sonopack --samples 60 --ctof -o default.tsv
    protocol.py build/release/sonopack --samples 60 --ctof --set 'packing.protocol="somfai2005"' \\
        --against default.tsv -o somfai2005.tsv

Each pressure and quantity has a row: mean, median, standard deviation of a sample, standard error of the mean; the
paper's mean and standard deviation; the deviation from the paper in its standard deviations, or in ours where it gives
none. With --against: the difference to the other file's mean, in standard errors of the difference (of independent
samples). CPU: user seconds of the whole command, one thread. c_tof = (<H2> - <H1>)/(<t10>_2 - <t10>_1) between boxes of
200 and 600 grains. The paper gives 0.25 and 0.26 for it at p = 1e-4, growing as p^(1/6), and no standard deviation; we
compare with 0.255 (p/1e-4)^(1/6).
"""
import argparse
import math
import os
import signal
import sys
import tempfile
import typing

import numpy as np

sys.dont_write_bytecode = True
import measure

HEADER = ("p", "quantity", "samples", "mean", "median", "sd", "err", "paper", "paper_sd", "deviation", "other",
          "other_err", "difference")
COST = ("cpu_s", "steps")
HERE = os.path.dirname(os.path.abspath(__file__))


class Estimate(typing.NamedTuple):
    n: int
    mean: float
    median: float = math.nan
    sd: float = math.nan
    err: float = math.nan


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", help="the sonopack to measure")
    parser.add_argument("--samples", type=int, default=20, help="seeds a pressure (20)")
    parser.add_argument("--seed", type=int, default=1, help="the first of them (1)")
    parser.add_argument("--pressures", nargs="+", default=["1e-4", "1e-5", "1e-6", "1e-7"], metavar="P")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="of the scene; repeatable")
    parser.add_argument("--ctof", action="store_true", help="also boxes of 200 grains, and c_tof")
    parser.add_argument("--against", metavar="TSV", help="a file that this script wrote")
    parser.add_argument("--jobs", type=int, default=2, help="packings at a time (2)")
    parser.add_argument("--limit", type=int, default=600, help="CPU seconds after which a packing has failed (600)")
    parser.add_argument("--output", "-o", metavar="TSV", help="instead of stdout")
    given = parser.parse_args()
    if given.samples < 1 or given.jobs < 1:
        parser.error("--samples and --jobs must be at least 1")
    return given


def make_packings(runner, given, p, grains, folder):
    """The packings that were made, {path: {cpu_s, steps}}, and the failures as texts."""
    settings = [f"packing.grains={grains}", "packing.width=24", "packing.friction=0.5", f"packing.pressure={p}",
                *given.set]
    seeds = range(given.seed, given.seed + given.samples)
    paths = [os.path.join(folder, f"N{grains}-p{p}-{seed}.h5") for seed in seeds]
    runs = runner.run_all([measure.pack_command(given.command, seed, settings, path)
                           for seed, path in zip(seeds, paths)])
    made, failures = {}, []
    for seed, path, run in zip(seeds, paths, runs):
        rows = measure.table_rows(run.out) if run.status == 0 else []
        if rows:
            made[path] = {"cpu_s": run.user, "steps": float(rows[0]["steps"])}
        else:
            failures.append(f"p = {p}, {grains} grains, seed {seed}: {run.reason()}")
        if run.status == 2:
            sys.exit(f"protocol.py: {run.reason()}")
    return made, failures


def analyse(runner, command, subcommand, samples, names, failures):
    """Adds the columns `names` of a subcommand over all packings to the samples."""
    run = runner.run([command, subcommand, "-q", "--threads=1", *samples])
    found = {row["file"]: row for row in measure.table_rows(run.out)}
    for path, sample in samples.items():
        row = found.get(path)
        if row is None:
            failures.append(f"{subcommand} of {os.path.basename(path)}: {run.reason()}")
        for name in names:
            sample[name] = float(row[name]) if row else math.nan


def column(samples, name):
    """The finite values of a quantity."""
    values = np.array([sample[name] for sample in samples.values()], dtype=float)
    return values[np.isfinite(values)]


def describe(values):
    n = len(values)
    if n == 0:
        return Estimate(0, math.nan)
    sd = float(np.std(values, ddof=1)) if n > 1 else math.nan
    return Estimate(n, float(np.mean(values)), float(np.median(values)), sd, sd / math.sqrt(n))


def speed(low, high):
    """c_tof of two sets of boxes; sd: that of samples which would give this error."""
    fronts = []
    for samples in (low, high):
        pairs = np.array([(s["distance"], s["t10"]) for s in samples.values()], dtype=float).reshape(-1, 2)
        fronts.append(pairs[np.isfinite(pairs).all(axis=1)])
    n = min(len(front) for front in fronts)
    if n < 2:
        return Estimate(n, math.nan)
    (h1, t1), (h2, t2) = (front.mean(axis=0) for front in fronts)
    c = (h2 - h1) / (t2 - t1)
    # height and time of a box are correlated: use the variance of h - c t
    variance = sum(np.var(front[:, 0] - c * front[:, 1], ddof=1) / len(front) for front in fronts)
    err = math.sqrt(variance) / abs(t2 - t1)
    return Estimate(n, float(c), math.nan, err * math.sqrt(n), err)


def published(path):
    """{(p, quantity): (mean, sd)} as texts, c_tof included; sd is empty where the paper gives none."""
    with open(path, encoding="utf-8") as table:
        rows = measure.table_rows(table.read())
    paper = {(float(r["p"]), r["quantity"]): (r["mean"], r["sd"]) for r in rows}
    for p in {p for p, _ in paper}:
        paper[p, "c_tof"] = (f"{0.255 * (p / 1e-4) ** (1 / 6):.3g}", "")
    return paper


def other_means(path):
    if not path:
        return {}
    with open(path, encoding="utf-8") as table:
        rows = measure.table_rows(table.read())
    if not rows or not {"p", "quantity", "mean", "err"} <= set(rows[0]):
        sys.exit(f"protocol.py: {path}: must be a table that protocol.py wrote")
    return {(float(r["p"]), r["quantity"]): (float(r["mean"]), float(r["err"])) for r in rows}


def line(p, name, ours, paper, other):
    """A row of the table, its deviation from the paper and its difference to the other protocol (nan: none)."""
    row = {"p": p, "quantity": name, "samples": ours.n, "mean": f"{ours.mean:.8g}", "median": f"{ours.median:.8g}",
           "sd": f"{ours.sd:.4g}", "err": f"{ours.err:.4g}"}
    deviation = difference = math.nan
    here = paper.get((float(p), name))
    if here:
        unit = float(here[1] or ours.sd)
        deviation = (ours.mean - float(here[0])) / unit if unit else math.nan
        row |= {"paper": here[0], "paper_sd": here[1], "deviation": f"{deviation:+.2f}"}
    there = other.get((float(p), name))
    if there:
        spread = math.hypot(ours.err, there[1])
        difference = (ours.mean - there[0]) / spread if spread else math.nan
        row |= {"other": f"{there[0]:.8g}", "other_err": f"{there[1]:.4g}", "difference": f"{difference:+.2f}"}
    return "\t".join(str(row.get(key, "")) for key in HEADER), deviation, difference


def worst_of(numbers, what, bound):
    known = {name: value for name, value in numbers.items() if math.isfinite(value)}
    if not known:
        return ""
    name = max(known, key=lambda key: abs(known[key]))
    beyond = sum(abs(value) > bound for value in known.values())
    return f"; worst {what} {known[name]:+.2f} ({name}), {beyond} of {len(known)} beyond {bound}"


def one_pressure(runner, given, p, tables, folder):
    """Lines of the table, summary and failures at a pressure."""
    samples, failures = make_packings(runner, given, p, 600, folder)
    low = {}
    if given.ctof:
        low, more = make_packings(runner, given, p, 200, folder)
        failures += more
    names = list(COST) + list(measure.STATICS + measure.MODULI) + ["t10"]
    if samples:
        analyse(runner, given.command, "statics", samples, measure.STATICS, failures)
        analyse(runner, given.command, "moduli", samples, measure.MODULI, failures)
        analyse(runner, given.command, "front", samples, ("distance", "t10"), failures)
    if low:
        analyse(runner, given.command, "front", low, ("distance", "t10"), failures)
    found = {name: describe(column(samples, name)) for name in names}
    if given.ctof:
        found["c_tof"] = speed(low, samples)
    lines, deviations, differences = [], {}, {}
    for name, ours in found.items():
        text, deviations[name], differences[name] = line(p, name, ours, *tables)
        lines.append(text)
    cpu, steps = found["cpu_s"], found["steps"]
    summary = f"p = {p}: {cpu.n} packings of 600 grains, {len(failures)} failures"
    if cpu.n:
        summary += f"; median {cpu.median:.3f} CPU s and {steps.median:.0f} steps, {1e6 * cpu.mean / steps.mean:.2f}" \
                   " us a step" + worst_of(deviations, "deviation from the paper in sd", 1)
        physics = {name: value for name, value in differences.items() if name not in COST}
        summary += worst_of(physics, "difference to the other in errors", 2)
    return lines, summary, failures


def main():
    given = arguments()
    tables = published(os.path.join(HERE, "somfai2005.tsv")), other_means(given.against)
    # on SIGTERM remove the temporary folder and stop the packings
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    head = [f"# {measure.version(given.command)}", f"# machine: {measure.machine()}",
            f"# seeds {given.seed} .. {given.seed + given.samples - 1}; settings: {' '.join(given.set) or 'defaults'}"]
    if given.against:
        head.append(f"# other: {os.path.basename(given.against)}")
    lines, failures = [], []
    with tempfile.TemporaryDirectory(prefix="sonopack-protocol-") as folder, \
            measure.Runner(given.jobs, given.limit) as runner:
        for p in given.pressures:
            more, summary, failed = one_pressure(runner, given, p, tables, folder)
            head.append(f"# {summary}")
            print(summary, file=sys.stderr, flush=True)
            lines += more
            failures += failed
            for name in os.listdir(folder):
                os.remove(os.path.join(folder, name))
    for failure in failures:
        print(f"failed: {failure}", file=sys.stderr)
    head += [f"# failures: {len(failures)}"] + [f"# failed: {failure}" for failure in failures]
    measure.write(head + ["\t".join(HEADER)] + lines, given.output)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
