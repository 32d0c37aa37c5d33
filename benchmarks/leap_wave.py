"""The coherent wave of the benchmark `leap_distance': k and alpha of each packing, the length of scattering, and the
front that they predict."""
import csv
import os
import subprocess
import sys

import numpy as np

import coherent_front
import leap_collapse

WAVES = np.geomspace(0.04, 3.2, 45)  # about the k of the frequencies
PER_WAVE = 0.05  # alpha/k at the wave number 1/l_s: over one wavelength the amplitude falls by a quarter
RANGE = (0.06, 1.2)  # of k in the fit
FITTED = ("k_s", "exponent", "plateau")
AT = np.geomspace(0.1, 1.0, 6)  # wave numbers at which packings are compared


def speed_about(p):
    """Within a third of c_l at all frictions: frequencies must not depend on how many packings there are."""
    return 0.19 * (p / 1e-4)**(1 / 6)


def rows(text):
    return list(csv.DictReader([line for line in text.splitlines() if not line.startswith("#")], delimiter="\t"))


def measure(command, store, samples):
    """Gives each sample its `omega', `k' and `alpha', from STORE/waves where they have been measured before."""
    folder = store / "waves"
    folder.mkdir(exist_ok=True)
    for s in samples:
        path = folder / (s["path"].stem + ".tsv")
        if not path.exists():
            at = ",".join(f"{w:.6g}" for w in WAVES * speed_about(s["kind"][3]))
            text = subprocess.run([command, "wave", "-q", "--threads=1", "--at", at, str(s["path"])], check=True,
                                  text=True, stdout=subprocess.PIPE).stdout
            path.with_suffix(".part").write_text(text)
            os.replace(path.with_suffix(".part"), path)
            print(path, file=sys.stderr)
        table = rows(path.read_text())
        for name in ("omega", "k", "alpha"):
            s[name] = np.array([float(r[name]) for r in table])


def mean_wave(samples):
    """omega, k, alpha and the standard error of alpha, where all packings have a wave."""
    k, alpha = np.array([s["k"] for s in samples]), np.array([s["alpha"] for s in samples])
    told = ~np.isnan(k).any(0)
    error = alpha.std(0, ddof=1) / np.sqrt(len(samples)) if len(samples) > 1 else np.full(alpha.shape[1], np.nan)
    return samples[0]["omega"][told], k.mean(0)[told], alpha.mean(0)[told], error[told]


def means(samples):
    c_l = np.mean([s["c_l"] for s in samples])
    for w, k, alpha, error in zip(*mean_wave(samples)):
        yield {"omega": float(w), "k": float(k), "speed_over_c_l": float(w / k / c_l), "alpha": float(alpha),
               "alpha_err": float(error)}


def law(k, factors):
    """alpha/k: a power of k that ends at a plateau. The factors are ln of the plateau, ln of the wave number where half
    of it is reached, and the exponent."""
    top, middle, n = factors
    power = np.exp(np.clip(n * (np.log(k) - middle), -50, 50))
    return np.exp(top) * power / (1 + power)


def crossover(samples):
    """Fit of `law' to the means over the samples, weighted by how packings of the kind scatter in general: alpha/k
    scatters by a constant part, and by one in proportion. k_s: where the law is PER_WAVE."""
    _, k, alpha, _ = mean_wave(samples)
    use = (k > RANGE[0]) & (k < RANGE[1])
    x, y = k[use], alpha[use] / k[use]
    factors = fit(x, y)
    top, middle, n = factors
    k_s = np.exp(middle) * (PER_WAVE / (np.exp(top) - PER_WAVE))**(1 / n)
    return {"k_s": float(k_s), "exponent": float(n), "plateau": float(np.exp(top))}


def at_numbers(samples):
    """Speed over c_l, and alpha/k, at the wave numbers AT."""
    w, k, alpha, _ = mean_wave(samples)
    c_l = np.mean([s["c_l"] for s in samples])
    return np.concatenate([np.interp(AT, k, w / k / c_l), np.interp(AT, k, alpha / k)])


def fit(x, y):
    """Least squares by Levenberg's and Marquardt's method, from several starts."""
    best = None
    for middle in np.log([0.15, 0.3, 0.6, 1.0]):
        factors, damping = np.array([np.log(0.2), middle, 2.0]), 1e-2
        misfit, chi2 = residual(x, y, factors)
        for _ in range(200):
            j = slopes(x, y, factors)
            step = np.linalg.solve(j.T @ j + damping * np.eye(3), -j.T @ misfit)
            trial = np.clip(factors + step, [np.log(0.06), -3.5, 1], [np.log(1.0), 2, 6])
            after, lower = residual(x, y, trial)
            if lower < chi2:
                done = chi2 - lower < 1e-12 * chi2
                factors, misfit, chi2, damping = trial, after, lower, 0.3 * damping
                if done:
                    break
            else:
                damping *= 4
        if best is None or chi2 < best[1]:
            best = factors, chi2
    return best[0]


def residual(x, y, factors):
    expected = law(x, factors)
    r = (y - expected) / np.hypot(0.01, 0.1 * expected)
    return r, r @ r


def slopes(x, y, factors):
    return np.array([(residual(x, y, factors + h)[0] - residual(x, y, factors - h)[0]) / 2e-5 for h in 1e-5 * np.eye(3)]).T


def predicted(samples, planes, first):
    """Speed over c_l, gamma and alpha from plane to plane, one after the other, of the front of this wave alone, from
    the plane `first' on: nearer to the source waves count that are shorter than those of the table."""
    w, k, alpha, _ = mean_wave(samples)
    c_l, dim = np.mean([s["c_l"] for s in samples]), samples[0]["kind"][0]
    near = np.full(np.count_nonzero(np.array(planes) < first), np.nan)
    y = np.array(planes)[len(near):]
    window = lambda y: ((0.45 * y - 6) / c_l, (1.3 * y + 12) / c_l)
    _, _, marks = coherent_front.fronts(w, k, alpha, y, 0.1 * c_l, window, dim + 1, points=800)
    found = (np.diff(y) / np.diff(marks[:, 0]) / c_l, -leap_collapse.exponents(y, marks[:, 3]),
             leap_collapse.exponents(y, marks[:, 2] - marks[:, 0]))
    return np.concatenate([np.concatenate([near, f]) for f in found])
