"""One number of an HDF5 file made false: what the tests of forged packings and of forged samples share."""
import h5py
import numpy as np

WAYS = "more", "minus", "zero", "nan"


def numbers_of(path, *groups):
    """The datasets of numbers below these groups."""
    found = []
    with h5py.File(path) as file:
        file.visititems(lambda name, it: found.append(name) if isinstance(it, h5py.Dataset) and it.dtype.kind in "fiu" else None)
    return [name for name in found if name.startswith(groups)]


def forge(path, name, way, row=None):
    """Makes one number larger, negative, zero, or none ("nan"): the first of the middle row, unless another is given.
    Whether anything has changed."""
    with h5py.File(path, "r+") as file:
        data = np.array(file[name][()])
        flat = data.reshape(-1, data.shape[-1] if data.ndim > 1 else 1)  # a row for each grain or contact
        at = row if row is not None and row < len(flat) else len(flat) // 2
        old = flat[at, 0]
        if data.dtype.kind == "f":
            new = {"more": 1.5 * old if old else 1e-3, "minus": -old, "zero": 0.0, "nan": np.nan}[way]
        elif name.endswith("rattler"):
            new = 1 - old
        else:
            new = {"more": int(old) + 1, "minus": -1 if data.dtype.kind == "i" else 0, "zero": 0, "nan": old}[way]
        flat[at, 0] = new
        file[name][...] = flat.reshape(data.shape)
    return bool(new != old) and not (np.isnan(new) and np.isnan(old))
