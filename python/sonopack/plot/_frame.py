"""The frame of every figure: its size and style, legends, the look that a reader asks for, and files that are the same on
every run."""
from __future__ import annotations

import dataclasses
import functools
import os
import pathlib
import sys
import textwrap
from collections.abc import Callable, Iterable
from typing import Any, TypeVar

import matplotlib
import matplotlib.style
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.lines import Line2D

from .._command import usage, whole_file
from .._core import Floats, invalid

#: the style of all figures: matplotlib.style.use(sonopack.plot.STYLE)
STYLE = str(pathlib.Path(__file__).with_name("sonopack.mplstyle"))
WIDTH = 86 / 25.4  # of a print column [in]
INKS = ("#000000", "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
DASHES: tuple[Any, ...] = ("-", (0, (5, 2)), (0, (1, 1.4)), (0, (5, 1.6, 1, 1.6)))
MARKS = "osD^vP"
MARKS_OF_FRONT = {"t10": "^", "t_peak": "o", "t_zero": "s"}  # as in Fig. 6 of Somfai et al. 2005
GREY = "#8c8c8c"

_F = TypeVar("_F", bound=Callable[..., Any])


def styled(draw: _F) -> _F:
    """Draws with the style, whatever matplotlib's is."""
    @functools.wraps(draw)
    def with_style(*given: Any, **words: Any) -> Any:
        with matplotlib.style.context(STYLE):
            return draw(*given, **words)
    return with_style  # type: ignore[return-value]


def panels(rows: int = 1, columns: int = 1, *, ax: Any = None, aspect: float = 0.75, width: float | None = None,
           **words: Any) -> npt.NDArray[Any]:
    """Axes [rows, columns] of a new figure, or those given as `ax`. aspect: height of a panel over its width. width: of
    the figure [in]; a print column for each column of panels. words: of Figure.subplots, such as sharex."""
    if ax is not None:
        given = np.atleast_1d(np.asarray(ax, object))
        if given.size != rows * columns:
            raise invalid("ax", f"{given.size} Axes: this figure has {rows * columns} panels")
        return given.reshape(rows, columns)
    width = width or WIDTH * columns
    size = (width, width / columns * aspect * rows)
    if "matplotlib.pyplot" in sys.modules:
        fig = sys.modules["matplotlib.pyplot"].figure(figsize=size)
    else:
        fig = Figure(figsize=size)
        FigureCanvasAgg(fig)
    axes: npt.NDArray[Any] = fig.subplots(rows, columns, squeeze=False, **words)
    for one in axes.flat:
        one.set_label("panel")
    return axes


def ink(k: int) -> str:
    """Colour k of those that differ, black first."""
    return INKS[k % len(INKS)]


def dash(k: int) -> Any:
    return DASHES[k % len(DASHES)]


def mark(k: int) -> str:
    return MARKS[k % len(MARKS)]


def points(ax: Axes, x: Floats, y: Floats, error: Floats | None = None, *, hollow: bool = False, **words: Any) -> None:
    """Markers, with bars where errors are known. Bars that would end at or below 0 on a logarithmic axis reach its edge."""
    words = {"ls": "none", "marker": "o", **words}
    if hollow:
        words["mfc"] = "white"
    if error is None or not np.any(np.isfinite(error)):
        ax.plot(x, y, **words)
        return
    ax.errorbar(x, y, yerr=np.where(np.isfinite(error), error, 0), elinewidth=0.7, **words)


def tag(ax: Axes, text: str) -> None:
    """The letter of a panel, in its upper left corner."""
    ax.text(0.02, 0.97, text, transform=ax.transAxes, va="top", ha="left", fontsize=8)


# ---- legends --------------------------------------------------------------------------------------------------------

def key(**words: Any) -> Line2D:
    """An entry of a legend that stands for several curves."""
    return Line2D([], [], **words)


def legend(ax: Axes, handles: Iterable[Any] | None = None, **words: Any) -> Legend | None:
    """The legend, where it hides no data: inside, with the y axis extended upwards for it, else above the frame, with
    long labels on several lines. None without entries."""
    entries = list(handles) if handles is not None else _entries(ax)
    if not entries:
        return None
    ax._sonopack_legend = (entries, words)
    return _place_legend(ax)


def _entries(ax: Axes) -> list[Any]:
    handles, texts = ax.get_legend_handles_labels()
    for handle, text in zip(handles, texts):
        handle.set_label(text)
    return handles


def _place_legend(ax: Axes) -> Legend:
    entries, words = ax._sonopack_legend
    with matplotlib.style.context(STYLE):
        ax.figure.draw_without_rendering()
        frame = ax.get_window_extent()
        box = ax.legend(handles=entries, loc="best", **words)
        box.set_in_layout(False)
        size = _size(box)
        if size[0] <= 0.95 * frame.width and size[1] <= 0.6 * frame.height and _fits(ax, box):
            return box
        return _above(ax, entries, words, frame.width)


def _size(box: Legend) -> tuple[float, float]:
    extent = box.get_window_extent(box.figure.canvas.get_renderer())
    return extent.width, extent.height


def _fits(ax: Axes, box: Legend) -> bool:
    """Whether the legend hides no data where it is, or after the y axis grew by up to half. Limits that were asked for
    stay as they are."""
    low, high = ax.get_ylim()
    turn = ax.yaxis.get_transform()
    a, b = turn.transform([low, high])
    asked = getattr(ax, "_sonopack_limits", (None, None))[1] is not None
    for grow in (0.0,) if asked else (0.0, 0.1, 0.2, 0.3, 0.4, 0.5):
        ax.set_ylim(low, float(turn.inverted().transform(b + grow * (b - a))))
        ax.figure.draw_without_rendering()
        if not _hides(ax, box):
            return True
    ax.set_ylim(low, high)
    return False


def _hides(ax: Axes, box: Legend) -> bool:
    lies = box.get_window_extent().padded(1.0)
    boxes, lines, offsets = (list(found) for found in box._auto_legend_data()[:3])
    boxes += [text.get_window_extent() for text in ax.texts if text.get_visible() and text.get_text()]
    return (any(path.intersects_bbox(lies, filled=False) or lies.count_contains(path.vertices) for path in lines)
            or any(lies.overlaps(one) for one in boxes)
            or lies.count_contains(np.asarray(offsets).reshape(-1, 2)) > 0)


def _above(ax: Axes, entries: list[Any], words: dict[str, Any], room: float) -> Legend:
    """Above the frame, in as many columns as fit, and the figure grows by it. room: the width of the frame [pixels]."""
    words = {name: value for name, value in words.items() if name not in ("loc", "ncol", "bbox_to_anchor")}
    for columns, width in ((4, 0), (3, 0), (2, 0), (1, 0), (1, 60), (1, 44), (1, 32), (1, 24)):
        if columns > len(entries):
            continue
        texts = ["\n".join(textwrap.wrap(one.get_label(), width)) if width else one.get_label() for one in entries]
        box = ax.legend(handles=entries, labels=texts, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncol=columns,
                        **words)
        if _size(box)[0] <= 1.02 * room:
            break
    if not getattr(ax, "_sonopack_grown", False):
        ax._sonopack_grown = True
        width, height = ax.figure.get_size_inches()
        ax.figure.set_size_inches(width, height + _size(box)[1] / ax.figure.dpi)
    return box


# ---- the look that a reader asks for --------------------------------------------------------------------------------

Limits = tuple[float | None, float | None]


@dataclasses.dataclass(frozen=True)
class Look:
    """Title, limits and scales of the axes. x holds for all panels, y for the first."""

    title: str = ""
    x: Limits | None = None
    y: Limits | None = None
    log: str = ""
    linear: bool = False

    def apply(self, fig: Figure) -> None:
        if self.title:
            from ._units import plain
            fig.suptitle(plain(self.title))
        for k, ax in enumerate(one for one in fig.axes if one.get_label() == "panel"):
            self._axis(ax, "x", self.x)
            if k == 0:
                self._axis(ax, "y", self.y)
            if hasattr(ax, "_sonopack_legend"):
                ax._sonopack_limits = (self.x, self.y if k == 0 else None)
                _place_legend(ax)

    def _axis(self, ax: Axes, which: str, limits: Limits | None) -> None:
        scale = "log" if which in self.log else "linear" if self.linear else None
        set_limits, get_limits = getattr(ax, f"set_{which}lim"), getattr(ax, f"get_{which}lim")
        if scale and scale != getattr(ax, f"get_{which}scale")():
            getattr(ax, f"set_{which}scale")(scale, **({"nonpositive": "clip"} if scale == "log" else {}))
            set_limits(auto=True)
            ax.autoscale(axis=which)
        if limits:
            if getattr(ax, f"get_{which}scale")() == "log" and min(one for one in limits if one is not None) <= 0:
                low = next(one for one in limits if one is not None and one <= 0)
                raise usage(f"--{which} {low:g}: must be above 0 on a logarithmic axis")
            low, high = get_limits()
            set_limits(limits[0] if limits[0] is not None else low, limits[1] if limits[1] is not None else high)


# ---- files ----------------------------------------------------------------------------------------------------------

_METADATA: dict[str, dict[str, Any]] = {
    ".svg": {"Date": None, "Creator": None, "Format": None, "Type": None},
    ".pdf": {"CreationDate": None, "Producer": None, "Creator": None}, ".png": {"Software": None}}


def save(fig: Figure, path: str | os.PathLike[str]) -> None:
    """Writes a figure: SVG, PDF or PNG (300 dpi) as the ending says, the same bytes on every run. A reader sees the old
    file or the new one, never a part."""
    ending = os.path.splitext(os.fspath(path))[1].lower()
    if ending not in _METADATA:
        raise usage(f"-o {os.fspath(path)}: the ending of a figure must be .svg, .png or .pdf")
    with matplotlib.style.context(STYLE), whole_file(path) as draft:
        fig.savefig(draft, format=ending[1:], dpi=300, metadata=_METADATA[ending])
