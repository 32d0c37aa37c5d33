"""Fig. 11: damped signals."""
from __future__ import annotations

import math

import numpy as np

from ..._network import Network
from ..._signal import Signal, front
from ..sheet import Curve, Panel, Sheet
from .fronts import TIME_AXIS, front_of, rms_after
from .samples import SomfaiWork

LEVELS = (0.0, 0.02, 0.1, 0.5)
UNTIL, POINTS = 300.0, 601


def damped(network: Network, zeta: float) -> Signal:
    """The signal with contacts damped by a fraction of critical."""
    return network.signal(until=UNTIL, points=POINTS, damping=zeta, tolerance=1e-6)


def make(work: SomfaiWork, item: str) -> None:
    _, _, network = next(work.walk("square", 1e-4, most=1))
    linear, full = [], []
    for zeta in LEVELS:
        linear.append(damped(network, zeta))
        full.append(network.signal(until=UNTIL, points=POINTS, damping=zeta, method="dynamics", tolerance=1e-2,
                                   amplitude=1e-4))
        work.tell("fig11", 0.95)
    first = front(linear[0].t, linear[0].F)
    scaled = [(own.F / first.amplitude, other.F / first.amplitude) for own, other in zip(linear, full)]
    t = linear[0].t
    panels = [Panel([Curve(t, own, f"linear, |ζ| = {zeta:g}", width=0.9),
                     Curve(full[k].t, other, "nonlinear", ink=1, dash=1, width=0.9)],
                    TIME_AXIS, "|F|_{sig} / first peak", tag=f"({'abcd'[k]})", x=(0, UNTIL), zero=True)
              for k, (zeta, (own, other)) in enumerate(zip(LEVELS, scaled))]
    work.draw_sheet(item, "fig11",
                    "Signal of the packing of Fig. 1 with contacts damped by a fraction zeta of critical, over the first peak "
                    "without damping: the linear network, and the packing's own nonlinear motion after a pulse of 1e-4 of the "
                    "mean overlap.", Sheet(panels, aspect=0.42))
    peaks = [found.amplitude if (found := front_of(t, own)) else math.nan for own, _ in scaled]
    rests = [rms_after(t, own, first.t_zero) for own, _ in scaled]
    for k in range(1, len(LEVELS)):
        apart = float(np.max(np.abs(scaled[k][0] - scaled[k][1])))
        work.say(item, f"zeta = {LEVELS[k]:g}: the first peak keeps {100 * peaks[k] / peaks[0]:.0f}% of its height, what "
                       f"follows {100 * rests[k] / rests[0]:.0f}% of its root mean square; linear and nonlinear motion differ "
                       f"by {100 * apart:.1f}% of the first peak without damping at the most.")
