"""Table III and Fig. 7: exponents of amplitude and width, for boxes and chains."""
from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from ..._chain import chain_front
from ..._core import Floats
from ..sheet import Curve, Panel, Sheet
from ..work import hypot
from .fronts import Distance, boxes, chains, fitted, power
from .samples import SomfaiWork

SPREADS = ("0.1", "0.2", "0.4")
EXACT = 24  # number of lengths of chains of equal balls


def make(work: SomfaiWork, item: str) -> None:
    (_table if item == "table3" else _figure)(work, item)


# ---- Table III ------------------------------------------------------------------------------------------------------

def _table(work: SomfaiWork, item: str) -> None:
    heights = boxes(work)
    for source, name in (("velocity", "equal-A"), ("displacement", "equal-B")):
        half, whole = (chain_front(n, source) for n in (500000, 1000000))
        work.state(f"gamma-{name}", math.log(half.amplitude / whole.amplitude) / math.log(2.0), 0.0)
        work.state(f"alpha-{name}", math.log(whole.width / half.width) / math.log(2.0), 0.0)
    for spread in SPREADS:
        _fits(work, f"chain-{spread}", chains(work, spread))
    _fits(work, "boxes-50", fitted(heights, 60))
    _fits(work, "boxes-100", fitted(heights, math.inf))
    work.say(item, "Equal chains: slopes between half a million and a million balls. Unequal chains and packings: straight "
                   "lines, log against log, through all lengths of chains and through the boxes of the range, with the "
                   "standard errors of the means.")
    for low, high in zip(heights, heights[1:]):
        gamma, alpha = power([low, high], "amplitude"), power([low, high], "width")
        work.say(item, f"Between L = {low.distance:.3g} and {high.distance:.3g}: gamma = {-gamma.slope:.2f} +- {gamma.err:.2f}, "
                       f"alpha = {alpha.slope:.2f} +- {alpha.err:.2f}.")


def _fits(work: SomfaiWork, name: str, distances: Sequence[Distance]) -> None:
    """Exponents of fits through the fronts at several distances."""
    gamma, alpha = power(distances, "amplitude"), power(distances, "width")
    work.state(f"gamma-{name}", -gamma.slope, gamma.err)
    work.state(f"alpha-{name}", alpha.slope, alpha.err)


# ---- Fig. 7 ---------------------------------------------------------------------------------------------------------

@dataclasses.dataclass(frozen=True)
class Scaling:
    """Values against distance, and local exponents between neighbouring distances."""

    distance: Floats
    value: Floats
    err: Floats
    middle: Floats
    local: Floats
    local_err: Floats


def _scaling(distance: Sequence[float], value: Sequence[float], err: Sequence[float], sign: int) -> Scaling:
    """sign: of the exponent that is positive."""
    pairs = range(len(distance) - 1)
    steps = [math.log(distance[k + 1] / distance[k]) for k in pairs]
    middle = [math.sqrt(distance[k] * distance[k + 1]) for k in pairs]
    local = [sign * math.log(value[k + 1] / value[k]) / steps[k] for k in pairs]
    local_err = [hypot(err[k] / value[k], err[k + 1] / value[k + 1]) / steps[k] for k in pairs]
    return Scaling(*map(np.array, (distance, value, err, middle, local, local_err)))


def _of(distances: Sequence[Distance], name: str, sign: int) -> Scaling:
    means = [getattr(d, name) for d in distances]
    return _scaling([d.distance for d in distances], [m.mean for m in means], [m.err for m in means], sign)


def _equal(name: str, sign: int) -> Scaling:
    """Chains of equal balls, exactly."""
    balls = [math.floor(4 * math.pow(1000 / 4, k / (EXACT - 1)) + 0.5) for k in range(EXACT)]
    return _scaling([float(n) for n in balls], [getattr(chain_front(n), name) for n in balls], [0.0] * EXACT, sign)


_LOOKS = ({"label": "2D packings", "mark": "o"}, {"label": "chain, equal balls", "dash": 1},
          {"label": "chain, 1 ± 0.1", "mark": "s", "ink": 1, "open": True},
          {"label": "chain, 1 ± 0.2", "mark": "^", "ink": 2, "open": True},
          {"label": "chain, 1 ± 0.4", "mark": "D", "ink": 3, "open": True})
_AXES = (("|A|/|A|_{1}", "|γ|_{eff} = −d log |A| / d log |L|"), ("|W|/|W|_{1}", "|α|_{eff} = d log |W| / d log |L|"))


def _panel(k: int, systems: Sequence[Scaling]) -> Panel:
    """(a) the height A of the first peak, (b) its width W."""
    main, small = [], []
    for s, look in zip(systems, _LOOKS):
        plain = look["label"] == "chain, equal balls"
        words = {**look, "width": 0.8}
        # the panel above has the legend
        main.append(Curve(s.middle, s.local, **{**words, "label": "" if k else look["label"]},
                          error=None if plain else s.local_err))
        small.append(Curve(s.distance, s.value / s.value[0], **{**words, "label": ""},
                           error=None if plain else s.err / s.value[0]))
    inset = Panel(small, "|L| [|d|]", _AXES[k][0], log="xy")
    return Panel(main, "distance |L| [|d|]", _AXES[k][1], tag="(a)(b)"[3 * k:3 * k + 3], log="x", x=(3, 1000), y=(0, None),
                 inset=inset)


def _figure(work: SomfaiWork, item: str) -> None:
    heights, unequal = boxes(work), [chains(work, spread) for spread in SPREADS]
    parts = [[_of(heights, name, sign), _equal(name, sign), *(_of(each, name, sign) for each in unequal)]
             for name, sign in (("amplitude", -1), ("width", 1))]
    work.draw_sheet(item, "fig7", "Local exponents of (a) the height A of the first peak and (b) its width W = t_zero - t10; "
                                  "insets: A and W over those of the shortest distance.",
                    Sheet([_panel(k, part) for k, part in enumerate(parts)], aspect=0.95))
    (a, equal_a, *_), (w, equal_w, *_) = parts
    if len(a.local):
        work.say(item, f"In boxes 24 wide gamma goes from {a.local[0]:.2f} +- {a.local_err[0]:.2f} at L = {a.middle[0]:.3g} to "
                       f"{a.local[-1]:.2f} +- {a.local_err[-1]:.2f} at L = {a.middle[-1]:.3g}, alpha from {w.local[0]:.2f} +- "
                       f"{w.local_err[0]:.2f} to {w.local[-1]:.2f} +- {w.local_err[-1]:.2f}.")
    work.say(item, f"The equal chain is exact ({equal_a.local[-1]:.3f} and {equal_w.local[-1]:.3f} at L = "
                   f"{equal_a.middle[-1]:.0f}; 2/3 and 1/3 far away). The paper does not say how wide its distributions of "
                   "balls are; here diameters are uniform in 1 +- 0.1, 0.2 and 0.4.")
