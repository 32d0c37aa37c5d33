"""Tables of `sonopack column`: which output one is, and its columns."""
from __future__ import annotations

import re
from typing import Any

import numpy as np

from .._core import Floats
from ._inputs import Input
from ._units import label, plain, refuse

#: outputs, the abscissa of each, and a column that no other output has
_SIGNS = (("lyapunov", "parameter", "lambda"), ("bifurcation", "parameter", "tap"), ("energy", "tap", "work"),
          ("strobe", "tap", "density"), ("compare", "t", "mean_longwave"), ("compare", "t", "mean_bsr"),
          ("density", "t", "rho1"), ("trajectory", "t", "y0"), ("trajectory", "t", "y1"))
KINDS = {"trajectory": "a trajectory", "strobe": "a strobe table", "lyapunov": "a Lyapunov table",
         "bifurcation": "a bifurcation", "compare": "a comparison", "density": "a density table",
         "energy": "an energy table"}
#: the tapped column has units of its own
_SI = {"cm": (0.01, "m"), "g/cm": (0.1, "kg/m"), "erg": (1e-7, "J")}
_PARAMETERS = {"amplitude": "$a$", "period": "$T$", "frequency": "$f$", "restitution": "$e$", "e": "$e$"}


class Tapped:
    """A table of the tapped column. output: a key of KINDS. particles: number of columns y1, y2, ..."""

    def __init__(self, one: Input) -> None:
        self.one, self.table, self.si = one, one.raw_table, one.material is not None
        text = next((name for name in self.table.names if self.table[name].dtype.kind not in "fiu"), None)
        if text is not None:
            raise refuse(one.name, f"column {text} holds text: must be numbers")
        names = set(self.table.names)
        found = next(((output, abscissa) for output, abscissa, sign in _SIGNS if {abscissa, sign} <= names), None)
        if found is None:
            raise refuse(one.name, "the table is not one of `sonopack column', with columns t y0 y1 ..., tap t y1 ... "
                                   "density, parameter lambda, parameter tap y1 ..., t mean_longwave ..., t y1 ... "
                                   "rho1 ..., or tap work dissipated ...")
        self.output, self.abscissa = found
        self.particles, densities = self._run("y"), self._run("rho")
        self._check(densities)

    def _run(self, name: str) -> int:
        count = 0
        while f"{name}{count + 1}" in self.table:
            count += 1
        return count

    def _check(self, densities: int) -> None:
        must = "must be a table of `sonopack column'"
        if self.particles == 0 and self.output in ("trajectory", "strobe", "bifurcation"):
            raise refuse(self.one.name, f"the table has no column y1 of numbers; {must}")
        if self.output == "density" and densities != self.particles:
            raise refuse(self.one.name,
                         f"{self.particles} columns y1, y2, ... and {densities} columns rho1, rho2, ...: must "
                                        f"be equal numbers")
        if self.output == "energy" and "dissipated" not in self.table:
            raise refuse(self.one.name, f"the table has no column dissipated of numbers; {must}")
        if self.table.rows == 0:
            raise refuse(self.one.name, "nothing to draw: no row")

    def __contains__(self, name: str) -> bool:
        return name in self.table

    def __getitem__(self, name: str) -> Floats:
        """A column, in SI where that is asked for; nan in place of what is not finite."""
        values = self.table[name].astype(float)
        factor = _SI.get(self.table.units[name], (1.0, ""))[0] if self.si else 1.0
        return np.where(np.isfinite(values), factor * values, np.nan)

    def y(self, particle: int) -> Floats:
        return self[f"y{particle}"]

    def label(self, symbol: str, column: str) -> str:
        unit = self.table.units.get(column, "")
        return label(symbol, _SI.get(unit, (1.0, unit))[1] if self.si else unit)

    def time(self) -> Floats:
        """The abscissa, which must rise."""
        values = self.table[self.abscissa].astype(float)
        if len(values) < 2:
            raise refuse(self.one.name, "nothing to draw: one row, must be two or more")
        bad = np.flatnonzero(~np.isfinite(values))
        if len(bad):
            raise refuse(self.one.name, f"row {bad[0] + 1}, {self.abscissa} = {values[bad[0]]:g}: must be finite")
        falls = np.flatnonzero(np.diff(values) <= 0)
        if len(falls):
            k = falls[0] + 1
            raise refuse(self.one.name,
                         f"row {k + 1}, {self.abscissa} = {values[k]:g} after {values[k - 1]:g}: must rise")
        return values

    def setting(self, key: str) -> float:
        """A positive number of the comments, nan without it."""
        value = self.one.number(key)
        return value if 0 < value < float("inf") else float("nan")

    def text(self, key: str) -> str:
        return str(self.table.metadata.get(key, ""))

    def parameter(self) -> str:
        """The label of the parameter of a diagram."""
        name = self.text("parameter")
        return self.label(_PARAMETERS.get(name, plain(name or "parameter")), "parameter")

    def violated(self) -> str:
        """The warning of a table whose particles did not keep their order; "" if there is none."""
        words = re.compile(r"warning: ordering \(1\) violated at (\d+) of (\d+) points")
        found = [words.match(one) for one in self.table.comments]
        return next((f"order (1) violated at {one[1]} of {one[2]} points" for one in found if one), "")


def any_finite(*columns: Any) -> bool:
    return any(np.any(np.isfinite(column)) for column in columns)
