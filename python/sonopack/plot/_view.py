"""Pictures of a packing on Axes: its grains, walls, lines and arrows; three views of one in three dimensions."""
from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colorbar import Colorbar
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.colors import LinearSegmentedColormap, to_rgb
from matplotlib.figure import Figure
from matplotlib.legend_handler import HandlerPatch
from matplotlib.patches import Annulus, FancyArrow, Polygon, Rectangle
from matplotlib.quiver import Quiver

from .._core import Floats, Integers
from .._packing import Packing
from ._frame import WIDTH, new_figure

GRAIN, RATTLER, RIM, WALL = "#f5f5f5", "#b8b8b8", "#8c8c8c", "#404040"
LATER, EARLIER = "#e69f00", "#0072b2"  # a light and a dark ink: grey print tells them apart
#: from below to above 0, which is as light as a grain
SIGNED = LinearSegmentedColormap.from_list("signed", ["#08306b", EARLIER, GRAIN, LATER, "#b84a00"])

MARGIN, THICK = 3.0, 4.0  # around the picture, and of a wall [pt]
TALLEST = 22 / 2.54 * 72  # [pt]
MANY = 5000  # things of one kind, above which vector figures get them as an image
SOLID_SIZE = 0.5  # in three dimensions: of a grain as drawn over its own, so that those behind it can be seen
PALE = 0.75  # how much of the colour of the farthest grains is white


class View:
    """A packing on Axes, whose coordinates are those of the packing [d]. across, rise: the axes of the packing that run
    to the right (-1: none) and upwards. points: in a diameter d [pt]. shift [n][3]: of grains that moved [d]."""

    ax: Axes

    def __init__(self, packing: Packing, across: int, rise: int, shift: Floats | None = None) -> None:
        self.packing, self.across, self.rise, self.shift, self.points = packing, across, rise, shift, 1.0
        self.solid = packing.dim == 3
        self.above = self.solid and rise == 1  # seen from above
        self.ring = packing.cell == "ring"
        self.periodic = across >= 0 and packing.cell in ("piston", "periodic")  # to the right
        self.tiled = packing.cell == "periodic" or (self.above and packing.cell == "piston")  # upwards, too
        self.boxed = across >= 0 and packing.cell == "box"  # walls at the sides
        self.width = packing.box[across] if across >= 0 else 2.2 * float(packing.r.max())
        self.height = packing.box[0 if self.ring else rise]
        #: how far the top of a tilted cell lies to the right
        self.slant = packing.tilt[across + rise - 1] if 0 <= across < rise else 0.0
        self.left = min(0.0, self.slant) - (0.5 * self.width if across < 0 else 0.0)
        self.span = self.width + abs(self.slant)
        self.diameter = 2 * float(np.mean(packing.r))  # mean [d]

    # ---- the frame --------------------------------------------------------------------------------------------------

    def open(self) -> View:
        """Limits and walls."""
        wall = THICK / self.points
        beside, below = wall * (self.boxed or self.ring), wall * (not self.tiled)
        right = self.left + self.span
        self.ax.set(aspect="equal", xlim=(self.left - beside, right + beside), ylim=(-below, self.height + below),
                    xticks=[], yticks=[])
        self.ax.spines[:].set_visible(False)
        ends, wide = (-wall, self.height) if below else (), self.span + 2 * beside
        boxes = [(self.left - beside, low, wide, wall) for low in ends]
        boxes += [(low, -wall, wall, self.height + 2 * wall) for low in (self.left - wall, right)] if beside else []
        for x, y, width, height in () if self.ring else boxes:
            self.ax.add_patch(Rectangle((x, y), width, height, fc=WALL, lw=0, zorder=4))
        outer = 0.5 * self.width
        for radius in (outer + wall, outer - self.packing.box[1]) if self.ring else ():
            self.ax.add_patch(Annulus((outer, outer), radius, wall, fc=WALL, lw=0, zorder=4))
        self._edges(right)
        if self.solid:
            self.ax.set_xlabel(rf"${'xyz'[self.across]}\,\rightarrow$", loc="left", labelpad=1, fontsize=6.5)
            self.ax.set_ylabel(rf"${'xyz'[self.rise]}\,\rightarrow$", loc="bottom", labelpad=1, fontsize=6.5)
        return self

    def _edges(self, right: float) -> None:
        """Dashed lines at the edges that grains cross."""
        words: dict[str, Any] = {"color": "black", "lw": 0.5, "ls": (0, (4, 4)), "zorder": 4}
        if self.slant:
            self.ax.add_patch(self._outline(fill=False, **words))
            return
        sides = [((x, x), (0.0, self.height)) for x in (self.left, right)] if self.periodic else []
        sides += [((self.left, right), (y, y)) for y in (0, self.height)] if self.tiled else []
        for x, y in sides:
            self.ax.plot(x, y, **words)

    def _outline(self, **words: Any) -> Polygon:
        return Polygon([(0, 0), (self.width, 0), (self.width + self.slant, self.height), (self.slant, self.height)],
                       **words)

    # ---- where things are -------------------------------------------------------------------------------------------

    @functools.cached_property
    def places(self) -> Floats:
        """Centres of the grains within the box [n][2]. Upwards first: in a tilted cell the image above lies beside."""
        x = self.packing.x if self.shift is None else self.packing.x + self.shift
        up = x[:, self.rise].copy()
        across = x[:, self.across].copy() if self.across >= 0 else np.zeros(len(x))
        if self.tiled:
            cells = np.floor(up / self.height)
            up, across = up - cells * self.height, across - cells * self.slant
        if self.periodic:
            start = self.slant * up / self.height if self.tiled else 0.0
            across -= self.width * np.floor((across - start) / self.width)
        return np.stack([across, up], axis=1)

    def seen(self, low: Floats, high: Floats, far: Floats) -> tuple[Integers, Floats]:
        """Things that span from low to high [n][2] and their images at the periodic edges that reach into the frame, from
        the farthest to the nearest: numbers, and offsets [images][2]."""
        found, offsets = [], []
        for a in (0, -1, 1) if self.periodic else (0,):
            for b in (0, -1, 1) if self.tiled else (0,):
                step, there = np.array([a * self.width + b * self.slant, b * self.height]), np.full(len(low), True)
                if a or b:
                    ends = np.array([[self.left, 0], [self.left + self.span, self.height]])
                    there = np.all((high + step >= ends[0]) & (low + step <= ends[1]), axis=1)
                found.append(np.flatnonzero(there))
                offsets.append(np.broadcast_to(step, (len(found[-1]), 2)))
        numbers, steps = np.concatenate(found), np.concatenate(offsets)
        order = np.lexsort((numbers, -far[numbers]))
        return numbers[order], steps[order]

    def project(self, vectors: Floats) -> Floats:
        """Components of vectors [n][3] to the right and upwards."""
        across = vectors[:, self.across] if self.across >= 0 else np.zeros(len(vectors))
        return np.stack([across, vectors[:, self.rise]], axis=1)

    def towards(self, vectors: Floats) -> Floats:
        """Components towards the viewer: that of a rotation is positive counterclockwise."""
        return vectors[:, 2] if self.above else -vectors[:, 1] if self.across == 0 else vectors[:, 0]

    def far(self, grains: Integers, along: Floats | float = 0.0) -> Floats:
        """Distance from the viewer, 0 .. 1 of the box, of places at `along` from grains in the direction of view."""
        if not self.solid:
            return np.zeros(len(grains))
        p, away = self.packing, 3 - self.across - self.rise
        walls = p.cell == "box" or (p.cell == "piston" and away == 2)
        x, (xy, xz, yz) = p.x[grains].copy(), p.tilt
        if p.cell == "periodic":  # straighten the cell
            x[:, 1] -= yz * x[:, 2] / p.box[2]
            x[:, 0] -= xz * x[:, 2] / p.box[2] + xy * x[:, 1] / p.box[1]
        deep = (x[:, away] + along) / p.box[away]
        part = np.clip(deep, 0, 1) if walls else deep - np.floor(deep)
        shares: Floats = part if away == 1 else 1 - part
        return shares

    # ---- drawing ----------------------------------------------------------------------------------------------------

    def grains(self, fill: npt.ArrayLike) -> EllipseCollection:
        """Discs; fill [n][3]: their colours."""
        far, r = self.far(np.arange(self.packing.n)), self.packing.r * (SOLID_SIZE if self.solid else 1)
        k, step = self.seen(self.places - r[:, None], self.places + r[:, None], far)
        colours, rims = _pale(np.asarray(fill)[k], far[k]), _pale(np.array([to_rgb(RIM)]), far[k])
        return self._add(EllipseCollection(2 * r[k], 2 * r[k], np.zeros(len(k)), units="xy", offsets=self.places[k] + step,
                                           offset_transform=self.ax.transData, facecolors=colours, edgecolors=rims,
                                           linewidths=min(0.4, 0.05 * self.points), zorder=1))

    def links(self, contacts: npt.NDArray[Any], widths: Floats, colours: npt.ArrayLike) -> LineCollection:
        """Lines from centre to centre, or to the wall, along the normals of contacts. widths [contacts] of the lines
        [pt]; colours [contacts][3]. Later ones lie on top, in three dimensions nearer ones."""
        r, i, j = self.packing.r, contacts["i"], contacts["j"]
        reach = contacts["n"] * (r[i] + np.where(j < 0, 0, r[np.maximum(j, 0)]) - contacts["overlap"])[:, None]
        if self.packing.dim == 1:
            reach = np.stack([reach[:, 0]] * 3, axis=1)
        far = self.far(i, 0.5 * reach[:, 3 - self.across - self.rise] if self.solid else 0.0)
        start = self.places[i]
        end = start + self.project(reach)
        k, step = self.seen(np.minimum(start, end), np.maximum(start, end), far)
        return self._add(LineCollection(np.stack([start[k] + step, end[k] + step], axis=1), linewidths=widths[k],
                                        colors=_pale(np.asarray(colours)[k], far[k]), capstyle="round", zorder=2))

    def arrows(self, grains: Integers, vectors: Floats, colour: str, *, centred: bool = False,
               width: float = 0.8) -> Quiver:
        """Arrows [d] from grains, or centred on them. One that would cross a wall is moved along itself, and one that
        crosses a periodic edge comes in again. width: of a shaft [pt]."""
        far, delta = self.far(grains), self.project(vectors)
        start = self._inside(self.places[grains] - (0.5 * delta if centred else 0), delta)
        k, step = self.seen(np.minimum(start, start + delta), np.maximum(start, start + delta), far)
        start, delta = start[k] + step, delta[k]
        return self._add(self.ax.quiver(
            *start.T, *delta.T, angles="xy", scale_units="xy", scale=1, units="inches", width=width / 72, headwidth=3.6,
            headlength=4, headaxislength=3.6, minlength=0.1, minshaft=2, color=_pale(np.array([to_rgb(colour)]), far[k]),
            zorder=3))

    def _inside(self, start: Floats, delta: Floats) -> Floats:
        clear = 1 / self.points
        for axis, walls, end in ((1, not (self.tiled or self.ring), self.height), (0, self.boxed, self.left + self.span)):
            low, high = np.minimum(start, start + delta)[:, axis], np.maximum(start, start + delta)[:, axis]
            over = np.where(low < clear, clear - low, np.minimum(0, end - clear - high))
            with np.errstate(invalid="ignore", divide="ignore"):
                part = np.where(walls & (over != 0) & (delta[:, axis] != 0), over / delta[:, axis], 0)
            start = start + np.clip(part, -1, 1)[:, None] * delta
        return start

    def _add(self, things: Any) -> Any:
        things.set_in_layout(False)
        things.set_rasterized(len(things.get_offsets()) > MANY or len(things.get_paths()) > MANY)
        if things.axes is None:
            self.ax.add_collection(things, autolim=False)
        if self.slant:
            things.set_clip_path(self._outline(transform=self.ax.transData))
        return things


def _pale(colours: Floats, far: Floats) -> Floats:
    """Colours [n or 1][3], the far ones paler."""
    return colours + (PALE * far)[:, None] * (1 - colours)


# ---- figures --------------------------------------------------------------------------------------------------------

def views(packing: Packing, ax: Any = None, shift: Floats | None = None) -> list[View]:
    """One view, or in three dimensions three at one scale: along y, beside it along x, and below the first from above.
    On new Axes or on those given."""
    planes = [(0, 2), (1, 2), (0, 1)] if packing.dim == 3 else [(packing.dim - 2, packing.dim - 1)]
    given = None if ax is None else np.ravel(np.asarray(ax, object))
    found = [View(packing, *plane, shift) for plane in planes[:None if given is None else len(given)]]
    if given is None:
        _lay_out(found)
    for view, own in zip(found, [] if given is None else list(given)):
        view.ax, box = own, own.get_window_extent()
        view.points = min(box.width / view.span, box.height / view.height) * 72 / view.ax.figure.dpi
    return [view.open() for view in found]


def picture(height: float) -> Figure:
    """A figure as wide as a print column [in], which grows for what is added below."""
    fig = new_figure((WIDTH, height))
    fig.set_label("picture")
    return fig


def _lay_out(found: Sequence[View]) -> None:
    """A figure as wide as a print column, with the views at one scale."""
    one = found[0]
    spans, heights = [one.span], [one.height]
    if len(found) > 1:
        spans, heights = [max(one.span, found[2].span), found[1].span], [one.height, found[2].height]
    names = 14.0 * (len(found) > 1)  # the names of the axes [pt]
    across = 2 * MARGIN * len(spans) + 2 * THICK * one.boxed * len(spans) + names * len(spans)
    upwards = 2 * MARGIN * len(heights) + 2 * THICK * len(heights) + names * len(heights)
    points = min((WIDTH * 72 - across) / sum(spans), (TALLEST - upwards) / sum(heights))
    fig = picture((points * sum(heights) + upwards) / 72)
    grid = fig.add_gridspec(len(heights), len(spans), width_ratios=spans, height_ratios=heights)
    for view, place in zip(found, ((0, 0), (0, 1), (1, 0))):
        view.points = points
        view.ax = fig.add_subplot(grid[place], label="panel", anchor="C" if len(found) == 1 else "SW")


def _true_arrow(*, orig_handle: FancyArrow, height: float, **_: Any) -> FancyArrow:
    """The arrow of an entry at its true length."""
    width = orig_handle._width
    return FancyArrow(0, 0.5 * height, orig_handle._dx, 0, width=width, length_includes_head=True,
                      head_width=3.6 * width, head_length=4 * width)


def arrow_key(points: float, width: float, colour: str, text: str) -> FancyArrow:
    """An entry of a legend: an arrow of this length and width [pt]."""
    return FancyArrow(0, 0, points, 0, width=width, fc=colour, lw=0, label=text)


def finish(found: Sequence[View], entries: Sequence[Any], title: str = "") -> Any:
    """Adds the key of a picture, and returns its Axes, or the array of those of three views."""
    if found[0].solid:
        title = "\n".join(filter(None, (title, "grains at half their size, far ones pale")))
    key_below(found[0].ax, entries, title)
    return found[0].ax if len(found) == 1 else np.array([view.ax for view in found], object)


def key_below(ax: Axes, entries: Sequence[Any], title: str = "") -> None:
    """A key below a picture, for which its figure grows; on Axes that were given below these. In two columns if they
    fit."""
    fig = ax.figure
    own = fig.get_label() == "picture"
    longest = max((one._dx for one in entries if isinstance(one, FancyArrow)), default=0)
    words: dict[str, Any] = {
        "handles": entries, "title": title or None, "title_fontsize": 7, "alignment": "left", "fontsize": 7,
        "borderaxespad": 0.2, "handlelength": max(2.2, longest / 7),
        "handler_map": {FancyArrow: HandlerPatch(_true_arrow)}, "bbox_to_anchor": (0, 0),
        "loc": "lower left" if own else "upper left"}
    for columns in (2, 1):
        box = (fig if own else ax).legend(**words, ncol=columns)
        extent = box.get_window_extent()
        if columns == 1 or extent.width <= fig.bbox.width:
            break
        box.remove()
    if own:
        grow(fig, extent.height / fig.dpi)


def add_bar(found: Sequence[View], scale: ScalarMappable, text: str) -> Colorbar:
    """A colour bar below a picture, for which its figure grows."""
    fig = found[0].ax.figure
    if fig.get_label() == "picture":
        width, tall = fig.get_size_inches()
        fig.set_size_inches(width, tall + 0.5)
    made: Colorbar = fig.colorbar(scale, ax=[view.ax for view in found], location="bottom", aspect=30, shrink=0.8,
                                  pad=0.02)
    made.set_label(text)
    return made


def grow(fig: Figure, below: float, above: float = 0.0) -> None:
    """Makes room around a picture [in]."""
    width, tall = fig.get_size_inches()
    taken, height = fig.get_layout_engine().get()["rect"][1] * tall + below, tall + below + above
    fig.set_size_inches(width, height)
    fig.set_layout_engine("constrained", rect=(0, taken / height, 1, 1 - taken / height))
