"""The stiffness matrix as a matrix of scipy: its lowest modes by scipy, beside those of the library."""
import numpy as np
from scipy.sparse.linalg import eigsh

import sonopack


def main() -> None:
    scene = sonopack.Scene(packing={"grains": 300, "width": 14, "pressure": 1e-4})
    network = sonopack.Packing.make(scene).network()
    K, M = network.K(), network.M()
    print(network)
    print(f"K has {K.nnz} entries and is symmetric to {abs(K - K.T).max():.1g}")

    modes = network.modes(lowest=8, zero=True)
    omega2, _ = eigsh(K, k=modes.n - modes.n_rattler, M=M, sigma=-1e-3)
    theirs = np.sqrt(np.maximum(np.sort(omega2), 0))
    ours = modes.omega[modes.n_rattler:]
    print(f"{modes.n_zero - modes.n_rattler} zero modes beside those of rattlers")
    print("omega (scipy, sonopack, bound of its error):")
    for scipys, own, error in list(zip(theirs, ours, modes.error[modes.n_rattler:]))[-8:]:
        print(f"  {scipys:.9f}  {own:.9f}  {error:.1e}")
    assert np.allclose(theirs[-8:], ours[-8:], rtol=1e-7)

    print(f"participation ratio of the softest mode: {modes.participation[-8]:.3f}")
    states = network.dos(bins=20)
    print("modes per grain below the middle of the spectrum: "
          f"{np.interp(states.omega_max / 2, states.edge[1:], states.cumulative):.3f}")


if __name__ == "__main__":
    main()
