"""The figure of the benchmark `leap_distance', from its tables."""
import csv

import numpy as np

COLOURS = {1e-6: "#0072b2", 1e-5: "#56b4e9", 1e-4: "#009e73", 1e-3: "#e69f00", 1e-2: "#d55e00"}
MARKS = {0.0: "o", 0.1: "s", 0.5: "^"}
ROWS = (("loss", r"$\alpha/k$", "wave"), ("speed", r"$c/c_\ell$", "planes"), ("gamma", r"$\gamma$", "planes"),
        ("alpha", r"$\alpha$ of the width", "planes"))
COLUMNS = ((2, False, "2D"), (2, True, r"2D, in $\ell_s$"), (3, True, r"3D, in $\ell_s$"))


def table(results, name):
    with open(results / f"leap-distance-{name}.tsv") as file:
        found = list(csv.DictReader(file, delimiter="\t"))
    for row in found:
        for key, value in row.items():
            try:
                row[key] = float(value)
            except ValueError:
                pass
    return found


def kind(row):
    return tuple(row[name] for name in ("dimension", "friction", "p", "width", "grains", "protocol"))


def usual(series):
    """Those of the page, not of its checks: by the affine protocol, in the usual box, and the highest of these."""
    width = {2: 24, 3: 10}
    own = [r for r in series if r["protocol"] == "affine" and r["width"] == width[r["dimension"]]]
    key = lambda r: (r["dimension"], r["friction"], r["p"])
    most = {key(r): max(o["grains"] for o in own if key(o) == key(r)) for r in own}
    return {kind(r): r for r in own if r["grains"] == most[key(r)]}


def points(rows, quantity, length, first, end=1e9):
    """x, y and errors: of the wave over k times the length, of the front over the distance in the length."""
    if quantity == "loss":
        near = [r for r in rows if 0.06 < r["k"] < 1.2][::2] if first > 8 else []
        return [(r["k"] * length, r["alpha"] / r["k"], r["alpha_err"] / r["k"]) for r in near]
    return [(r["between"] / length, r[quantity], r[quantity + "_err"]) for r in rows
            if first <= r["from"] < end]


def curve(axis, curves, dim, quantity):
    own = [c for c in curves if c["dimension"] == dim and c["quantity"] == quantity]
    x = np.array([c["over_l_s"] for c in own])
    axis.plot(x, [c["value"] for c in own], "-", lw=0.8, color="0.4", zorder=1)


def panel(axis, data, series, quantity, source, dim, scaled):
    for own, row in series.items():
        if own[0] != dim:
            continue
        mine, length = [r for r in data[source] if kind(r) == own], row["l_s"] if scaled else 1.0
        for found, solid in ((points(mine, quantity, length, 8, 16), 0.3), (points(mine, quantity, length, 16), 1)):
            if found:
                x, y, error = np.array(found).T
                axis.errorbar(x, y, error, fmt=MARKS[own[1]], ms=2.6, lw=0.6, mew=0.5, color=COLOURS[own[2]], alpha=solid,
                              mfc="white" if own[1] == 0 else None)
    if scaled and quantity != "loss":
        curve(axis, data["curves"], dim, quantity)
    unit = r"\ell_s" if scaled else "d"
    axis.set(xscale="log", xlabel=f"$k\\,{unit}$" if quantity == "loss" else f"$L/{unit}$")
    axis.grid(True, which="major", lw=0.3)


def limits(axes):
    for k, (row, bounds) in enumerate(zip(axes, ((-0.02, 0.34), (1.0, 1.65), (0.4, 2.2), (0.25, 1.4)))):
        for column, axis in enumerate(row):
            axis.set_ylim(*bounds)
            axis.minorticks_off()
            if k == 0:
                axis.set_xlim(0.055, 1.3) if column == 0 else axis.set_xlim(0.15, 15)
            else:
                axis.set_xlim(8, 130) if column == 0 else axis.set_xlim(0.7, 90)
            if column > 0:
                axis.set_yticklabels([])


def legend(figure, plt):
    entries = [plt.Line2D([], [], marker=MARKS[mu], ls="", ms=4, color="0.2", mfc="white" if mu == 0 else None,
                          label=rf"$\mu$ = {mu:g}") for mu in MARKS]
    entries += [plt.Line2D([], [], marker="o", ls="", ms=4, color=c, label=f"$p = 10^{{{np.log10(p):.0f}}}$")
                for p, c in COLOURS.items()]
    figure.legend(handles=entries, loc="upper center", ncol=8, frameon=False, fontsize=7.5, handletextpad=0.1,
                  columnspacing=1.0)


def draw(path, results):
    import matplotlib
    matplotlib.use("svg")
    import matplotlib.pyplot as plt
    matplotlib.rcParams.update({"svg.hashsalt": "distance", "font.size": 8.5})
    data = {name: table(results, name) for name in ("wave", "planes", "curves")}
    series = usual(table(results, "series"))
    figure, axes = plt.subplots(4, 3, figsize=(7.2, 8.6))
    for row, (quantity, label, source) in zip(axes, ROWS):
        for axis, (dim, scaled, title) in zip(row, COLUMNS):
            panel(axis, data, series, quantity, source, dim, scaled)
            if quantity == "loss":
                axis.set_title(title, fontsize=8.5)
        row[0].set_ylabel(label)
    limits(axes)
    legend(figure, plt)
    figure.tight_layout(rect=(0, 0, 1, 0.97))
    figure.savefig(path, metadata={"Date": None})
    print(path)


def draw_lengths(path, results):
    """The length of scattering against the contacts beyond isostatic."""
    import matplotlib
    matplotlib.use("svg")
    import matplotlib.pyplot as plt
    matplotlib.rcParams.update({"svg.hashsalt": "lengths", "font.size": 9})
    figure, axes = plt.subplots(1, 2, figsize=(7.2, 3.1), sharey=True)
    for own, r in usual(table(results, "series")).items():
        axes[int(own[0]) - 2].errorbar(r["dz"], r["l_s"], r["l_s_err"], r["dz_err"], fmt=MARKS[own[1]], ms=4, lw=0.8,
                                       color=COLOURS[own[2]], mfc="white" if own[1] == 0 else None)
    for axis, title in zip(axes, ("2D", "3D")):
        axis.set(xscale="log", yscale="log", xlabel=r"$z - z_c$", title=title)
        axis.grid(True, which="both", lw=0.3)
    axes[0].set_ylabel(r"$\ell_s/d$")
    figure.tight_layout()
    figure.savefig(path, metadata={"Date": None})
    print(path)
