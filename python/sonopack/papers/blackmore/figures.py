"""The figures of the paper: Fig. 1, trajectories of five and of ten particles, and what the taps cost; Fig. 2, the continua
beside the lattice; and (35) and (37) as printed, growth rates and speeds of their waves, and the refusal to run them."""
from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..._column import Column
from ..._core import Floats, Refused
from ..._table import Table
from ..sheet import Curve, Panel, Sheet
from ..work import Tell, Work
from .column import AMPLITUDE, GRAVITY, coefficients, column, speed2
from .rows import add

# ---- Fig. 1 ---------------------------------------------------------------------------------------------------------

def make_fig1(work: Work, tell: Tell) -> None:
    for k, n in enumerate((5, 10)):
        tables = {output: column(n, step=0.0025, output=output).table()
                  for output in ("trajectory", "strobe", "energy")}
        f = 9.5 if n == 10 else 7.5
        omega = 2 * math.pi * f
        add(work, f"gamma-{n}", AMPLITUDE * omega * omega / GRAVITY, n=n, f=f)
        _densities(work, column(n), tables["strobe"])
        _taps(work, column(n), tables["energy"])
        for tap in range(tables["strobe"].rows):
            for i in range(1, n + 1):
                add(work, "position", tables["strobe"][f"y{i}"][tap], detail=True, i=i, tap=tap, n=n)
        _show_one(work, n, f, tables)
        tell(0.5 * (k + 1))
    work.say("fig1",
             "That a column grows denser is no law: contacts come to rest anywhere within the band of forces that "
             "friction allows, K (1 -+ e) times the overlap. All positions are in the table of rows (fig1.tsv), with "
             "an error of 1e-8 cm at the most.")


def _densities(work: Work, c: Column, strobe: Table) -> None:
    """Before the first tap and at .99T, 1.99T, ..."""
    before, after = c.density(np.append(0.0, c.rest())), strobe["density"]
    add(work, "before", before, n=c.particles)
    for tap, density in enumerate(after):
        add(work, "after", density, tap=tap + 1, n=c.particles)
    work.say("fig1",
             f"N = {c.particles}: m N over the length of the column is {before:.6f} g/cm before the first tap; that "
             f"tap changes it by {100 * (after[0] / before - 1):+.2f}%, all four by "
             f"{100 * (after[-1] / before - 1):+.2f}%.")


def _taps(work: Work, c: Column, energy: Table) -> None:
    for tap in range(energy.rows):
        done = energy["work"][tap]
        words: dict[str, Any] = {"tap": tap + 1, "n": c.particles, "detail": tap > 0}
        error = abs(energy["residual"][tap]) * done
        add(work, "rest", energy["rest"][tap], **words)
        add(work, "work", done, error, **words)
        add(work, "dissipated", energy["dissipated"][tap], error, **words)
    rest = energy["rest"]
    latest = math.inf if np.isnan(rest).any() else max(0.0, *map(float, rest))  # NAN: never at rest
    add(work, "settled", latest, paper=0.99 * c.period, n=c.particles)
    add(work, "separation", energy["separation"].min(), n=c.particles)


def _show_one(work: Work, n: int, f: float, tables: dict[str, Table]) -> None:
    for name, output in (("trajectories", "trajectory"), ("strobe", "strobe"), ("energy", "energy")):
        work.save_table(f"fig1-n{n}-{name}", tables[output])
    for name, output in (("trajectories", "trajectory"), ("strobe", "strobe")):
        work.draw("fig1", f"fig1-n{n}-{name}", "column", tables[output], caption=work.texts[name].format(n=n, f=f))


# ---- Fig. 2 ---------------------------------------------------------------------------------------------------------

MODELS = {"lattice": "lattice", "longwave": "long wave", "bsr": "BSR"}
PAIRS = (("lattice", "longwave"), ("lattice", "bsr"), ("longwave", "bsr"))


def make_fig2(work: Work, tell: Tell) -> None:
    fine, coarse = {}, {}
    for k, model in enumerate(MODELS):
        fine[model] = column(10, model=model).table()
        # the lattice has no grid
        coarse[model] = fine[model] if model == "lattice" else column(10, model=model, cells=4).table()
        work.save_table(f"fig2-{model}", fine[model])
        tell(0.2 * (k + 1))
    for a, b in PAIRS:
        ours, rough = distance(fine[a], fine[b]), distance(coarse[a], coarse[b])
        for how, value, other in zip(("mean", "largest"), ours, rough):
            add(work, f"{b}-{a}", value, abs(value - other), how=how)
    _heights(work, fine, coarse)
    _collapse(work)
    if work.folder:
        _show_two(work, fine)


def _positions(table: Table) -> Floats:
    """Of the particles [times][N]: the columns behind t and the floor."""
    return np.array([table[name] for name in table.names[2:]]).T


def distance(a: Table, b: Table) -> tuple[float, float]:
    """Mean and largest difference of positions over particles and times."""
    off = np.abs(_positions(a) - _positions(b))
    return float(off.mean()), float(off.max())


def _heights(work: Work, fine: dict[str, Table], coarse: dict[str, Table]) -> None:
    high = {}
    for model, name in MODELS.items():
        high[model], other = (max(0.0, float(each[model]["y10"].max())) for each in (fine, coarse))
        error = 1e-8 if model == "lattice" else abs(high[model] - other)
        add(work, "highest", high[model], error, n=10, model=name)
    work.say("fig2",
             "The long wave is a well-posed limit of the lattice, BSR a conservative model with the same contact law "
             "(neither is the printed one, see below and the errata), for the ten particles of Fig. 1: the tap that "
             f"the paper calls much longer is not given. The top rises to {high['lattice']:.2f} cm in the lattice, "
             f"{high['longwave']:.2f} in the long wave and {high['bsr']:.2f} in BSR; the long wave is "
             f"{distance(fine['lattice'], fine['longwave'])[0]:.3f} cm off in the mean, of a column of {20:g} cm.")


def _collapse(work: Work) -> None:
    """(45) as printed and with corrected signs: the columns fall through the floor."""
    for form, name in (("literal", "(45) as printed"), ("signed", "(45) with sgn(y)")):
        c = column(10, model="bsr", bsr=form)
        run = c.run([])
        add(work, "collapse", run.taps[0].separation, form=name, t=run.violated_at,
            where="floor and particle 1" if run.violated == 0 else "two particles")
        down = ", downwards" if form == "literal" else ""
        work.say("fig2", f"{name}: its force is {c.bsr_force(form):.4f} m g at the most{down}; the column collapses, "
                         f"ordering (1) fails at t = {run.violated_at:.5f} s.")


def _show_two(work: Work, fine: dict[str, Table]) -> None:
    work.draw("fig2", "fig2-surfaces", "column", *fine.values(), labels=["lattice", "long wave", "BSR, conservative"])
    errors = column(10, output="compare").table()
    work.save_table("fig2-errors", errors)
    work.draw("fig2", "fig2-errors", "column", errors)


# ---- (35) and (37) --------------------------------------------------------------------------------------------------

STEP = 0.01  # the paper's steps [s, cm]
WAVES = 241
NAMES = ("eq35", "eq37", "longwave", "lattice")


def make_symbols(work: Work, tell: Tell) -> None:
    c = column(10)
    k, growth, squares = _evaluate(c)
    plus, _, b = coefficients(c.radius(), 1 / (2 * c.radius()))
    add(work, "plus", plus)
    add(work, "b", b * 2 * c.radius())
    _growth(work, c, k, growth[1])
    _speeds(work, c)
    _refusals(work)
    columns = {f"{kind}_{name}": values[j] for j, name in enumerate(NAMES)
               for kind, values in (("growth", growth), ("speed2", squares))}
    table = Table.from_columns({"k": k, **columns}, {"k": "1/cm", **{f"growth_{name}": "1/s" for name in NAMES}})
    table.add_comment("linearised about y = z, alpha = 1/h; ten particles of Fig. 1; speed2 in K h^2/m; the lattice's "
                      "waves end at k = pi/h")
    work.draw_sheet("symbols", "symbols-waves", _sheet(k, growth, squares), table)


def _evaluate(c: Column) -> tuple[Floats, Floats, Floats]:
    """Wave numbers, and growth rates and squared speeds of the four models, linearised about y_z = 1."""
    h, unit = 2 * c.radius(), speed2(c)
    k = 0.01 * 10**np.linspace(0, 4.5, WAVES)
    found = [[c.symbol(model, wave, alpha=1 / h) for wave in k.tolist()] for model in NAMES[:3]]
    growth = np.array([[at.growth for at in row] for row in found] + [[0.0] * WAVES])
    lattice = np.where(k * h <= math.pi, (np.sin(0.5 * k * h) / (0.5 * k * h))**2, math.nan)
    return k, growth, np.array([[at.speed2 / unit for at in row] for row in found] + [lattice.tolist()])


def _growth(work: Work, c: Column, k: Floats, growth: Floats) -> None:
    """The largest growth rate of (37), and that of (35) on the paper's grid."""
    h = 2 * c.radius()
    near = float(k[np.argmax(growth)])
    # steps of 1e-4, of which the error of the maximum is quadratic
    most, at = max((c.symbol("eq37", wave, alpha=1 / h).growth, wave)
                   for wave in np.geomspace(near / 1.05, near * 1.05, 977).tolist())
    add(work, "growth", most, 1e-6 * most, k=at, factor=math.exp(STEP * most))
    add(work, "grid", c.symbol("eq35", math.pi / STEP, alpha=1 / h).growth)
    work.say("symbols",
             f"(37) has no waves below k = {at * math.sqrt(2):.3g} /cm: they grow, by up to {most:.4g} /s. (35), of "
             "the other sign, has waves there and growth above, without bound in k. No scheme helps: a finer one "
             "follows the growth better.")


def _speeds(work: Work, c: Column) -> None:
    h, unit = 2 * c.radius(), speed2(c)
    add(work, "expansion", c.expansion_speed2(1 / h) / unit)
    add(work, "cfl", math.sqrt(unit))
    add(work, "longwave", c.symbol("longwave", math.pi / h, alpha=1 / h, slope=0.95).growth)


def _refusals(work: Work) -> None:
    """The library refuses both, and says why."""
    for model, name in (("eq35", "(35)"), ("eq37", "(37)")):
        why = ""
        try:
            column(10, model=model).run([])
        except Refused as fault:
            why = str(fault)
        add(work, f"run-{model}", 0 if why else 1, paper=None if model == "eq37" else math.nan)
        work.say("symbols", f"The command refuses {name}: {why}.")


def _sheet(k: Floats, growth: Floats, squares: Floats) -> Sheet:
    labels = ("(35) as printed", "(37) as printed", "long wave here", "lattice")
    looks: list[dict[str, Any]] = [{"ink": 1}, {"ink": 2, "dash": 1}, {"ink": 3}, {"ink": 0, "dash": 2}]
    shown = np.where(growth > 0, growth, np.nan)  # a logarithmic axis cannot show others
    rates = [Curve(k, shown[j], labels[j], **looks[j]) for j in range(2)]
    speeds = [Curve(k, squares[j], labels[j] if j > 1 else "", **looks[j]) for j in range(4)]
    return Sheet([Panel(rates, "|k| [1/cm]", "growth rate [1/s]", tag="(a)", log="xy", x=(0.01, 316), y=(1, 5e7)),
                  Panel(speeds, "|k| [1/cm]", "|c|^{2}/(|K| |h|^{2}/|m|)", tag="(b)", log="x", x=(0.01, 316), y=(-8, 8),
                        zero=True)], columns=2)
