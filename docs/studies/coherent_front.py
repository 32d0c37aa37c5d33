"""The front that the measured coherent wave alone gives: shared by the benchmarks `distance' and `leap_distance'."""
import numpy as np


def first_front(t, f):
    """t10, t_peak, t_zero, amplitude by the rule of `sonopack front'."""
    rising = np.flatnonzero((f[1:-1] > f[:-2]) & (f[1:-1] >= f[2:]) & (f[1:-1] > 0.2 * f.max())) + 1
    peak = rising[0]
    level = 0.1 * f[peak]
    start = np.argmax(f[:peak + 1] >= level)
    zero = peak + np.argmax(f[peak:] <= 0)

    def crossing(k, at):
        return t[k - 1] + (at - f[k - 1]) / (f[k] - f[k - 1]) * (t[k] - t[k - 1])
    return crossing(start, level), t[peak], crossing(zero, 0), f[peak]


def fronts(w, k, alpha, distances, lowest, window, exponent=3, points=6000):
    """Fronts of Re int -i w e^(i k y - alpha y - i w t) dw at the distances, from tables of k and alpha at the
    frequencies w: the speed of the lowest frequencies, the factor of k^exponent, and first_front of each distance.
    Below `lowest', for which the boxes are too short, k = w/c and alpha = a k^exponent continue the waves just above.
    window(y): first and last time at the distance y;
    points: number of times and frequencies."""
    low = (w >= lowest) & (w <= 2 * lowest)
    factor = np.mean(alpha[low] / k[low]**exponent)
    speed = np.mean(w[w <= lowest] / k[w <= lowest])
    fine = np.arange(1, points + 1) * (w[-1] / points)
    kk, aa = np.interp(fine, w, k), np.interp(fine, w, np.maximum(alpha, 0))
    below = fine < lowest
    kk[below] = fine[below] * (kk[~below][0] / fine[~below][0])
    aa[below] = factor * kk[below]**exponent
    source = -1j * fine * np.exp(-(fine / (0.75 * w[-1]))**4)  # ends smoothly where the table does
    out = []
    for y in distances:
        t = np.linspace(*window(y), points)
        spectrum = source * np.exp((1j * kk - aa) * y)
        f = np.concatenate([np.real(np.exp(-1j * np.outer(part, fine)) @ spectrum) for part in np.array_split(t, 20)])
        out.append(first_front(t, f * (fine[1] - fine[0])))
    return speed, factor, np.array(out)
