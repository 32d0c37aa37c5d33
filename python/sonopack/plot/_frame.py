"""The frame of every figure: its size and style, legends, the look that a reader asks for, and files that are the same on
every run."""
from __future__ import annotations

import contextlib
import functools
import inspect
import io
import os
import pathlib
import sys
import textwrap
from collections.abc import Callable, Iterable, Iterator, Sequence
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
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator
from matplotlib.transforms import Bbox

from .._command import usage, whole_file
from .._core import Floats, invalid
from .._records import Material
from ._inputs import inputs
from ._units import number, plain
from .kinds import KINDS

#: the style of all figures: matplotlib.style.use(sonopack.plot.STYLE)
STYLE = str(pathlib.Path(__file__).with_name("sonopack.mplstyle"))
WIDTH = 86 / 25.4  # of a print column [in]
INKS = ("#000000", "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
DASHES: tuple[Any, ...] = ("-", (0, (5, 2)), (0, (1, 1.4)), (0, (5, 1.6, 1, 1.6)))
MARKS = "os^DvP"
MARKS_OF_FRONT = {"t10": "^", "t_peak": "o", "t_zero": "s"}  # as in Fig. 6 of Somfai et al. 2005
GREY = "#8c8c8c"

_F = TypeVar("_F", bound=Callable[..., Any])


def styled(draw: _F) -> _F:
    """Draws with the style, whatever matplotlib's is."""
    @functools.wraps(draw)
    def with_style(*given: Any, **words: Any) -> Any:
        with matplotlib.style.context(STYLE):
            drawn = draw(*given, **words)
            for ax in [] if isinstance(drawn, Iterator) else list(np.ravel(np.asarray(drawn, object))):
                label_decades(ax)
            return drawn
    return with_style  # type: ignore[return-value]


def figure(draw: Callable[..., Any]) -> Callable[..., Any]:
    """A kind of figure: the function gets the Inputs of its data in place of these, and is drawn with the style."""
    own, named = inspect.signature(draw), KINDS[draw.__name__].labels

    @functools.wraps(draw)
    def with_inputs(*data: Any, labels: Sequence[str] | None = None, material: Material | None = None, **words: Any) -> Any:
        if labels is not None and not named:
            raise invalid("labels", f"a figure of {draw.__name__} has no legend of data")
        return styled(draw)(inputs(data, labels, material), **words)
    some = inspect.signature(with_inputs, follow_wrapped=False).parameters
    words = [some[name] for name in ("data", "labels", "material") if named or name != "labels"]
    with_inputs.__signature__ = own.replace(  # type: ignore[attr-defined]
        parameters=[*words, *list(own.parameters.values())[1:]])
    return with_inputs


def label_decades(ax: Axes) -> None:
    """A logarithmic axis of few decades has numbers at 1, 2 and 5, too."""
    for axis in (axis for one in (ax, *ax.child_axes) for axis in (one.xaxis, one.yaxis) if axis.get_scale() == "log"):
        low, high = sorted(axis.get_view_interval())
        if low > 0 and high / low < (60 if axis.axes is ax else 25):
            narrow = axis.axes is not ax and high / low < 3  # an inset, where a LogLocator would crowd numbers
            axis.set_major_locator(MaxNLocator(3) if narrow else LogLocator(subs=(1, 2, 5)))
            axis.set_major_formatter(FuncFormatter(lambda value, _: number(value)))
            axis.set_minor_formatter(FuncFormatter(lambda value, _: ""))


def new_figure(size: tuple[float, float]) -> Figure:
    """A figure of this size [in]."""
    if "matplotlib.pyplot" in sys.modules:
        made: Figure = sys.modules["matplotlib.pyplot"].figure(figsize=size)
        return made
    made = Figure(figsize=size)
    FigureCanvasAgg(made)
    return made


def panels(rows: int = 1, columns: int = 1, *, ax: Any = None, aspect: float = 0.75, width: float | None = None,
           **words: Any) -> npt.NDArray[Any]:
    """Axes [rows, columns] of a new figure, or those given as `ax`. aspect: height of a panel over its width. width: of
    the figure [in]; a print column for each column of panels. words: of Figure.subplots, such as sharex."""
    if ax is not None:
        given = np.atleast_1d(np.asarray(ax, object))
        if given.size != rows * columns:
            raise invalid("ax", f"{given.size} Axes: this figure has {rows * columns} panels")
        shaped: npt.NDArray[Any] = given.reshape(rows, columns)
        return shaped
    width = width or WIDTH * columns
    fig = new_figure((width, width / columns * aspect * rows))
    axes: npt.NDArray[Any] = fig.subplots(rows, columns, squeeze=False, **words)
    for one in axes.flat:
        one.set_label("panel")
    return axes


def column_of_panels(rows: int, ax: Any, aspect: float) -> Any:
    """Axes [rows] one above the other, with their letters above the frames, where they hide no data."""
    axes = panels(rows, 1, ax=ax, aspect=aspect)[:, 0]
    for one, name in zip(axes, "abcd" if rows > 1 else ""):
        letter(one, f"({name})")
    return axes


def letter(ax: Axes, text: str) -> None:
    """The letter of a panel, or more, above its frame, where it hides no data."""
    ax.annotate(text, (0, 1), (0, 3), "axes fraction", "offset points", fontsize=7, gid="letter")


def ink(k: int) -> str:
    """Colour k of those that differ, black first."""
    return INKS[k % len(INKS)]


def dash(k: int) -> Any:
    return DASHES[k % len(DASHES)]


def mark(k: int) -> str:
    return MARKS[k % len(MARKS)]


def points(ax: Axes, x: Floats, y: Floats, error: Floats | None = None, *, hollow: bool = False, **words: Any) -> Any:
    """Markers, with bars where errors are known, and the handle of a legend. Bars that would end at or below 0 on a
    logarithmic axis reach its edge."""
    words = {"ls": "none", "marker": "o", **({"mfc": "white"} if hollow else {}), **words}
    if error is None or not np.any(np.isfinite(error)):
        return ax.plot(x, y, **words)[0]
    return ax.errorbar(x, y, yerr=np.where(np.isfinite(error), error, 0), elinewidth=0.7, **words)


def sets(k: int) -> dict[str, Any]:
    """Mark and colour of the points of table k: with five tables the marks come again, hollow."""
    return {"marker": mark(k % 4), "color": ink(k + 1), "hollow": k >= 4}


# ---- legends --------------------------------------------------------------------------------------------------------

def key(**words: Any) -> Line2D:
    """An entry of a legend that stands for several curves."""
    return Line2D([], [], **words)


def legend(ax: Axes, handles: Iterable[Any] | None = None, *, fixed: bool = False, **words: Any) -> Legend | None:
    """The legend, where it hides no data: inside, with the y axis extended upwards for it (fixed: not so), else above the
    frame, with long labels on several lines. None without entries."""
    entries = list(handles) if handles is not None else ax.get_legend_handles_labels()[0]
    if not entries:
        return None
    ax._sonopack_legend = (entries, words)
    return _place_legend(ax, fixed)


def _place_legend(ax: Axes, fixed: bool) -> Legend:
    entries, words = ax._sonopack_legend
    with matplotlib.style.context(STYLE):
        ax.figure.draw_without_rendering()
        return _inside(ax, entries, words, fixed) or _above(ax, entries, words)


_PLACES = {(1, 1): "upper right", (0, 1): "upper left", (1, 0): "lower right", (0, 0): "lower left",
           (1, 0.5): "center right", (0, 0.5): "center left", (0.5, 1): "upper center", (0.5, 0): "lower center"}


def _inside(ax: Axes, entries: list[Any], words: dict[str, Any], fixed: bool) -> Legend | None:
    """The legend where it hides no data, with the y axis grown by up to half; None if there is no such place."""
    sizes, frame = {}, ax.get_window_extent()
    for columns in (1, 2) if len(entries) > 3 else (1,):
        size = _size(ax.legend(handles=entries, loc="upper right", **{"ncol": columns, **words}))
        if size[0] <= 0.97 * frame.width and size[1] <= 0.6 * frame.height:
            sizes[columns] = size
    ax.get_legend().remove()
    found = _free(ax, sizes, list(_PLACES), (0.0,) if fixed else (0.0, 0.1, 0.2, 0.3, 0.4))
    if found is None:
        return None
    box = ax.legend(handles=entries, loc=_PLACES[found[1]], borderaxespad=0.1, **{"ncol": found[0], **words})
    box.set_in_layout(False)
    return box


def _size(box: Legend) -> tuple[float, float]:
    extent = box.get_window_extent(box.figure.canvas.get_renderer())
    return extent.width, extent.height


def _free(ax: Axes, sizes: dict[int, tuple[float, float]], places: Sequence[tuple[float, float]],
          grows: Sequence[float]) -> tuple[int, tuple[float, float]] | None:
    """The first of some sizes [pixels] and of some places (0 .. 1 of the room that is left) where a box hides no data,
    with the y axis grown upwards by the least of some shares; None, and the old axis, if there is none."""
    frame, (low, high) = ax.get_window_extent(), ax.get_ylim()
    turn = ax.yaxis.get_transform()
    a, b = turn.transform(np.array([low, high]))
    for grow in grows:
        ax.set_ylim(low, float(turn.inverted().transform(b + grow * (b - a))) if grow else high)
        there = Obstacles(ax)
        for name, (width, height) in sizes.items():
            for x, y in places:
                if there.leave(Bbox.from_bounds(frame.x0 + x * (frame.width - width),
                                                frame.y0 + y * (frame.height - height), width, height)):
                    return name, (x, y)
    ax.set_ylim(low, high)
    return None


class Obstacles:
    """What a legend or an inset must not cover: lines, marks, bands, texts and insets of Axes, in pixels."""

    def __init__(self, ax: Axes) -> None:
        renderer = ax.figure.canvas.get_renderer()
        self.boxes = [text.get_window_extent(renderer) for text in ax.texts if text.get_text()]
        self.boxes += [one.get_tightbbox(renderer) for one in ax.child_axes]
        self.paths = [one.get_transform().transform_path(one.get_path()) for one in (*ax.lines, *ax.patches)]
        points = [np.zeros((0, 2))]
        for many in ax.collections:
            points.append(np.atleast_2d(many.get_offset_transform().transform(many.get_offsets())))
            if len(many.get_paths()) < 5000:
                self.paths += [many.get_transform().transform_path(path) for path in many.get_paths()]
        self.points = np.concatenate(points)

    def leave(self, lies: Bbox) -> bool:
        """Whether a box is free."""
        if any(lies.overlaps(box) for box in self.boxes) or lies.count_contains(self.points):
            return False
        return not any(len(path.vertices) and (lies.count_contains(path.vertices) or path.intersects_bbox(lies, filled=False))
                       for path in self.paths)


def inset(ax: Axes, width: float = 0.46, height: float = 0.46) -> Axes:
    """Axes within others, of this share of them with its labels, where they hide no data; the y axis grows for them."""
    ax.figure.draw_without_rendering()
    frame, steps = ax.get_window_extent(), np.linspace(0, 1, 6)
    places = [((0.02 + (0.96 - width) * x) / (1 - width), (0.02 + (0.96 - height) * y) / (1 - height))
              for y in steps for x in steps]
    found = _free(ax, {0: (width * frame.width, height * frame.height)}, places, (0.0, 0.15, 0.3, 0.45, 0.6))
    x, y = found[1] if found else places[-1]
    inner: Axes = ax.inset_axes([x * (1 - width) + 0.14, y * (1 - height) + 0.13, width - 0.16, height - 0.15])
    inner.tick_params(labelsize=5.5, which="both", length=2)
    inner.ticklabel_format(scilimits=(-1, 3))
    for axis in (inner.xaxis, inner.yaxis):
        axis.label.set_fontsize(6)
        axis.labelpad = 0.5
    return inner


def _above(ax: Axes, entries: list[Any], words: dict[str, Any]) -> Legend:
    """Above the frame, in as many columns as fit, and the figure grows by it."""
    words = {name: value for name, value in words.items() if name not in ("loc", "ncol", "bbox_to_anchor")}
    fig, frame = ax.figure, ax.get_window_extent()
    page, room = fig.bbox.width, frame.width
    top = 1 + (13 * fig.dpi / 72 / frame.height if any(text.get_gid() == "letter" for text in ax.texts) else 0)
    for columns, width in ((4, 0), (3, 0), (2, 0), (1, 0), (1, 60), (1, 44), (1, 32), (1, 24)):
        if columns > len(entries):
            continue
        texts = ["\n".join(textwrap.wrap(one.get_label(), width)) if width else one.get_label() for one in entries]
        box = ax.legend(handles=entries, labels=texts, loc="lower left", bbox_to_anchor=(0.0, top), ncol=columns,
                        **words)
        wide, tall = _size(box)
        if 1.02 * room < wide < 0.98 * page:  # it may begin left of the frame
            box.set_bbox_to_anchor(((room - wide + 0.01 * page) / room, top), transform=ax.transAxes)
        if wide < 0.98 * page and wide - room < frame.x0:
            break
    if not getattr(ax, "_sonopack_grown", False):
        ax._sonopack_grown = True
        fig.set_size_inches(fig.get_figwidth(), fig.get_figheight() + tall / fig.dpi)
    return box


# ---- the look that a reader asks for --------------------------------------------------------------------------------

Limits = tuple[float | None, float | None]


def apply_look(fig: Figure, title: str = "", x: Limits | None = None, y: Limits | None = None, log: str = "",
               linear: bool = False) -> None:
    """Title, limits and scales of the axes: x of all panels, y of the first. log: "x", "y" or "xy". linear: the others."""
    if title:
        text = fig.suptitle("\n".join(textwrap.wrap(plain(title), int(13 * fig.get_figwidth()))), fontsize=9)
        if fig.get_label() == "picture":  # whose views have a scale
            from ._view import grow
            grow(fig, 0.0, text.get_window_extent().height / fig.dpi + 0.06)
    for k, ax in enumerate(one for one in fig.axes if one.get_label() == "panel"):
        for which, limits in (("x", x), ("y", y))[:2 if k == 0 else 1]:
            _look_of_axis(ax, which, limits, "log" if which in log else "linear" if linear else None)
        label_decades(ax)
        if hasattr(ax, "_sonopack_legend"):
            _place_legend(ax, fixed=k == 0 and y is not None)


def _look_of_axis(ax: Axes, which: str, limits: Limits | None, scale: str | None) -> None:
    set_limits, get_limits = getattr(ax, f"set_{which}lim"), getattr(ax, f"get_{which}lim")
    if scale == "log":
        _check_positive(ax, which)
    if scale and scale != getattr(ax, f"get_{which}scale")():
        getattr(ax, f"set_{which}scale")(scale, **({"nonpositive": "clip"} if scale == "log" else {}))
        set_limits(auto=True)
        ax.autoscale(axis=which)
    if limits:
        least = min(one for one in limits if one is not None)
        if getattr(ax, f"get_{which}scale")() == "log" and least <= 0:
            raise usage(f"--{which} {least:g}: must be above 0 on a logarithmic axis")
        set_limits(*(old if new is None else new for new, old in zip(limits, get_limits())))


def _check_positive(ax: Axes, which: str) -> None:
    """A negative number has no logarithm; zeros lie below the frame."""
    for line in (line for line in ax.lines if line.get_transform() == ax.transData):
        values = np.asarray(getattr(line, f"get_{which}data")(), float)
        if np.any(values < 0):
            k = int(np.argmax(values < 0))
            raise usage(f"--log {which}: point {k + 1}: {which} = {values[k]:g} is below 0")


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
    with whole_file(path) as draft:
        _write(fig, draft, ending)


def _write(fig: Figure, to: Any, ending: str, dpi: int = 300) -> None:
    with matplotlib.style.context(STYLE), _powers_in_labels(fig):
        fig.savefig(to, format=ending[1:], dpi=dpi, metadata=_METADATA[ending])


def picture(axes: Any) -> bytes:
    """The PNG of Axes that nobody else has, for notebooks."""
    fig, out = figure_of(axes), io.BytesIO()
    _write(fig, out, ".png", 150)
    forget(fig)
    return out.getvalue()


def figure_of(axes: Any) -> Figure:
    """The figure of Axes, or of an array of them."""
    fig: Figure = np.ravel(np.asarray(axes, object))[0].figure
    return fig


def forget(fig: Figure) -> None:
    """pyplot, where it is imported, would keep and show the figure."""
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close(fig)


@contextlib.contextmanager
def _powers_in_labels(fig: Figure) -> Iterator[None]:
    """Powers of ten that the numbers of an axis lack stand with its unit while the figure is written: beside the axis they
    would cover tags and insets."""
    fig.draw_without_rendering()
    moved = []
    for axis in (axis for ax in [*fig.axes, *(inner for ax in fig.axes for inner in ax.child_axes)]
                 for axis in (ax.xaxis, ax.yaxis)):
        order, text = getattr(axis.get_major_formatter(), "orderOfMagnitude", 0), axis.get_label_text()
        if order and text and not axis.get_major_formatter().offset:
            moved.append((axis, text))
            power = f"$10^{{{order}}}$"
            axis.set_label_text(text.replace("  [", f"  [{power} ") if "  [" in text else f"{text}  [{power}]")
            axis.offsetText.set_visible(False)
    try:
        yield
    finally:
        for axis, text in moved:
            axis.set_label_text(text)
            axis.offsetText.set_visible(True)
