#!/usr/bin/env python3
"""Solitary waves and second harmonics of chains, by the command and by an integration of its own: numbers of
docs/amplitude.md.

usage: chains.py COMMAND

1. A chain of balls that only touch, struck at its end, integrated here with scipy; its wave beside `chain soliton --peaks
   inf'.
2. Chains under pressure struck by `amplitude --planes', beside the solitary wave of the peak that arrives, and beside
   Korteweg and de Vries and Nesterenko.
3. How what Korteweg and de Vries leave out falls with the peak.
4. The second harmonic of a burst beside the second order of the equation of motion.
Takes a minute.
"""
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from scipy.integrate import solve_ivp

COMMAND = sys.argv[1]


def table(*words):
    text = subprocess.run([COMMAND, *map(str, words)], check=True, capture_output=True, text=True).stdout
    rows = [line.split("\t") for line in text.splitlines() if not line.startswith("#")]
    return {name: [row[k] for row in rows[1:]] for k, name in enumerate(rows[0])}


def numbers(found, name):
    return np.array(found[name], float)


def bare_chain(balls=120):
    """m = 1, F = overlap^(3/2), first ball with velocity 1: overlap and velocity against time at two balls."""
    def rate(t, y):
        u, v = y[:balls], y[balls:]
        force = np.maximum(u[:-1] - u[1:], 0) ** 1.5
        a = np.zeros(balls)
        a[:-1] -= force
        a[1:] += force
        return np.concatenate([v, a])

    start = np.zeros(2 * balls)
    start[balls] = 1
    run = solve_ivp(rate, (0, 160), start, method="DOP853", rtol=1e-11, atol=1e-13, dense_output=True)
    t = np.linspace(0, 160, 160001)
    peaks = []
    for i in (60, 100):
        y = run.sol(t)
        overlap, velocity = y[i] - y[i + 1], y[balls + i]
        peaks.append((vertex(t, overlap), vertex(t, velocity)))
    (one, _), (two, moving) = peaks
    return 40 / (two[0] - one[0]), two[1], moving[1]


def vertex(t, f):
    k = np.argmax(f)
    a, b, c = np.polyfit(t[k - 3:k + 4] - t[k], f[k - 3:k + 4], 2)
    return t[k] - b / (2 * a), c - b * b / (4 * a)


def first():
    speed, overlap, velocity = bare_chain()
    sound = np.sqrt(1.5 * np.sqrt(overlap))
    own = table("chain", "soliton", "--peaks", "inf")
    print("1. balls that only touch: speed and velocity in units of a chain at rest with the overlap of the peak")
    print(f"   integrated  {speed / sound:.6f} {velocity / (sound * overlap):.6f}")
    print(f"   soliton     {numbers(own, 'speed_at_peak')[0]:.6f} {numbers(own, 'velocity_at_peak')[0]:.6f}"
          f"   long waves {numbers(own, 'nesterenko_at_peak')[0]:.6f}")


def chain(folder, pressure, balls):
    path = pathlib.Path(folder) / f"{balls}_{pressure:g}.h5"
    if not path.exists():
        subprocess.run([COMMAND, "pack", "-q", "--set", "packing.kind=chain", "--set", f"packing.grains={balls}", "--set",
                        f"packing.pressure={pressure}", "-o", path], check=True, stdout=subprocess.DEVNULL)
    return path


def second(folder):
    print("2. struck chains (200 balls): peak/delta0, measured speed over that of the solitary wave - 1, its error, "
          "kdv and nesterenko over it - 1")
    for pressure, amplitude in ((1e-6, 3), (1e-6, 10), (1e-6, 30), (1e-6, 100), (1e-9, 1000), (1e-10, 10000)):
        found = table("amplitude", chain(folder, pressure, 200), "--amplitudes", amplitude, "--planes", 4,
                      "--tolerance", "1e-4")
        peak = (1 + numbers(found, "overpressure")[3]) ** (2 / 3) - 1
        right, speed, error = (numbers(found, name)[3] for name in ("solitary", "speed_peak", "speed_peak_err"))
        print(f"   A = {amplitude:<6g} {peak:10.4g} {speed / right - 1:10.1e} {error / right:8.1e} "
              f"{numbers(found, 'kdv')[3] / right - 1:10.2e} {numbers(found, 'nesterenko')[3] / right - 1:10.2e}")


def third():
    peaks = [1e-3, 1e-2, 1e-1, 1]
    own = table("chain", "soliton", "--peaks", ",".join(map(str, peaks)))
    print("3. peak, (kdv - speed)/peak^2, (width/kdv_width - 1)/peak")
    for k, peak in enumerate(peaks):
        speed, kdv, width, wide = (numbers(own, name)[k] for name in ("speed", "kdv", "width", "kdv_width"))
        print(f"   {peak:<6g} {(kdv - speed) / peak**2:.5f} {(width / wide - 1) / peak:.4f}")


def second_order(omega, highest, n):
    k, free = 2 * np.arcsin(omega / highest), 2 * np.arcsin(2 * omega / highest)
    ball = 1 / (8 * np.tan(k / 2) ** 2) / (np.exp(-2j * k) - 1)
    wave = -ball * np.exp(1j * (free - 2 * k)) * (np.exp(-1j * free) - 1)
    return abs(np.exp(2j * k * n) / (8 * np.sin(k / 2) ** 2) + wave * np.exp(1j * free * n)) / 1.5


def fourth(folder):
    highest = 2 * np.sqrt(0.5 * np.cbrt(3e-6) / (np.pi / 6))
    length = 1 - np.cbrt(3e-6) ** 2
    print("4. 300 balls, p = 1e-6, A = 0.01: omega/omega_max, cycles, height, F2/F1^2, its error, over second order - 1")
    for part, cycles in ((0.1, 4), (0.2, 6), (0.2, 12)):
        found = table("amplitude", chain(folder, 1e-6, 300), "--amplitudes", 0.01, "--omega", part * highest, "--cycles",
                      cycles, "--planes", 4)
        for k in (0, 3):
            y, ratio, error = (numbers(found, name)[k] for name in ("y", "ratio", "ratio_err"))
            right = second_order(part * highest, highest, y / length)
            print(f"   {part} {cycles:3d} {y:6.1f} {ratio:8.4f} {error:8.1e} {ratio / right - 1:9.1e}")


def main():
    with tempfile.TemporaryDirectory() as folder:
        first()
        second(folder)
        third()
        fourth(folder)


if __name__ == "__main__":
    main()
