"""The page: markup, style, three.js and the modules of web/ put together, and the data written into it."""
from __future__ import annotations

import base64
import functools
import html
import json
import os
import pathlib
import re
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from .. import __version__
from .._core import SonopackError
from .._packing import Packing
from . import _data

_FOLDER = pathlib.Path(__file__).parent
#: modules of the page, each after those that it stands on
_MODULES = ("data", "units", "colours", "shaders", "motion", "signal", "stage", "colouring", "legend", "picture", "address",
            "panel", "main")


def page(packings: Mapping[str, Packing], choice: _data.Choice | Mapping[str, _data.Choice] | None = None, *,
         si: bool = False, missing: Callable[[str, str], object] | None = None) -> str:
    """The text of an HTML file that shows packings, each under its name.

    choice: which modes, and which frames of the wave; or one for each name. si: the page opens in SI units, where the material of a packing is
    known. missing(name, reason) is told what is left out of the page because there is none.
    """
    parts = []
    for name, packing in packings.items():
        own = choice[name] if isinstance(choice, Mapping) else choice or _data.Choice()
        try:
            parts.append(_data.describe(shown_name(name), packing, own, functools.partial(missing or _nothing, name)))
        except SonopackError as fault:
            raise type(fault)(f"{name}: {fault}", fault.status, fault.key) from None
    names = [part["name"] for part in parts]
    more = f" and {len(names) - 1} more" if len(names) > 1 else ""
    data = {"format": "sonopack-view", "version": 1, "program": __version__, "units": "si" if si else "own",
            "packings": parts}
    values = {"VIEW_TITLE": html.escape(f"{names[0]}{more} – sonopack"), "VIEW_DATA": script_json(data)}
    return re.sub("@([A-Z_]+)@", lambda match: values[match.group(1)], _empty_page())


def _nothing(name: str, reason: str) -> None:
    pass


def shown_name(path: str) -> str:
    """The name without its folder; bytes that are no UTF-8 as U+FFFD."""
    return os.fsencode(os.path.basename(path) or path).decode("utf-8", "replace")


def script_json(data: Any) -> str:
    """JSON that may stand in a <script> element: no text ends it, numbers are finite or null, arrays of numpy are
    {"type", "shape", "data"} with the data in base64, little-endian, the last axis fastest."""
    text = json.dumps(_plain(data), allow_nan=False, separators=(",", ":"))
    return re.sub("[<>&']", lambda match: f"\\u{ord(match.group()):04x}", text)


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _plain(part) for key, part in value.items()}
    if isinstance(value, np.ndarray):
        packed = np.ascontiguousarray(value, value.dtype.newbyteorder("<"))
        return {"type": value.dtype.name, "shape": list(value.shape), "data": base64.b64encode(packed.tobytes()).decode()}
    if isinstance(value, (list, tuple)):
        return [_plain(part) for part in value]
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value


def _text(*names: str) -> str:
    return _FOLDER.joinpath(*names).read_text(encoding="utf-8").strip()


def _empty_page() -> str:
    """The page with the marks @VIEW_TITLE@ and @VIEW_DATA@. One module in a page cannot import another, so that imports and
    the word `export` are taken out; names are unique in all of them."""
    code = []
    for name in _MODULES:
        text = re.sub(r"^import .*\n", "", _text("web", f"{name}.js") + "\n", flags=re.M)
        code.append(f"/* ---- {name}.js */\n" + re.sub("^export ", "", text, flags=re.M))
    values = {"VERSION": __version__, "STYLE": _text("web", "style.css"), "CODE": "\n".join(code).strip(),
              "THREE_REVISION": _text("three", "REVISION"), "THREE_LICENSE": _text("three", "LICENSE"),
              "THREE": _text("three", "three.bundle.min.js")}
    return re.sub("@([A-Z_]+)@", lambda match: values.get(match.group(1), match.group()),
                  (_FOLDER / "web/page.html").read_text(encoding="utf-8"))
