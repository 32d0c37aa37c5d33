"""Pictures of packings: their networks of forces, sensitivities of contacts, grains coloured by a table; and histograms of
contacts: directions, normal forces and stiffnesses, as Figs. 2 and 1(c) of Somfai et al. 2005."""
from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap, LogNorm, Normalize, to_rgb

from .._core import Floats, invalid
from .._modes import Clusters
from .._network import Network
from .._packing import Packing
from .._records import Material
from .._scene import Scene
from .._sensitivity import Gradient
from .._table import Table
from ._frame import WIDTH, dash, figure, ink, key, legend, panels
from ._histograms import ContactCounts, contact_counts
from ._inputs import Input, network_of
from ._units import FORCE, PRESSURE, SPEED, TIME, label, number, refuse, to_si, unit_text
from ._view import EARLIER, GRAIN, LATER, RATTLER, RIM, SIGNED, add_bar, finish, key_below, picture, views

MEAN_WIDTH, LARGEST_WIDTH = 0.10, 1.0  # of the line of a contact of mean strength, and of the widest [mean diameters]
SLENDER = 0.4  # in three dimensions, where many lines lie behind each other, relative to that
THRESHOLD = 1e-4


def packing_of(one: Input) -> Packing:
    """The packing of a file, a Packing, or what was made of one."""
    source = one.source
    network = source if isinstance(source, Network) else getattr(source, "network", None)
    return network.packing if isinstance(network, Network) else one.packing


def threshold_of(scene: Scene | None) -> float:
    return float(scene._c.network.threshold) if scene else THRESHOLD


def disc(colour: str, text: str) -> Any:
    """An entry of a legend: a grain."""
    return key(marker="o", ls="none", mec=RIM, mew=0.4, ms=5, mfc=colour, label=text)


def rattler_entry(count: int) -> Any:
    return disc(RATTLER, f"{count} rattler{'s' * (count != 1)}")


def grey_grains(packing: Packing, rattlers: npt.NDArray[np.bool_]) -> Floats:
    """Colours [n][3]: light grey, of rattlers darker."""
    return np.where(rattlers[:, None], to_rgb(RATTLER), to_rgb(GRAIN))


# ---- networks -------------------------------------------------------------------------------------------------------

@figure
def network(given: Sequence[Input], *, ax: Any = None, scene: Scene | None = None) -> Any:
    """A packing with its contacts as lines, whose width shows the normal force. Rattlers are dark grey. Packings in
    three dimensions are drawn in three views: an array of three Axes."""
    return _chains(given[0], ax, scene, "F")


@figure
def stiffness(given: Sequence[Input], *, ax: Any = None, scene: Scene | None = None) -> Any:
    """The same with the normal stiffness."""
    return _chains(given[0], ax, scene, "k")


def _chains(one: Input, ax: Any, scene: Scene | None, symbol: str) -> Any:
    packing, limit = packing_of(one), threshold_of(scene)
    rattlers, carrying = packing.rattlers(limit), packing.carrying(limit)
    contacts = packing.contacts[carrying]
    values = contacts["fn"] if symbol == "F" else _stiffnesses(packing, limit)[carrying]
    found, colour = views(packing, ax), ink(1 if symbol == "F" else 2)
    mean = float(np.mean(values)) if len(values) else 0.0
    entries = []
    for view in found:
        view.grains(grey_grains(packing, rattlers))
    if mean > 0:
        diameter = found[0].diameter * found[0].points * (SLENDER if packing.dim == 3 else 1)
        widths = np.minimum(MEAN_WIDTH * values / mean, LARGEST_WIDTH) * diameter
        for view in found:
            view.links(contacts, widths, np.tile(to_rgb(colour), (len(values), 1)))
        factor, unit = to_si(FORCE if symbol == "F" else "E* d", one.material)
        for word, value, width in (("mean", mean, MEAN_WIDTH * diameter), ("largest", values.max(), widths.max())):
            text = rf"{word} ${symbol}_\mathrm{{n}}$ = {number(factor * value, 3)} {unit_text(unit)}"
            entries.append(key(color=colour, lw=max(0.2, width), solid_capstyle="butt", label=text))
    return finish(found, [*entries, rattler_entry(int(rattlers.sum()))])


def _stiffnesses(packing: Packing, threshold: float) -> Floats:
    """Normal stiffnesses of all contacts [E* d]; 0 of those that carry no force."""
    springs, found = packing.network(threshold=threshold).springs, np.zeros(len(packing.contacts))
    found[springs["contact"]] = springs["kn"]
    return found


# ---- sensitivities --------------------------------------------------------------------------------------------------

WIDEST, THINNEST = 0.65, 0.02  # lines of the largest size, and the thinnest line [mean diameters]
SOLID_WIDTH = 0.5  # in three dimensions, relative to that

#: symbols and units of what `sonopack sensitivity' differentiates
_SYMBOLS = {"t10": "t_{10}", "t_peak": r"t_\mathrm{peak}", "t_zero": r"t_\mathrm{zero}", "peak": r"F_\mathrm{peak}",
            "width": "w", "F": "F", "cl": "c_l", "ct": "c_t", "c_l": "c_l", "c_t": "c_t"}
_UNITS = {"t10": TIME, "t_peak": TIME, "t_zero": TIME, "width": TIME, "peak": FORCE, "F": FORCE, "cl": SPEED,
          "ct": SPEED, "c_l": SPEED, "c_t": SPEED, "omega": "E* / (rho d^2)"}


def symbol_of(quantity: str) -> str:
    """A quantity of `sonopack sensitivity' in a formula."""
    word, _, modes = quantity.partition(":")
    if word == "omega":  # of several modes the mean
        return rf"\omega_{{{modes}}}^2" if modes.isdigit() else r"\langle\omega^2\rangle"
    if word[:1] == "C" and word[1:].isdigit():
        return f"C_{{{word[1:]}}}"
    return _SYMBOLS.get(word, r"\mathrm{quantity}")


@figure
def sensitivity(given: Sequence[Input], *, ax: Any = None, scene: Scene | None = None) -> Any:
    """A packing with what each contact does to a quantity when it becomes stiffer, as the width of its line, which
    grows as the root, and its colour: orange, the quantity grows; blue, it falls. data: a packing, and a table of
    `sonopack sensitivity --by kn,kt' or a Gradient (of network.sensitivity()); without these the arrival t10 is
    computed."""
    packing = packing_of(given[0])
    made = given[1] if len(given) > 1 else Input(packing, None, given[0].material)
    values, quantity, unit = _contact_values(made, packing, scene, given[0].material)
    known = np.flatnonzero(np.isfinite(values))
    largest = float(np.max(np.abs(values[known]), initial=0))
    if not largest > 0:
        raise refuse(made.name, "all derivatives are 0: there is nothing to draw")
    order = known[np.argsort(np.abs(values[known]), kind="stable")]  # large ones lie on top
    found, rattlers = views(packing, ax), packing.rattlers(threshold_of(scene))
    diameter = found[0].diameter * found[0].points * (SOLID_WIDTH if packing.dim == 3 else 1)
    widths = np.maximum(WIDEST * np.sqrt(np.abs(values[order]) / largest), THINNEST) * diameter
    colours = np.where(values[order, None] > 0, to_rgb(LATER), to_rgb(EARLIER))
    for view in found:
        view.grains(grey_grains(packing, rattlers))
        view.links(packing.contacts[order], widths, colours)
    symbol, wide = symbol_of(quantity), min(widths.max(), 5.0)
    text = rf"widest: |$\partial {symbol}/\partial\ln k$| = {number(largest, 3)} {unit_text(unit)}"
    inks = [key(color=colour, lw=wide, solid_capstyle="butt", label=f"stiffer: ${symbol}$ {word}")
            for colour, word in ((LATER, "larger"), (EARLIER, "smaller"))]
    return finish(found, [*inks, rattler_entry(int(rattlers.sum())), key(ls="none", label=text)])


def _contact_values(one: Input, packing: Packing, scene: Scene | None,
                    material: Material | None) -> tuple[Floats, str, str]:
    """The derivative by the logarithm of both stiffnesses of each contact, nan where unknown; quantity and unit."""
    if isinstance(one.source, (Packing, Network)):
        made = network_of(packing, scene)
        return _of_gradient(made.sensitivity(), made, "t10", *to_si(TIME, material))
    if isinstance(one.source, Gradient):
        return _of_gradient(one.source, network_of(packing, scene), one.source.of,
                            *to_si(_UNITS.get(one.source.of, PRESSURE), material))
    columns = [name for name in ("by_kn", "by_kt") if name in one.table]
    if "contact" not in one.table or not columns:
        raise refuse(one.name, "no columns contact and by_kn or by_kt, which a table of `sonopack sensitivity --by "
                               "kn,kt' has")
    sums = np.sum([one.column(name) for name in columns], axis=0)
    values = spread(one, one.column("contact"), sums, len(packing.contacts), "contact")
    return values, one.table.metadata.get("quantity", ""), one.table.units[columns[0]]


def _of_gradient(made: Gradient, network: Network, quantity: str, factor: float, unit: str) -> tuple[Floats, str, str]:
    springs, values = network.springs, np.full(len(network.packing.contacts), np.nan)
    parts = [d * springs[name] for name, d in (("kn", made.kn), ("kt", made.kt)) if d is not None]
    if not parts:
        raise invalid("sensitivity", "has no derivatives by kn or kt: must be of network.sensitivity(by=('kn', 'kt'))")
    values[springs["contact"]] = factor * np.sum(parts, axis=0)
    return values, quantity, unit


def spread(one: Input, numbers: Floats, values: Floats, count: int, what: str) -> Floats:
    """Values of a table for all things of a packing [count]; nan where the table has none."""
    wrong = ~((numbers >= 0) & (numbers < count))
    if np.any(wrong):
        raise refuse(one.name, f"{what} {numbers[np.argmax(wrong)]:g}, the packing has {count}: the table is of "
                               f"another packing")
    if not np.all(np.isfinite(values)):
        raise refuse(one.name, f"row {int(np.argmin(np.isfinite(values))) + 1}: must have finite numbers")
    found = np.full(count, np.nan)
    found[numbers.astype(int)] = values
    return found


# ---- rigid clusters ------------------------------------------------------------------------------------------------

FEW = 6  # clusters with colours of their own


@figure
def clusters(given: Sequence[Input], *, ax: Any = None, scene: Scene | None = None) -> Any:
    """A packing whose contacts are coloured by their rigid cluster, the largest ones; redundant contacts are thick lines.
    data: a packing, and a table of `sonopack clusters' or Clusters (of network.clusters()); without these the pebble
    game (in three dimensions the motions) is computed."""
    packing, made = packing_of(given[0]), given[-1]
    if made.is_packing or isinstance(made.source, Network):
        made = Input(network_of(packing, scene).clusters(), None, given[0].material)
    if isinstance(made.source, Clusters):
        contact, cluster, redundant = made.source.network.springs["contact"], made.source.cluster, made.source.redundant
    else:
        hint = "a table of `sonopack clusters' has contact, cluster, redundant"
        contact, cluster, redundant = (made.column(name, hint) for name in ("contact", "cluster", "redundant"))
    number_of = spread(made, contact, cluster, len(packing.contacts), "contact")
    thick = spread(made, contact, redundant, len(packing.contacts), "contact")
    order = np.flatnonzero(np.isfinite(number_of))[::-1]
    colour = [to_rgb(ink(1 + k)) for k in range(FEW)] + [to_rgb("0.45"), to_rgb("0.75")]
    paint = np.where(number_of < 0, FEW + 1, np.minimum(number_of, FEW))[order].astype(int)
    found, rattlers = views(packing, ax), packing.rattlers(threshold_of(scene))
    widths = np.where(thick[order] > 0, 0.16, 0.06) * found[0].diameter * found[0].points
    for view in found:
        view.grains(grey_grains(packing, rattlers))
        view.links(packing.contacts[order], widths, np.array(colour)[paint])
    words = [*(f"cluster {k}" for k in range(FEW)), "other clusters", "in none"]
    entries = [key(color=colour[k], lw=2, label=words[k]) for k in range(FEW + 2) if np.any(paint == k)]
    entries += [key(color=colour[-2], lw=widths.max(), label="redundant")] if np.any(thick > 0) else []
    return finish(found, [*entries, rattler_entry(int(rattlers.sum()))])


# ---- grains ---------------------------------------------------------------------------------------------------------

_COLUMNS = ("factor", "probability", "by_mass", "by_radius")


@figure
def grains(given: Sequence[Input], *, ax: Any = None, scene: Scene | None = None) -> Any:
    """A packing whose grains are coloured by a column of a table: factor (`sonopack design --rows grains'), probability
    (`coda'), by_mass or by_radius (`sensitivity'). Orange is above 0 (a factor: 1), blue below. data: a packing and a
    table with the columns grain and one of these."""
    if len(given) != 2:
        raise invalid("", "grains: needs a packing and a table of its grains")
    packing, one = packing_of(given[0]), given[1]
    name = next((name for name in _COLUMNS if name in one.table), None)
    if name is None or "grain" not in one.table:
        raise refuse(one.name, f"no column {'grain' if name else 'factor, probability, by_mass or by_radius'}: such "
                               f"tables come from `sonopack design --rows grains', `coda' and `sensitivity --by mass'")
    values = spread(one, one.column("grain"), one.column(name), packing.n, "grain")
    scale = _scale(one, name, values)
    colours = scale.to_rgba(np.where(np.isnan(values), 1 if name == "factor" else 0, values))[:, :3]
    found, rattlers = views(packing, ax), packing.rattlers(threshold_of(scene))
    for view in found:
        view.grains(np.where(rattlers[:, None], to_rgb(RATTLER), colours))
    bar = add_bar(found, scale, _bar_label(one, name))
    if name == "factor":
        ticks = np.geomspace(scale.norm.vmin, scale.norm.vmax, 5)
        bar.set_ticks(ticks, labels=[number(tick, 3) for tick in ticks])
        bar.minorticks_off()
    return finish(found, [rattler_entry(int(rattlers.sum()))])


def _scale(one: Input, name: str, values: Floats) -> ScalarMappable:
    """Colours from blue over the grey of grains to orange: symmetric about 0, or about 1 on a scale of logarithms; of
    probabilities only the upper half."""
    if name == "factor" and np.any(values <= 0):
        raise refuse(one.name, f"factor = {np.nanmin(values):g}: must be above 0")
    most = float(np.nanmax(np.abs(np.log(values) if name == "factor" else values), initial=0))
    if not most > 0:
        raise refuse(one.name, "all grains are alike: there is nothing to draw")
    if name == "factor":
        return ScalarMappable(LogNorm(np.exp(-most), np.exp(most)), SIGNED)
    if name == "probability":
        return ScalarMappable(Normalize(0, most), ListedColormap(SIGNED(np.linspace(0.5, 1, 256))))
    return ScalarMappable(Normalize(-most, most), SIGNED)


def _bar_label(one: Input, name: str) -> str:
    if not name.startswith("by_"):
        return name
    quantity = symbol_of(one.table.metadata.get("quantity", ""))
    return label(rf"$\partial {quantity}/\partial\ln {'m' if name == 'by_mass' else 'R'}$", one.table.units[name])


# ---- histograms of contacts -----------------------------------------------------------------------------------------

BULK = 3.0  # distance of the contacts from the walls [d]
ENOUGH = 60  # contacts of a bin; with fewer, three bins become one
CURVES = {"all": ("all contacts", 0, 1.6, 0), "strong": (r"strong: $F > \langle F\rangle$", 2, 1.0, 0),
          "weak": (r"weak: $F \leq \langle F\rangle$", 1, 1.0, 1)}  # label, ink, width, dash


def _counted(given: Sequence[Input], scene: Scene | None, make: Callable[[ContactCounts], Table]) -> Input:
    """The table that is given, or the counts of all packings."""
    if len(given) == 1 and not given[0].is_packing and not hasattr(given[0].source, "packing"):
        return given[0]
    return Input(make(contact_counts(((one.name, packing_of(one)) for one in given), threshold_of(scene), BULK)))


# ---- directions -----------------------------------------------------------------------------------------------------

@figure
def angles(given: Sequence[Input], *, ax: Any = None, scene: Scene | None = None) -> Axes:
    """Directions of the contacts of packings, at least 3 d from the walls: all, strong and weak contacts. A circle of
    radius 1 is isotropic. In three dimensions angles are those above the horizontal. data: packings, or a table with
    the columns angle, all, strong, weak. ax: polar Axes."""
    one = _counted(given, scene, ContactCounts.angles)
    angle, densities = _densities(one)
    quarter, merged = one.number("dimension") == 3, _merged(one, len(angle))
    if ax is None:
        ax = picture(WIDTH).add_subplot(projection="polar", label="panel")
    elif ax.name != "polar":
        raise invalid("ax", "must have projection='polar'")
    largest = 0.0
    for name, density in densities.items():
        text, colour, width, dashes = CURVES[name]
        edges, values = _bins(angle, density, merged)
        largest = max(largest, values.max())
        around, radii = _outline(edges, values, quarter)
        ax.plot(around, radii, color=ink(colour), lw=width, ls=dash(dashes), label=text)
    _rings(ax, largest, quarter)
    return ax


def _densities(one: Input) -> tuple[Floats, dict[str, Floats]]:
    """Angles in degrees, and densities over that of isotropic directions."""
    hint = "a table of directions has angle, all, strong, weak"
    angle, found = one.column("angle", hint), {"all": one.column("all", hint)}
    found |= {name: one.column(name) for name in ("strong", "weak") if name in one.table}
    if len(angle) < 2 or not np.all(np.diff(angle) > 0):
        raise refuse(one.name, "angle: must be two or more numbers that rise from row to row")
    if not any(np.any(values > 0) for values in found.values()):
        raise refuse(one.name, f"nothing to draw: no row of {len(angle)} has a density above 0")
    return angle, {name: np.nan_to_num(values) for name, values in found.items()}


def _merged(one: Input, rows: int) -> int:
    """Few contacts in narrow bins are noise: three rows become one bin, with the middle one in its middle."""
    few = one.number("contacts") / rows < ENOUGH and one.number("dimension") in (2, float("nan"))
    return 3 if few and rows % 3 == 0 and rows >= 12 else 1


def _bins(angle: Floats, density: Floats, merged: int) -> tuple[Floats, Floats]:
    """Edges [bins + 1] in radians, over half a turn, and densities."""
    values = np.roll(density, merged // 2).reshape(-1, merged).mean(axis=1)
    middles = angle[::merged]
    around = np.concatenate([[middles[-1] - 180], middles, [middles[0] + 180]])
    return np.deg2rad(0.5 * (around[1:] + around[:-1])), values


def _outline(edges: Floats, values: Floats, quarter: bool) -> tuple[Floats, Floats]:
    """Arcs of the bins of n and of -n, joined by radii; of a quarter the part above the horizontal."""
    pieces = [np.linspace(low, high, max(2, int((high - low) / 0.02))) for low, high in zip(edges, edges[1:])]
    half = np.concatenate(pieces)
    radii = np.repeat(values, [len(piece) for piece in pieces])
    if quarter:
        return half, np.where((half >= 0) & (half <= np.pi / 2), radii, np.nan)
    around, both = np.concatenate([half, half + np.pi]), np.tile(radii, 2)
    return np.append(around, around[0] + 2 * np.pi), np.append(both, both[0])


def _rings(ax: Any, largest: float, quarter: bool) -> None:
    """Rings at round values, that at 1 thicker, with their numbers outside the curves; every 30 degrees."""
    step = float(np.ceil(largest / 2.4)) if largest > 2.4 else 0.5
    rings = step * np.arange(1, np.ceil(largest / step) + 1)
    ax.set_rgrids(rings, [f"{ring:g}" for ring in rings], angle=0 if quarter else 22.5, fontsize=6.5)
    ax.set_thetagrids(np.arange(0, 91 if quarter else 360, 30), fontsize=6.5)
    ax.set_rlim(0, rings[-1])
    ax.set_thetamax(90 if quarter else 360)
    ax.tick_params(pad=1)
    ax.grid(color="0.7", lw=0.4)
    ax.minorticks_off()
    ax.plot(np.linspace(0, np.pi / 2 if quarter else 2 * np.pi, 200), np.ones(200), color="0.5", lw=1.0, zorder=1)
    ax.spines[:].set_visible(quarter)
    ax.set_axisbelow(False)  # the numbers of rings stand above the curves
    for text in ax.get_yticklabels():
        text.set_bbox({"fc": "white", "ec": "none", "pad": 0.6, "alpha": 0.8})
    title = "radius: density, isotropic 1" + ("; angle above the horizontal" if quarter else "")
    key_below(ax, [line for line in ax.lines if not line.get_label().startswith("_")], title)


# ---- values ---------------------------------------------------------------------------------------------------------

@figure
def forces(given: Sequence[Input], *, ax: Any = None, scene: Scene | None = None) -> Axes:
    """Histograms of normal forces and stiffnesses, divided by their means, with standard errors over several packings.
    data: packings, or a table with the columns x, forces, stiffnesses."""
    one = _counted(given, scene, ContactCounts.values)
    hint = "a table of contact values has x, forces, stiffnesses"
    x, values = one.column("x", hint), [one.column(name, hint) for name in ("forces", "stiffnesses")]
    if len(x) < 2:
        raise refuse(one.name, f"{len(x)} rows of values, must be 2 or more")
    edges = np.concatenate([[1.5 * x[0] - 0.5 * x[1]], 0.5 * (x[1:] + x[:-1]), [1.5 * x[-1] - 0.5 * x[-2]]])
    ax = panels(ax=ax)[0, 0]
    for k, (name, density) in enumerate(zip(("forces", "stiffnesses"), values)):
        ax.stairs(density, edges, color=ink(1 + k), ls=dash(k), lw=1.0, label=f"normal {('force', 'stiffness')[k]}")
        error = one.errors(name)
        if error is not None and np.any(error > 0):
            ax.errorbar(x, density, yerr=np.nan_to_num(error), ls="none", color=ink(1 + k), elinewidth=0.5, capsize=0)
    ax.set(xlim=(edges[0], edges[-1]), ylim=(0, None), xlabel=r"$F_\mathrm{n}/\langle F_\mathrm{n}\rangle$,  "
           r"$k_\mathrm{n}/\langle k_\mathrm{n}\rangle$", ylabel="probability density")
    legend(ax)
    return ax
