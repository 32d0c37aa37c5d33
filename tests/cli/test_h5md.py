"""Packings are H5MD files: a checker that follows the specification 1.1 section by section, tried on planted faults first.

usage: test_h5md.py COMMAND SOURCE_DIR
"""
import shutil

import h5py
import numpy as np

from command import main, pack
from common import expect


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
        bad = shutil.copy(good, "bad.h5")
        with h5py.File(bad, "r+") as f:
            fault(f)
        try:
            faults = Checker(bad).faults
        except (KeyError, TypeError) as error:
            faults = [error]
        assert faults, "the checker misses a fault"


def packings():
    paths = [pack("plane.h5", grains=60, width=8), pack("chain.h5", kind="chain", grains=5),
             pack("space.h5", dimension=3, grains=120, width=5, depth=5), pack("box.h5", cell="box", grains=50, width=8),
             pack("tilted.h5", cell="periodic", grains=50, width=8, stress="[1e-4,1.2e-4,2e-5]")]
    check_the_checker(paths[0])
    for path in paths:
        for fault in Checker(path).faults:
            expect(False, f"{path}: {fault}")


main(packings)
