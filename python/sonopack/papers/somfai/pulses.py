"""Figs. 4 and 5: signals, and their coherent parts in boxes of several heights."""
from __future__ import annotations

import math

import numpy as np

from ..sheet import Curve, Panel, Sheet
from .fronts import TIME_AXIS, Signals, boxes, front_of, signals
from .samples import SomfaiWork


def make(work: SomfaiWork, item: str) -> None:
    (_four if item == "fig4" else _five)(work, item)


# ---- Fig. 4 ---------------------------------------------------------------------------------------------------------

_PANELS = (("square", "(a) 2D, |μ| = 0.5", ""), ("square", "(b) 2D, |μ| = 0.5", "2D with friction"),
           ("smooth", "(c) 2D, |μ| = 0", "2D without friction"), ("spheres", "(d) 3D, |μ| = 0", "3D without friction"))


def _four(work: SomfaiWork, item: str) -> None:
    made: dict[str, Signals] = {}
    panels = []
    for ensemble, tag, name in _PANELS:
        if ensemble not in made:
            s = signals(work, ensemble, 400.0, 1601)
            made[ensemble] = s.over(s.peak())
        panels.append(Panel(_curves(tag[1], made[ensemble]), TIME_AXIS, "|F|_{sig} / first peak of the mean", tag=tag,
                            x=(0, 400), zero=True))
        if name:
            _say_scatter(work, item, name, made[ensemble])
    work.draw_sheet(item, "fig4",
                    "Force on the top wall at p = 1e-4 over the first peak of the ensemble's mean: (a) single packings with "
                    "friction, (b) their ensemble, (c) 2D and (d) 3D without friction.", Sheet(panels, columns=2))


def _curves(letter: str, s: Signals) -> list[Curve]:
    """Single packings in (a), mean and scatter beside one of them otherwise."""
    if letter == "a":
        names = ("packing 1 (Fig. 1)", "packing 2", "packing 3", "packing 4")
        return [Curve(s.t, f, name, ink=ink, width=0.8) for f, name, ink in zip(s.single, names, (2, 1, 3, 0))]
    curves = [Curve(s.t, s.single[0], "one packing", ink=-1, width=0.8)] if letter != "b" else []
    curves.append(Curve(s.t, s.mean, "mean", width=0.8))
    return curves + ([Curve(s.t, s.rms, "rms deviation", ink=2, dash=1, width=0.8)] if s.n > 1 else [])


def _say_scatter(work: SomfaiWork, item: str, what: str, s: Signals) -> None:
    """The scatter relative to the peak of the mean: at the peak, and the largest after the first zero crossing."""
    found = front_of(s.t, s.mean)
    if s.n < 2 or found is None:
        return
    before = s.rms[s.t <= found.t_peak]
    at_peak, later = before[-1] if len(before) else math.nan, max(s.rms[s.t > found.t_zero], default=0.0)
    work.say(item, f"{what}, {s.n} packings: the rms deviation between packings is {100 * at_peak / found.amplitude:.0f}% of "
                   f"the mean's first peak at that peak, and reaches {100 * later / found.amplitude:.0f}% after the first zero "
                   "crossing.")


# ---- Fig. 5 ---------------------------------------------------------------------------------------------------------

def _five(work: SomfaiWork, item: str) -> None:
    found = boxes(work)
    if len(found) > 1 and found[0].grains == 100:
        found = found[1:]  # its amplitude would dwarf the others
    made = [signals(work, d.ensemble, 1.15 * d.t_zero.mean, 400, d.grains) for d in found]
    peak = made[0].peak() if made else 1.0
    curves = []
    for k, (d, s) in enumerate(zip(found, made)):
        later = np.flatnonzero(s.t >= 0.75 * d.t10.mean)[:1]  # nothing happens before the front arrives
        first = int(later[0]) if len(later) else len(s.t)
        curves.append(Curve(s.t[first:], s.mean[first:] / peak, f"|L| = {d.distance:.1f} |d|", ink=k % 4,
                            dash=(0, 1, 3)[k % 3]))
    if curves:
        panel = Panel(curves, TIME_AXIS, "mean |F|_{sig} / peak of the lowest box", x=(0, None), zero=True)
        work.draw_sheet(item, "fig5", "Mean signals of boxes 24 wide and L high at p = 1e-4, until shortly after their zero "
                                      "crossings, over the first peak of the lowest box.", Sheet([panel]))
    if len(found) > 1:
        low, high = found[0], found[-1]
        work.say(item, f"From L = {low.distance:.3g} to {high.distance:.3g} the first peak falls by a factor "
                       f"{low.amplitude.mean / high.amplitude.mean:.3g} and its width (t_zero - t10) grows by "
                       f"{high.width.mean / low.width.mean:.3g}.")
