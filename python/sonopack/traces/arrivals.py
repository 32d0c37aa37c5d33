"""Arrivals of traces with noise, by four ways, each with its error.

Noise with the spectrum of that before the arrival is added to the trace DRAWS times: the rms change of the arrival, times
_KEPT, is its error, with an interval of sampling / sqrt(12) for the trigger. This serves any way of picking, and filtered
noise."""
from __future__ import annotations

import dataclasses
import math
import zlib
from collections.abc import Sequence

import numpy as np

from .._command import Failed
from .._core import Floats
from .read import Trace

WAYS = ("t10", "t_aic", "t_xcorr", "t_peak")
DRAWS = 64
QUIET_LEAST = 16   # samples before the arrival, from which the noise is known
_KEPT = 1.3        # picks stay where noise has put them once, so draws move them less than noise did (measured)
_FAILED_MOST = 0.1  # share of draws without an arrival


@dataclasses.dataclass
class Arrival:
    """Of each way in the order of WAYS: time, error, and the times of the draws. noise: its standard deviation."""

    times: Floats
    errors: Floats
    draws: Floats  # [way][draw]
    amplitude: float
    amplitude_err: float
    noise: float
    offset: float


class NoArrival(Exception):
    """Why a trace has no arrival."""


def akaike(f: Floats) -> tuple[int, float]:
    """The sample at which variances before and behind differ most: the least of k log var(f[:k]) + (n - k) log var(f[k:])
    (Maeda, Zisin 38, 365 (1985)); and the standard deviation of its likelihood exp(-AIC / 2)."""
    n, least = len(f), 4
    if n < 3 * least:
        raise NoArrival("begins too soon: fewer than 12 samples before the peak")
    k = np.arange(1, n)
    one, two = np.cumsum(f), np.cumsum(f * f)
    floor = 1e-16 * two[-1]
    before = two[:-1] / k - (one[:-1] / k) ** 2
    after = (two[-1] - two[:-1]) / (n - k) - ((one[-1] - one[:-1]) / (n - k)) ** 2
    value = k * np.log(np.maximum(before, floor)) + (n - k) * np.log(np.maximum(after, floor))
    value = value[least - 1:n - least]
    weight, at = np.exp(-0.5 * (value - value.min())), np.arange(len(value))
    best = int(np.argmin(value))
    return least + best, float(np.sqrt(weight @ (at - best) ** 2 / weight.sum()))


def quiet(f: Floats, onset: int, peak: int) -> slice:
    """The samples before the arrival: up to one time of rise before the onset, or at least its first half."""
    return slice(0, max(onset - (peak - onset), onset // 2, min(onset, QUIET_LEAST)))


def find(f: Floats, rise: float = 0.1) -> Floats:
    """Fractional samples of t10, of Akaike's pick, and of the first peak; its height; the width of Akaike's likelihood; the
    samples from t10 to the peak."""
    from scipy.ndimage import uniform_filter1d
    f = f - np.median(f[:max(8, len(f) // 50)])
    top = int(np.argmax(f))
    onset, _ = akaike(f[:top + 1])
    for _ in range(2):
        still = f[quiet(f, onset, top)]
        f = f - still.mean()
        noise = float(still.std())
        smooth = int(min((noise / (0.03 * f[top])) ** 2, (top - onset) / 3))
        top = first_peak(uniform_filter1d(f, smooth | 1), 5 * noise / math.sqrt(smooth | 1))
        onset, width = akaike(f[:top + 1])
    near = uniform_filter1d(f, smooth | 1)
    below = np.flatnonzero(near[:top] < rise * near[top])
    foot = int(below[-1]) if len(below) else onset
    part = min(0.5, (3 * noise / near[top]) ** (1 / 3))  # a polynomial through more samples has less noise and more bias
    peak, height = vertex(f, top, max(2, int(part * (top - foot))))
    halfway = int(np.argmax(near[foot:top + 1] >= 0.5 * (1 + rise) * near[top]))
    bent = min(top, foot + 4 * max(1, halfway))  # a step has its maximum far behind its rise
    return np.array([crossing(f, foot, bent, rise * height, 0.8 * part), onset, peak, height, width, top - foot])


def first_peak(f: Floats, noise: float) -> int:
    """The first maximum above a fifth of the largest value and the noise, below which f falls by 1 % of it and the noise, as
    `sonopack front` finds it."""
    largest = f.max()
    if not largest > noise:
        raise NoArrival("does not rise above its noise")
    highest = np.maximum.accumulate(np.where(f > max(0.2 * largest, noise), f, -np.inf))
    fallen = np.flatnonzero(f < highest - max(0.01 * largest, noise))
    if not len(fallen):
        raise NoArrival("has no maximum above its noise before its end")
    return int(np.argmax(f[:fallen[0]]))


def fitted(f: Floats, centre: int, half: int, degree: int) -> np.poly1d:
    """A polynomial in (k - centre) / half through the samples around the centre."""
    low, high = max(0, centre - half), min(len(f), centre + half + 1)
    x = (np.arange(low, high) - centre) / half
    return np.poly1d(np.polyfit(x, f[low:high], min(degree, len(x) - 1)))


def vertex(f: Floats, top: int, half: int) -> tuple[float, float]:
    """Place and height of the maximum."""
    curve = fitted(f, top, half, 4)
    x = np.linspace(-1, 1, 201)
    at = float(x[np.argmax(curve(x))])
    slope, bend = curve.deriv(1), curve.deriv(2)
    for _ in range(3):
        at = float(np.clip(at - slope(at) / bend(at), -1, 1)) if bend(at) < 0 else at
    return top + half * at, float(curve(at))


def crossing(f: Floats, foot: float, top: int, level: float, part: float) -> float:
    """Where the trace rises through a level near a sample."""
    x = np.linspace(-1, 1, 101)
    for _ in range(2):
        centre = int(foot)
        half = max(2, int(part * (top - centre)))
        over = fitted(f, centre, half, 3)(x) - level
        up = np.flatnonzero((over[:-1] < 0) & (over[1:] >= 0))
        if not len(up):
            return math.nan
        k = up[np.argmin(np.abs(x[up]))]
        foot = centre + half * float(x[k] - over[k] * (x[1] - x[0]) / (over[k + 1] - over[k]))
    return foot


def delay(pulse: Floats, f: Floats, pulse_at: Floats, at: Floats) -> tuple[float, float, float]:
    """By how many samples the front of f is later than that of the pulse, where the cross-correlation coefficient is largest,
    the rms difference that remains, and the rms slope of the pulse. The pulse is taken from two times of rise before its peak to
    half of one behind; delays are sought within two times of rise."""
    rise = max(4, int(pulse_at[5]))
    start, stop = max(0, int(pulse_at[2]) - 2 * rise), min(len(pulse), int(pulse_at[2]) + rise // 2 + 1)
    part = pulse[start:stop]
    guess, reach = int(round(at[2] - pulse_at[2])), 2 * max(rise, int(at[5]))
    shifts = np.arange(max(guess - reach, -start), min(guess + reach, len(f) - stop) + 1)
    if len(shifts) < 3:
        return math.nan, math.nan, math.nan
    windows = np.lib.stride_tricks.sliding_window_view(f, len(part))[start + shifts]
    match = windows @ part / np.sqrt(np.sum(windows * windows, axis=1) + 1e-300)
    best = int(np.argmax(match))
    if not 0 < best < len(shifts) - 1:
        return math.nan, math.nan, math.nan
    half = int(np.clip(rise // 4, 1, min(best, len(shifts) - 1 - best)))
    place, _ = vertex(match, best, half)
    scale = windows[best] @ part / (part @ part)
    rest, slope = windows[best] / scale - part, np.gradient(part)
    return float(shifts[0] + place), float(np.sqrt(np.mean(rest**2))), float(np.sqrt(np.mean(slope**2)))


def noise_like(f: Floats, still: slice, draws: int, seed: int) -> Floats:
    """Noise [draw][sample] with spectrum and strength of a part of f."""
    import scipy.signal
    part = f[still] - f[still].mean()
    n, random = len(f), np.random.default_rng(seed)
    if not part.std() > 0:
        return np.zeros((draws, n))
    frequency, power = scipy.signal.welch(part, nperseg=min(len(part), 128, max(16, len(part) // 4)), detrend="constant")
    size = np.sqrt(np.interp(np.arange(n // 2 + 1) / n, frequency[1:], power[1:]))
    turns = random.normal(size=(draws, len(size), 2)) @ np.array([1, 1j])
    drawn = np.fft.irfft(size * turns, n)
    out: Floats = drawn * (part.std() * math.sqrt(len(part) / (len(part) - 1)) / drawn.std())
    return out


def _draws(trace: Trace, rise: float) -> tuple[Floats, Floats, float]:
    """The trace without offset and its copies with more noise, and where each has its first front."""
    f = trace.f
    first = find(f, rise)
    still = quiet(f, int(first[1]), int(first[2]))
    if still.stop < QUIET_LEAST:
        raise NoArrival(f"{still.stop} samples before the arrival, must be {QUIET_LEAST} or more: the noise is not known")
    f = f - f[still].mean()
    copies = np.vstack([f, f + noise_like(f, still, DRAWS, zlib.crc32(f.tobytes()))])
    places = np.full((DRAWS + 1, 6), math.nan)
    places[0] = first
    for k in range(1, DRAWS + 1):
        try:
            places[k] = find(copies[k], rise)
        except NoArrival:
            pass
    return copies, places, float(f[still].std())


def arrivals(traces: Sequence[Trace], pulse: int = 0, rise: float = 0.1) -> list[Arrival]:
    """The arrivals of traces, by cross-correlation with traces[pulse]."""
    found = []
    for trace in traces:
        try:
            found.append(_draws(trace, rise))
        except NoArrival as fault:
            raise Failed(f"{trace.name}: {fault}") from None
    out = []
    for k, (trace, (copies, places, noise)) in enumerate(zip(traces, found)):
        delays, misfit = np.full(DRAWS + 1, math.nan), 0.0
        if k != pulse and len(trace.f) * abs(trace.step / traces[pulse].step - 1) < 0.1:
            sent, sent_at, sent_noise = found[pulse]
            both = np.array([delay(*each) for each in zip(sent, copies, _filled(sent_at), _filled(places))])
            delays = both[:, 0] + (trace.t[0] - traces[pulse].t[0]) / trace.step
            likely = 1.5 * math.hypot(sent_noise, noise * sent_at[0, 3] / places[0, 3])
            misfit = trace.step * math.sqrt(max(0.0, both[0, 1] ** 2 - likely**2)) / both[0, 2]  # other shapes than the pulse
        times = trace.t[0] + trace.step * places[:, [0, 1, 1, 2]].T
        times[2] = trace.step * delays
        height, height_err = _with_error(places[:, 3], 0.0)
        pairs = [_with_error(each, trace.step) for each in times]
        errors = np.array([b for _, b in pairs])
        errors[1] = math.hypot(errors[1], trace.step * places[0, 4])
        errors[2] = math.hypot(errors[2], misfit)
        out.append(Arrival(np.array([a for a, _ in pairs]), errors, times[:, 1:], height, height_err,
                           noise, float(np.mean(trace.f - copies[0]))))
    return out


def _filled(places: Floats) -> Floats:
    """Draws without an arrival have that of the trace."""
    return np.where(np.isnan(places), places[0], places)


def _with_error(values: Floats, step: float) -> tuple[float, float]:
    """The first value with the rms change of the others, nan where many of them failed."""
    known = values[1:][np.isfinite(values[1:])]
    if not np.isfinite(values[0]) or len(known) < (1 - _FAILED_MOST) * DRAWS:
        return math.nan, math.nan
    return float(values[0]), math.hypot(_KEPT * float(np.sqrt(np.mean((known - values[0]) ** 2))), step / math.sqrt(12))


@dataclasses.dataclass
class Line:
    """Speed of arrivals against distances: its error, chi^2 for degrees of freedom, and the time at distance 0."""

    speed: float
    error: float
    chi2: float
    freedom: int
    start: float


def line(distance: Floats, arrival: Sequence[Arrival], way: int, through: float = math.nan) -> Line | None:
    """The line of least squares, weighted by the errors. through: distance at which the time is 0, of delays. Its error is the
    scatter of the lines of the draws, larger where chi^2 is above its mean."""
    times, errors = (np.array([getattr(a, name)[way] for a in arrival]) for name in ("times", "errors"))
    use = np.isfinite(times) & np.isfinite(distance)
    x, free = distance[use] - (0.0 if math.isnan(through) else through), math.isnan(through)
    if len(set(x)) < 1 + free or not np.any(x):
        return None
    base = np.vstack([x, np.ones_like(x)] if free else [x]).T / errors[use][:, None]
    solve = np.linalg.pinv(base)
    found = solve @ (times[use] / errors[use])
    chi2, freedom = float(np.sum((times[use] / errors[use] - base @ found) ** 2)), int(sum(use)) - 1 - free
    drawn = np.array([np.where(np.isfinite(a.draws[way]), a.draws[way], a.times[way]) for a in arrival])[use]
    scatter = _KEPT * np.std(solve @ (drawn / errors[use][:, None]), axis=1)[0]
    jitter = float(np.sqrt(np.linalg.inv(base.T @ base)[0, 0]))
    error = max(scatter, jitter) * math.sqrt(max(1.0, chi2 / freedom if freedom else 1.0))
    return Line(1 / found[0], error / found[0] ** 2, chi2, freedom, float(found[1]) if free else 0.0)
