"""Figures: one function each, which takes objects, tables or files and returns matplotlib's Axes.

    from sonopack import plot

    ax = plot.signal("a.h5", "b.h5", labels=["loose", "dense"])
    ax.set_xlim(0, 100)
    plot.save(ax.figure, "signals.pdf")

Every function takes what `sonopack plot` takes: names of files, Packing, Signal, Table, DataFrame, structured array or
mapping of columns. Keywords of all: ax (the Axes to draw on; else a figure of the width of a print column is made),
material (draw in SI, with this Material) and, where data have legends, labels. Figures with several panels return an array
of Axes. Where matplotlib.pyplot is imported, figures are pyplot's. The style is the file STYLE.
"""
from __future__ import annotations

import importlib
from typing import Any

#: what is here, and the module that has it
_HOMES = {"save": "_frame", "STYLE": "_frame"}


def _home(name: str) -> str | None:
    from .kinds import KINDS
    return _HOMES.get(name) or (KINDS[name].module if name in KINDS else None)


def __getattr__(name: str) -> Any:
    home = None if name.startswith("__") else _home(name)
    if home is None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module(f"{__name__}.{home}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    from .kinds import KINDS
    return sorted({*globals(), *_HOMES, *KINDS})
