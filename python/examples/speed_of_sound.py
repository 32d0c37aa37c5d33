"""From a scene to the speed of sound: one packing, the pulse at planes on its way up, the speed of its front.

usage: speed_of_sound.py [FIGURE.png]
"""
import sys

import numpy as np

import sonopack


def main(figure: str | None) -> None:
    scene = sonopack.Scene(packing={"grains": 400, "width": 16, "pressure": 1e-4, "seed": 2})
    packing = sonopack.Packing.make(scene)
    print(packing)

    network = packing.network()
    heights = np.linspace(0.2, 0.7, 6) * packing.height
    signal = network.signal(detectors=[f"plane:{height}" for height in heights], points=1601)
    fronts = [signal.front(detector=k) for k in range(len(heights))]
    arrival = np.array([front.t10 for front in fronts])
    slope, _ = np.polyfit(arrival, heights, 1)
    moduli = network.moduli()
    print(f"speed of the front: {slope:.4f} sqrt(E*/rho)")
    print(f"speed of long waves: {moduli.c_l:.4f} sqrt(E*/rho)")

    if figure:
        import matplotlib.pyplot as plt

        for k, height in enumerate(heights):
            force = signal.f[0, k]
            plt.plot(signal.t, height + 2 * force / force.max(), color="C0")
        plt.plot(arrival, heights, "o", color="C1")
        plt.xlabel("t [d / sqrt(E*/rho)]")
        plt.ylabel("height [d], and force through the plane")
        plt.savefig(figure)


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else None)
