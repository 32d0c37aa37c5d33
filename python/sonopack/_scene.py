"""Scenes: what to make, from a file, a text or keywords."""
from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from . import _core
from ._core import Path, c_path, call, taken_text
from ._native import ffi, lib

Keys = Mapping[str, Any]


class SceneText(str):
    """A value that is in the syntax of scene files already."""


def scene_value(value: object) -> str:
    """A Python value in the syntax of scene files."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, SceneText):
        return str(value)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return f"{value}L" if abs(value) >= 2**31 else str(value)
    if isinstance(value, float):
        return repr(value)
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    if isinstance(value, Mapping):
        return "{ " + " ".join(f"{key} = {scene_value(item)};" for key, item in value.items()) + " }"
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, (list, tuple, range)):
        items = [scene_value(item) for item in value]
        nested = any(isinstance(item, (list, tuple, Mapping, np.ndarray)) for item in value)
        return f"({', '.join(items)})" if nested else f"[{', '.join(items)}]"
    raise _core.invalid("", f"{value!r}: a scene has numbers, words, true, false, lists and ranges")


def overrides(keys: Keys | None) -> tuple[int, Any, list[Any]]:
    """Count, array of "key=value" texts, and what keeps them alive."""
    texts = [ffi.new("char[]", f"{key}={scene_value(value)}".encode()) for key, value in (keys or {}).items()]
    return len(texts), ffi.new("char *[]", texts) if texts else ffi.NULL, texts


def _text_of_groups(groups: Mapping[str, Keys | None]) -> str:
    return "".join(f"{name} = {scene_value(dict(keys))};\n" for name, keys in groups.items() if keys)


class Scene(_core.Owner):
    """A description of packings, signals and studies, checked as a whole.

    From keywords, one dictionary for each group of `sonopack help scene` (also sonopack.scene_help()):

        Scene(packing={"grains": 200, "pressure": 1e-4}, signal={"points": 401})

    With a material={"E": 70e9, "nu": 0.22, "rho": 2500, "d": 1e-3}, in SI units, values may have units: "100 kPa".
    A list in place of a value, or study={"sweep": [...]}, makes a study. Scene.read("file.cfg", {"packing.seed": 2})
    reads a file and overrides keys; Scene.parse does so with a text. A wrong scene raises InvalidInput, whose `key` is
    the key at fault. Scenes do not change: replace() returns another one.
    """

    _type = "sp_scene"

    def __init__(self, *, packing: Keys | None = None, network: Keys | None = None, signal: Keys | None = None,
                 study: Keys | None = None, material: Keys | None = None) -> None:
        text = _text_of_groups({"material": material, "packing": packing, "network": network, "signal": signal,
                                "study": study})
        self._load(None, text or None, _core.KEYWORDS, {})

    def _load(self, path: Path | None, text: str | None, name: str, keys: Keys) -> None:
        self._source = (path, text, name, dict(keys))
        self._c = _core.new("sp_scene", lib.sp_scene_free, lib.sp_scene_default)
        count, array, kept = overrides(keys)
        with _core.without_place(name):
            if text is not None:
                call(lib.sp_scene_parse, text.encode(), name.encode(), count, array, self._c)
            else:
                call(lib.sp_scene_read, c_path(path) if path is not None else ffi.NULL, count, array, self._c)
        del kept

    @classmethod
    def read(cls, path: Path | None, keys: Keys | None = None) -> Scene:
        """The scene of a file; None: the defaults. keys: {"packing.seed": 2, ...} overrides keys of the file, as --set does."""
        scene = cls.__new__(cls)
        scene._load(path, None, "", keys or {})
        return scene

    @classmethod
    def parse(cls, text: str, keys: Keys | None = None, name: str = "text") -> Scene:
        """The scene of a text in the syntax of scene files. name: what messages call it, before the line."""
        scene = cls.__new__(cls)
        scene._load(None, text, name, keys or {})
        return scene

    def replace(self, keys: Keys) -> Scene:
        """This scene with other values: scene.replace({"packing.seed": 2})."""
        path, text, name, before = self._source
        scene = type(self).__new__(type(self))
        scene._load(path, text, name, {**before, **keys})
        return scene

    def __getitem__(self, key: str) -> float:
        """The value of a numeric key, such as scene["packing.pressure"]."""
        value = float(lib.sp_scene_get(self._c, key.encode()))
        if np.isnan(value):
            raise KeyError(key)
        return value

    @property
    def text(self) -> str:
        """All keys but those of the group column, as the text of a scene file. It gives the same values, bit for bit."""
        return taken_text(lib.sp_scene_text(self._c, ffi.NULL))

    def options(self, group: str) -> dict[str, Any]:
        """The group "network" or "signal" as keywords of packing.network() or network.signal(); a number 0 that stands for a
        choice of the library is left out."""
        struct = getattr(self._c, group)
        names = {"network": ("threshold", "prestress", "sliding_free", "tangential"),
                 "signal": ("until", "points", "method", "tolerance", "source", "damping", "amplitude", "step", "modes",
                            "solver")}[group]
        types = dict(ffi.typeof(struct).fields)
        found = {name: _core.value_of(types[name].type, getattr(struct, name)) for name in names}
        return {name: value for name, value in found.items() if name not in ("until", "step", "modes") or value > 0}

    @property
    def samples(self) -> int:
        """How many samples a study of this scene makes."""
        return int(lib.sp_study_count(self._c))

    def resolved(self) -> Any:
        """A struct of this scene, in which packing.height is a number of grains. It shares the lists of this scene."""
        struct = ffi.new("sp_scene *", self._c[0])
        call(lib.sp_scene_resolve, struct)
        return struct

    def __repr__(self) -> str:
        path, text, name, keys = self._source
        changed = f", {keys!r}" if keys else ""
        if text is None:
            return f"Scene.read({path!r}{changed})"
        return f"Scene.parse({text!r}{changed})"

    def __reduce__(self) -> tuple[Any, ...]:
        return _reload, self._source


def _reload(path: Path | None, text: str | None, name: str, keys: Keys) -> Scene:
    scene = Scene.__new__(Scene)
    scene._load(path, text, name, keys)
    return scene


def scene_help() -> str:
    """The table of all keys of scenes, with units, ranges and defaults."""
    return taken_text(lib.sp_scene_help())
