"""Pictures of packings: their networks of forces, sensitivities of contacts, grains coloured by a table."""
from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap, LogNorm, Normalize, to_rgb

from .._core import Floats, invalid
from .._network import Network
from .._packing import Packing
from .._records import Material
from .._scene import Scene
from .._sensitivity import Gradient
from ._frame import ink, key, styled
from ._inputs import Input, inputs, network_of
from ._units import FORCE, PRESSURE, SPEED, TIME, label, number, refuse, to_si, unit_text
from ._view import EARLIER, GRAIN, LATER, RATTLER, SIGNED, View, add_bar, add_key, views

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


def result(found: list[View]) -> Any:
    """Axes, or an array of those of three views."""
    return found[0].ax if len(found) == 1 else np.array([view.ax for view in found], object)


def rattler_entry(count: int) -> list[Any]:
    words = {"marker": "o", "ls": "none", "mfc": RATTLER, "mec": "#8c8c8c", "mew": 0.4, "ms": 5}
    return [key(**words, label=f"{count} rattler{'s' * (count != 1)}")]


def grey_grains(packing: Packing, rattlers: npt.NDArray[np.bool_]) -> Floats:
    """Colours [n][3]: light grey, of rattlers darker."""
    return np.where(rattlers[:, None], to_rgb(RATTLER), to_rgb(GRAIN))


# ---- networks -------------------------------------------------------------------------------------------------------

@styled
def network(*data: Any, material: Material | None = None, ax: Any = None, scene: Scene | None = None) -> Any:
    """A packing with its contacts as lines, whose width shows the normal force. Rattlers are dark grey. Packings in
    three dimensions are drawn in three views: an array of three Axes."""
    return _chains(data, material, ax, scene, "F")


@styled
def stiffness(*data: Any, material: Material | None = None, ax: Any = None, scene: Scene | None = None) -> Any:
    """The same with the normal stiffness."""
    return _chains(data, material, ax, scene, "k")


def _chains(data: Any, material: Material | None, ax: Any, scene: Scene | None, symbol: str) -> Any:
    given = inputs(data, None, material)
    packing, material = packing_of(given[0]), given[0].material
    limit = threshold_of(scene)
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
        factor, unit = to_si(FORCE if symbol == "F" else "E* d", material)
        for word, value, width in (("mean", mean, MEAN_WIDTH * diameter), ("largest", values.max(), widths.max())):
            text = rf"{word} ${symbol}_\mathrm{{n}}$ = {number(factor * value, 3)} {unit_text(unit)}"
            entries.append(key(color=colour, lw=max(0.2, width), solid_capstyle="butt", label=text))
    add_key(found, entries + rattler_entry(int(rattlers.sum())))
    return result(found)


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


@styled
def sensitivity(*data: Any, material: Material | None = None, ax: Any = None, scene: Scene | None = None) -> Any:
    """A packing with what each contact does to a quantity when it becomes stiffer, as the width of its line, which
    grows as the root, and its colour: orange, the quantity grows; blue, it falls. data: a packing, and a table of
    `sonopack sensitivity --by kn,kt' or a Gradient (of network.sensitivity()); without these the arrival t10 is
    computed."""
    given = inputs(data, None, material)
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
    add_key(found, [key(color=LATER, lw=wide, solid_capstyle="butt", label=f"stiffer: ${symbol}$ larger"),
                    key(color=EARLIER, lw=wide, solid_capstyle="butt", label=f"stiffer: ${symbol}$ smaller"),
                    *rattler_entry(int(rattlers.sum())), key(ls="none", label=text)])
    return result(found)


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
        raise refuse(one.name,
                     "no columns contact and by_kn or by_kt, which a table of `sonopack sensitivity --by kn,kt' "
                               "has")
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
        raise refuse(one.name,
                     f"{what} {numbers[np.argmax(wrong)]:g}, the packing has {count}: the table is of another "
                               f"packing")
    if not np.all(np.isfinite(values)):
        raise refuse(one.name, f"row {int(np.argmin(np.isfinite(values))) + 1}: must have finite numbers")
    found = np.full(count, np.nan)
    found[numbers.astype(int)] = values
    return found


# ---- grains ---------------------------------------------------------------------------------------------------------

_COLUMNS = ("factor", "probability", "by_mass", "by_radius")


@styled
def grains(*data: Any, material: Material | None = None, ax: Any = None, scene: Scene | None = None) -> Any:
    """A packing whose grains are coloured by a column of a table: factor (`sonopack design --rows grains'), probability
    (`coda'), by_mass or by_radius (`sensitivity'). Orange is above 0 (a factor: 1), blue below. data: a packing and a
    table with the columns grain and one of these."""
    given = inputs(data, None, material)
    if len(given) != 2:
        raise invalid("", "grains: needs a packing and a table of its grains")
    packing, one = packing_of(given[0]), given[1]
    name = next((name for name in _COLUMNS if name in one.table), None)
    if name is None or "grain" not in one.table:
        raise refuse(one.name,
                     f"no column {'grain' if name else 'factor, probability, by_mass or by_radius'}: such tables "
                               f"come from `sonopack design --rows grains', `coda' and `sensitivity --by mass'")
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
    add_key(found, rattler_entry(int(rattlers.sum())))
    return result(found)


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
