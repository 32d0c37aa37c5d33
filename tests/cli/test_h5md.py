"""Packings are H5MD files: a checker that follows the specification 1.1 section by section, tried on planted faults first.

usage: test_h5md.py COMMAND SOURCE_DIR
"""
import os
import shutil
import subprocess
import sys
import tempfile

import h5py
import numpy as np

from cells import box_of_disks, lattice, write_packing

COMMAND = sys.argv[1]
FOLDER = tempfile.mkdtemp(prefix="sonopack-h5md-")


def is_integer(dtype):
    return np.issubdtype(dtype, np.integer)


def is_fixed_text(attribute_or_dtype):
    info = h5py.check_string_dtype(attribute_or_dtype)
    return info is not None and info.length is not None


class Checker:
    def __init__(self, path):
        self.faults = []
        with h5py.File(path) as f:
            self.f = f
            self.metadata()
            self.particles()
            self.connectivity()

    def need(self, condition, what):
        if not condition:
            self.faults.append(what)
        return bool(condition)

    def attribute(self, where, name, shape, check, what):
        attributes = self.f[where].attrs if where in self.f else {}
        if not self.need(name in attributes, f"{where} has no attribute {name}"):
            return None
        a = attributes.get_id(name)
        self.need(a.shape == shape, f"{where}.{name} has the shape {a.shape}, must be {shape}")
        self.need(check(a.dtype), f"{where}.{name} is {a.dtype}, must be {what}")
        return attributes[name]

    def metadata(self):
        """Group h5md: version, author/name, creator/name and version."""
        if not self.need("h5md" in self.f, "no group h5md"):
            return
        version = self.attribute("h5md", "version", (2,), is_integer, "integer")
        self.need(version is not None and list(version) in ([1, 0], [1, 1]), "version is not 1.x")
        self.attribute("h5md/author", "name", (), is_fixed_text, "text of fixed length")
        self.attribute("h5md/creator", "name", (), is_fixed_text, "text of fixed length")
        self.attribute("h5md/creator", "version", (), is_fixed_text, "text of fixed length")

    def element(self, where, tail, check):
        """An element of N particles: a dataset, or a group with value, step and perhaps time."""
        e = self.f[where]
        if isinstance(e, h5py.Dataset):
            self.need(e.shape == tail and check(e.dtype), f"{where}: {e.shape} {e.dtype}, must be {tail}")
            return
        if not self.need("value" in e and "step" in e, f"{where} lacks value or step"):
            return
        value, step = e["value"], e["step"]
        self.need(value.shape[1:] == tail and check(value.dtype), f"{where}: {value.shape}, must end in {tail}")
        self.need(is_integer(step.dtype) and step.shape in ((), value.shape[:1]), f"{where}/step: {step.shape}")
        self.need("time" not in e or e["time"].shape == step.shape, f"{where}/time: its shape is not that of step")
        self.need(step.shape == () or (np.diff(step[:]) > 0).all(), f"{where}/step: must increase")

    def particles(self):
        for name, group in self.f.get("particles", {}).items():
            where = f"particles/{name}"
            if not self.need("box" in group, f"{where} has no box"):
                continue
            dim = self.attribute(where + "/box", "dimension", (), is_integer, "integer")
            boundary = self.attribute(where + "/box", "boundary", (dim,), is_fixed_text, "text of fixed length")
            self.need(boundary is not None and set(boundary) <= {b"periodic", b"none"}, f"{where}/box: boundary")
            if self.need("edges" in group["box"] or set(boundary) == {b"none"}, f"{where}/box: no edges"):
                self.need(group["box/edges"].shape in ((dim,), (dim, dim)), f"{where}/box/edges: shape")
            n = group["position/value"].shape[1]
            self.element(where + "/position", (n, dim), lambda t: np.issubdtype(t, np.floating))
            for vector in ("velocity", "force", "image"):
                if vector in group:
                    self.element(f"{where}/{vector}", (n, dim), lambda t: True)
            if "mass" in group:
                self.element(where + "/mass", (n,), lambda t: np.issubdtype(t, np.floating))
            for integer in ("id", "species"):
                if integer in group:
                    self.element(f"{where}/{integer}", (n,), is_integer)

    def connectivity(self):
        """Tuples of particles of one group, which an object reference names; they are indices where it has no id."""
        for name, tuples in self.f.get("connectivity", {}).items():
            where = f"connectivity/{name}"
            if not self.need(isinstance(tuples, h5py.Dataset) and tuples.ndim == 2 and is_integer(tuples.dtype),
                             f"{where}: must be integers [N][T]"):
                continue
            reference = tuples.attrs.get("particles_group")
            if not self.need(isinstance(reference, h5py.Reference) and tuples.attrs.get_id("particles_group").shape == (),
                             f"{where}: particles_group must be a reference to an object"):
                continue
            group = self.f[reference]
            self.need(group.parent.name == "/particles", f"{where}: refers to {group.name}")
            known = group["id"][:] if "id" in group else np.arange(group["position/value"].shape[1])
            self.need(np.isin(tuples[:], known).all(), f"{where}: has entries that are no particles")


def make(name, **keys):
    words = [word for key, value in keys.items() for word in ("--set", f"packing.{key}={value}")]
    path = os.path.join(FOLDER, name)
    result = subprocess.run([COMMAND, "pack", "--quiet", *words, "-o", path], capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    return path


def check_the_checker(good):
    def wall_as_pair(f):
        pairs = f["connectivity/contacts"]
        old, reference = pairs[:], pairs.attrs["particles_group"]
        del f["connectivity/contacts"]
        f["connectivity/contacts"] = np.concatenate([old, [[0, -1]]]).astype("i4")
        f["connectivity/contacts"].attrs["particles_group"] = reference

    def pop(group, name):
        return lambda f: f[group].attrs.pop(name)

    for fault in (wall_as_pair, pop("h5md", "version"), pop("h5md/author", "name"), pop("connectivity/contacts", "particles_group"),
                  pop("particles/grains/box", "boundary"), lambda f: f.pop("h5md"), lambda f: f["particles/grains"].pop("box"),
                  lambda f: f["h5md/creator"].attrs.__setitem__("name", "of variable length"),
                  lambda f: f["particles/grains/position"].pop("step")):
        bad = os.path.join(FOLDER, "bad.h5")
        shutil.copy(good, bad)
        with h5py.File(bad, "r+") as f:
            fault(f)
        try:
            faults = Checker(bad).faults
        except (KeyError, TypeError) as error:
            faults = [error]
        assert faults, "the checker misses a fault"


def rewritten(name, packing):
    """A cell of another kind, as convert writes it."""
    path = os.path.join(FOLDER, name)
    result = subprocess.run([COMMAND, "convert", write_packing(path + ".made.h5", packing), path], capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    return path


paths = [make("2.h5", grains=60, width=8), make("1.h5", kind='"chain"', dimension=1, grains=5),
         make("3.h5", dimension=3, grains=120, width=5, depth=5),
         rewritten("tilted.h5", lattice(2, 0.3)), rewritten("sheared.h5", lattice(3, 0.2, cells=4)), rewritten("box.h5", box_of_disks())]
check_the_checker(paths[0])
faults = [f"{os.path.basename(path)}: {fault}" for path in paths for fault in Checker(path).faults]
print(*faults, sep="\n")
shutil.rmtree(FOLDER)
sys.exit(1 if faults else 0)
