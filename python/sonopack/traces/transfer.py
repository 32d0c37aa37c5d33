"""Two traces of one pulse: their transfer function, speeds and Q; and a computed signal fitted to a trace.

Errors are the scatter when noise like that before the arrival is added once more, as in arrivals.py; those of fits grow with
the misfit."""
from __future__ import annotations

import dataclasses
import math
import zlib
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from .._command import Failed
from .._core import Floats
from .arrivals import DRAWS, NoArrival, find, noise_like, quiet
from .read import Trace

_CLEAR = 10.0   # power of a spectrum over that of the noise, from which a frequency is used
_FLOOR = 1e-4    # of the largest amplitude of a spectrum: what digits and ends of records add where a trace has no noise
_TAPERS = 7     # of 4 widths, for the coherence
_LEAST = 5      # frequencies


@dataclasses.dataclass
class Ratio:
    """The trace behind over that in front, at frequencies of both. columns: name -> values, with errors `_err`. q_inverse: 1 / Q
    of the way between. turns: by how much the phase extrapolates to frequency 0 as no multiple of 2 pi."""

    columns: dict[str, Floats]
    q_inverse: float
    q_inverse_err: float
    turns: float
    notes: list[str]


def _parts(trace: Trace) -> tuple[Floats, float, Floats]:
    """The trace without offset, the sample of its first peak, and noise like its own."""
    try:
        place = find(trace.f)
    except NoArrival as fault:
        raise Failed(f"{trace.name}: {fault}") from None
    still = quiet(trace.f, int(place[1]), int(place[2]))
    f, seed = trace.f - trace.f[still].mean(), zlib.crc32(trace.f.tobytes())
    least = _FLOOR * np.abs(np.fft.rfft(f)).max() / math.sqrt(len(f))
    noise = noise_like(trace.f, still, DRAWS, seed) + least * np.random.default_rng(seed + 1).normal(size=(DRAWS, len(f)))
    return f, float(place[2]), noise


def transfer(a: Trace, b: Trace, band: tuple[float, float] = (0.0, math.inf)) -> Ratio:
    """Gain, phase, coherence, phase and group speed between a and b, by frequency [cycles in a unit of time], and Q from the slope
    of ln(gain) against -phase / 2 = omega D / (2 c), D the distance from a to b."""
    if len(a.f) != len(b.f) or abs(a.step / b.step - 1) > 1e-9:
        raise Failed(f"{b.name}: must have as many samples as {a.name}, at the same intervals")
    (f, peak_a, noise_a), (g, peak_b, noise_b) = _parts(a), _parts(b)
    lag = int(round(peak_b - peak_a))
    if np.array_equal(a.f, b.f):
        raise Failed(f"{b.name}: is the same trace as {a.name}")
    omega = 2 * np.pi * np.fft.rfftfreq(len(f), a.step)
    fa, fb, na, nb = (np.fft.rfft(each) for each in (f, g, noise_a, noise_b))
    use = _clear((fa, fb, na, nb), (omega >= 2 * np.pi * band[0]) & (omega <= 2 * np.pi * band[1]) & (omega > 0), a, b)
    omega, way = omega[use], abs(b.distance - a.distance)
    late = lag * a.step
    both = np.vstack([fb[use] / fa[use], (fb[use] + nb[:, use]) / (fa[use] + na[:, use])])
    rest = np.unwrap(np.angle(both * np.exp(1j * omega * late)), axis=1)
    third = max(4, len(omega) // 3)
    start = np.polyfit(omega[:third], rest[:, :third].T, 1)[1] / (2 * np.pi)
    turns = np.round(start)
    shift = b.t[0] - a.t[0]
    phase = rest - 2 * np.pi * turns[:, None] - omega * (late + shift)
    slope = np.gradient(phase, omega, axis=1, edge_order=2)
    speed, group, gain = -omega * way / phase, -way / slope, np.abs(both)
    columns = {"frequency": omega / (2 * np.pi)}
    for name, values in (("gain", gain), ("phase", phase), ("speed", speed), ("group", group)):
        columns |= {name: values[0], f"{name}_err": np.sqrt(np.mean((values[1:] - values[0]) ** 2, axis=0))}
    columns["coherence"] = _coherence(f, np.roll(g, -lag))[use]
    loss, loss_err = _slope(phase / 2, np.log(gain), columns["gain_err"] / gain[0])
    notes = [f"{each.name}: has not decayed at its end, which adds false frequencies: --window cuts it" for each in (a, b)
             if np.std(each.f[-len(f) // 20:]) > 0.01 * np.ptp(each.f)]
    if not way > 0:
        notes.append("speeds need different distances of both traces: --distance")
    low = int(np.sum(columns["coherence"] < 0.5))
    if low > 0.1 * len(omega):
        notes.append(f"the coherence is below 0.5 at {low} of {len(omega)} frequencies: there is more than one wave of the pulse, and "
                     "phases, speeds and Q mean little; --window cuts echoes and scattered waves off")
    if abs(start[0] - turns[0]) > 0.2:
        notes.append(f"at frequency 0 the phase extrapolates to {start[0] - turns[0]:.2f} turns: it must be 0, so the band begins "
                     "too high, or a sensor is reversed")
    return Ratio(columns, loss, loss_err, float(start[0] - turns[0]), notes)


def _clear(spectra: Sequence[npt.NDArray[np.complex128]], within: npt.NDArray[np.bool_], a: Trace, b: Trace) -> slice:
    """The frequencies around the strongest of b at which both stand out of their noise."""
    clear, (fa, fb, na, nb) = within, spectra
    for spectrum, noise in ((fa, na), (fb, nb)):
        power = np.abs(spectrum) ** 2
        clear = clear & (power > _CLEAR * np.mean(np.abs(noise) ** 2, axis=0))
    best = int(np.argmax(np.where(clear, np.abs(fb), 0)))
    dark = np.flatnonzero(~clear)
    low, high = int(np.max(dark[dark < best], initial=-1)) + 1, int(np.min(dark[dark > best], initial=len(clear)))
    if high - low < _LEAST or not clear[best]:
        raise Failed(f"{a.name} and {b.name}: {max(0, high - low)} frequencies at which both stand out of the noise, must be "
                     f"{_LEAST} or more: longer traces have more")
    return slice(low, high)


def _coherence(f: Floats, g: Floats) -> Floats:
    """|<a* b>|^2 / (<|a|^2> <|b|^2>), averages over orthogonal tapers (Thomson, Proc. IEEE 70, 1055 (1982))."""
    import scipy.signal.windows
    tapers = scipy.signal.windows.dpss(len(f), 4, _TAPERS)
    a, b = np.fft.rfft(tapers * f), np.fft.rfft(tapers * g)
    power = np.sum(np.abs(a) ** 2, axis=0) * np.sum(np.abs(b) ** 2, axis=0)
    found: Floats = np.abs(np.sum(a.conj() * b, axis=0)) ** 2 / np.maximum(power, 1e-300)
    return found


def _slope(x: Floats, y: Floats, error: Floats) -> tuple[float, float]:
    """Slope of y[0] against x[0], weighted, and its error from the draws and the misfit."""
    weight = 1 / np.maximum(error, 1e-3 * error.max()) if error.max() > 0 else np.ones_like(error)
    bases = [np.vstack([one, np.ones_like(one)]).T * weight[:, None] for one in x]
    slopes = np.array([np.linalg.lstsq(base, one * weight, rcond=None)[0] for base, one in zip(bases, y)])
    chi2 = float(np.sum((y[0] * weight - bases[0] @ slopes[0]) ** 2)) / (len(weight) - 2)
    scatter = float(np.sqrt(np.mean((slopes[1:, 0] - slopes[0, 0]) ** 2))) * math.sqrt(max(1.0, chi2))
    return float(slopes[0, 0]), max(scatter, math.sqrt(chi2 * np.linalg.inv(bases[0].T @ bases[0])[0, 0]))


# ---- computed signals -----------------------------------------------------------------------------------------------

@dataclasses.dataclass
class Match:
    """f(t) = amplitude s((t - start) / scale): scale in the unit of the trace, its error; rms: what remains over the noise."""

    scale: float
    scale_err: float
    amplitude: float
    start: float
    start_err: float
    rms: float
    t: Floats
    f: Floats
    model: Floats


class Response:
    """What transducers make of a signal: a resonance (frequency, Q) that passes slow signals as they are, or a measured pulse,
    such as their signal face to face."""

    def __init__(self, shape: tuple[float, float] | Trace) -> None:
        if isinstance(shape, Trace):
            from scipy.interpolate import CubicSpline
            f = _parts(shape)[0]
            self.pulse, self.ends = CubicSpline(shape.t, f), (float(shape.t[0]), float(shape.t[-1]))
            self.delay = float(np.sum(shape.t * f**2) / np.sum(f**2))
        else:
            self.pulse, self.omega, self.q = None, 2 * np.pi * shape[0], shape[1]
            self.ends, self.delay = (0.0, 0.0), 1 / (self.omega * self.q)

    def late(self, step: float) -> int:
        """How many samples behind a time matter, since the pulse has times before its trigger."""
        return max(0, math.ceil(-self.ends[0] / step))

    def apply(self, f: Floats, step: float) -> Floats:
        """The response to values at equal intervals, 0 before. Of a resonance exact for straight lines between them."""
        import scipy.signal
        if self.pulse is None:
            terms = ([self.omega**2], [1, self.omega / self.q, self.omega**2])
            above, below, _ = scipy.signal.cont2discrete(terms, step, "foh")
            exact: Floats = scipy.signal.lfilter(above.ravel(), below, f)
            return exact
        first = math.ceil(self.ends[0] / step)
        pulse = self.pulse(step * np.arange(first, math.floor(self.ends[1] / step) + 1))
        whole = scipy.signal.fftconvolve(np.pad(f, (max(first, 0), max(-first, 0))), pulse) * step
        found: Floats = whole[max(-first, 0):][:len(f)]
        return found


def against(trace: Trace, signal: Trace, free: bool = False, whole: bool = False, response: Response | None = None) -> Match:
    """Fits a computed signal to a trace up to its first peak and half a time of rise more, or the whole trace. free: the zero of
    time is fitted too. response: of the transducers, to the signal."""
    import scipy.optimize
    from scipy.interpolate import CubicSpline
    f, peak, noise = _parts(trace)
    place, own = find(trace.f), find(signal.f)
    end = len(f) if whole else min(len(f), int(peak + 0.5 * (peak - place[1])) + 1)
    t, spline, delay = trace.t[:end], CubicSpline(signal.t, signal.f), response.delay if response else 0.0
    if free:
        scale = trace.step * (place[2] - place[0]) / (signal.step * (own[2] - own[0]))
    else:
        scale = (trace.t[0] + trace.step * peak - delay) / (signal.t[0] + signal.step * own[2])
    start = trace.t[0] + trace.step * peak - delay - scale * (signal.t[0] + signal.step * own[2])
    if not scale > 0:
        late = f", less the delay of the response, {delay:.3g}," if response else ""
        raise Failed(f"{trace.name}: the first peak{late} is before the zero of time: --trigger or --free-trigger")

    def stretched(times: Floats, values: Floats) -> Floats:
        x = (times - values[1]) / math.exp(values[0])
        shaped: Floats = np.where((x >= signal.t[0]) & (x <= signal.t[-1]), spline(np.clip(x, signal.t[0], signal.t[-1])), 0.0)
        return shaped

    def shape(values: Floats) -> Floats:
        if not response:
            return stretched(t, values)
        before = math.ceil(max(0.0, (t[0] - values[1]) / trace.step)) + 1
        grid = t[0] + trace.step * np.arange(-before, end + response.late(trace.step))
        return response.apply(stretched(grid, values), trace.step)[before:before + end]

    def off(values: Floats, data: Floats) -> Floats:
        s = shape(np.append(values, 0.0) if not free else values * np.array([1.0, scale]))
        left: Floats = data - s * (s @ data / (s @ s + 1e-300))
        return left

    def fit(data: Floats, begin: Floats) -> Floats:
        least = scipy.optimize.least_squares(off, begin, x_scale=0.01, args=(data,))
        found: Floats = least.x
        return found

    begin = np.array([math.log(scale), start / scale][:1 + free])
    if response:  # which moves the first peak in a way that is not known yet
        tries = [fit(f[:end], begin + [shift, 0.0][:1 + free]) for shift in (-0.3, -0.1, 0.0, 0.1, 0.3)]
        begin = min(tries, key=lambda values: float(np.sum(off(values, f[:end]) ** 2)))
    best = fit(f[:end], begin)
    drawn = np.array([fit(f[:end] + each[:end], best) for each in noise[:24]])
    model = shape(np.append(best, 0.0) if not free else best * np.array([1.0, scale]))
    size = float(model @ f[:end] / (model @ model))
    rms = float(np.std(f[:end] - size * model) / (noise.std() + 1e-12 * np.ptp(f)))
    error = np.sqrt(np.mean((drawn - best) ** 2, axis=0)) * max(1.0, rms)
    at = math.exp(best[0])
    return Match(at, float(error[0]) * at, size, float(best[1]) * scale if free else 0.0,
                 float(error[1]) * scale if free else 0.0, rms, t, f[:end], size * model)
