"""Fig. 6: arrival times against distance."""
from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..sheet import Curve, Panel, Sheet
from ..work import hypot
from .fronts import MARKS, TIME_AXIS, Distance, Line, boxes, fitted, front_of, line, signals
from .samples import SomfaiWork

SHAPES = ("^", "o", "s")
LABELS = ("arrival (10% of the peak)", "peak", "zero crossing")
#: lines through boxes up to L = 60, and through all
FITS = (("50", 60.0), ("100", math.inf))


def make(work: SomfaiWork, item: str) -> None:
    found = boxes(work)
    lines = [_line(fitted(found, most)) for _, most in FITS]
    for (name, _), own in zip(FITS, lines):
        work.state(f"slope-{name}", 1 / own.slope, own.err / (own.slope * own.slope))
    for low, high in zip(found, found[1:]):
        rise, time = high.distance - low.distance, high.t10.mean - low.t10.mean
        work.say(item, f"Between L = {low.distance:.3g} and {high.distance:.3g} the arrival moves with {rise / time:.3f} +- "
                       f"{rise / (time * time) * hypot(low.t10.err, high.t10.err):.3f}.")
    work.say(item, "The paper does not say how tall its tallest boxes were; the speed falls with the distance, so that the slope "
                   "depends on that.")
    if work.folder:
        _draw(work, item, found, lines)


def _line(some: Sequence[Distance]) -> Line:
    return line([d.distance for d in some], [d.t10.mean for d in some], [d.t10.err for d in some])


def _draw(work: SomfaiWork, item: str, found: Sequence[Distance], lines: Sequence[Line]) -> None:
    distance = np.array([d.distance for d in found])
    curves = []
    for k, name in enumerate(MARKS):
        means = [getattr(d, name) for d in found]
        curves.append(Curve(distance, np.array([m.mean for m in means]), LABELS[k], error=np.array([m.err for m in means]),
                            ink=k + 1, dash=None, mark=SHAPES[k], open=True))
    for (name, most), own, dash in zip(FITS, lines, (0, 1)):
        some = fitted(found, most)
        if math.isfinite(own.slope):
            x = np.array([0, 1.05 * some[-1].distance])
            curves.append(Curve(x, own.intercept + own.slope * x, f"slope 1/{1 / own.slope:.3f}, |L| to {name}", dash=dash,
                                width=0.7))
    panel = Panel(curves, "distance |L| [|d|]", TIME_AXIS, x=(0, None), inset=_inset(work))
    work.draw_sheet(item, "fig6",
                    "Times of arrival, peak and zero crossing against the distance, means of boxes 24 wide at p = 1e-4; inset: "
                    "the three marks on the signal of the packing of Fig. 1.", Sheet([panel], aspect=0.9))


def _inset(work: SomfaiWork) -> Panel | None:
    """The signal of the packing of Fig. 1 and its three marks."""
    s = signals(work, "square", 180.0, 721)
    own = front_of(s.t, s.single[0])
    if own is None:
        return None
    curves = [Curve(s.t, s.single[0] / own.amplitude, width=0.7)]
    curves += [Curve(np.array([getattr(own, name)]), np.array([height]), ink=k + 1, dash=None, mark=SHAPES[k], open=True)
               for k, (name, height) in enumerate(zip(MARKS, (0.1, 1.0, 0.0)))]
    return Panel(curves, "|t|  [|d| (|ρ|/|E|*)^{1/2}]", "|F|_{sig} / peak", x=(0, 180), zero=True)
