"""What `sonopack plot KIND` draws: the function, its files and options of each kind. Nothing here imports matplotlib."""
from __future__ import annotations

import dataclasses
import importlib
from collections.abc import Callable
from typing import Any

from .._command import number, whole

ANY = 1 << 16


@dataclasses.dataclass(frozen=True)
class Kind:
    """A kind of figure. The function has its name, in the module of this package; it is called with Inputs and, as
    keywords, the options that are given, labels and material, and scene if `sets` names groups of keys."""

    module: str
    most: int                     # files
    help: str
    options: tuple[str, ...] = ()
    sets: str = ""                # groups of the keys that --set changes
    axes: bool = True             # --x, --y, --log, --linear
    labels: bool = True           # --label
    needs: int = 1                # files

    def function(self, name: str) -> Callable[..., Any]:
        found: Callable[..., Any] = getattr(importlib.import_module(f"sonopack.plot.{self.module}"), name)
        return found


@dataclasses.dataclass(frozen=True)
class Option:
    """An option of some kinds: its word for the value (None: a flag), help, type, and unit, in which numbers are that
    come with a unit of SI."""

    value: str | None
    help: str
    read: Callable[[str], Any] = str
    unit: str = ""


_TIME = "d/sqrt(E* / rho)"
OPTIONS = {
    "store": Option("DIR", "use the samples in this folder instead of a table"),
    "case": Option("CASE", "this case of the table (the first one)"),
    "column": Option("NAME", "spectrum: alpha, k or speed of a harmonic response (the force); column: y2, ... of a "
                             "bifurcation (y1)"),
    "mode": Option("N", "number of the mode, as in `sonopack modes' (the first that is not a zero mode)",
                   whole(0, 10**9)),
    "time": Option("T", "time after the pulse (3.2 H (p/1e-4)^(-1/6), with the wave about three quarters of the way)",
                   number(0, 1e9), _TIME),
    "frames": Option("N", "a movie of N numbered frames: FIGURE is wave-%04d.png, or wave.png for wave-0001.png, ...",
                     whole(2, 100000)),
    "from": Option("T", "--frames: time of the first frame (0)", number(0, 1e9), _TIME),
    "to": Option("T", "--frames: time of the last frame (4.3 H (p/1e-4)^(-1/6))", number(0, 1e9), _TIME),
    "table": Option("FILE", "write the displacements (softmodes: the modes) to this table too (.tsv, .csv, .json)"),
    "lowest": Option("K", "modes of each packing (30)", whole(3, 10**6)),
    "signal": Option("FILE", "a signal or packing, drawn in an inset that explains the marks of the front"),
    "surface": Option(None, "draw a trajectory or densities as a surface over particle and time"),
    "published": Option(None, "draw the published line even over data that do not say that they are two-dimensional"),
    "no-published": Option(None, "leave out the published line"),
}

KINDS = {
    "ctof": Kind("speeds", 12, "speed against pressure from tables of `sonopack table ctof' (TSV or CSV), with the "
                 "published c_tof = 0.26 (p/1e-4)^(1/6) where they say that they are of two dimensions",
                 ("store", "published", "no-published"), needs=0),
    "signal": Kind("signals", ANY, "F(t) of tables with columns t and F (or F1, F2, ...), or of packings, whose signal is "
                   "computed. The first front is marked by a triangle at 10% of its peak, a circle at the peak, and a "
                   "square at the zero crossing. More than ten signals are drawn one above the other, at their distances "
                   "if these are known", sets="network signal"),
    "network": Kind("packing", 1, "a packing with its contacts as lines, whose width shows the normal force; rattlers are "
                    "grey", sets="network", axes=False, labels=False),
    "stiffness": Kind("packing", 1, "the same with the normal stiffness", sets="network", axes=False, labels=False),
    "angles": Kind("packing", ANY, "directions of the contacts of packings, at least 3 d from the walls: all, strong and "
                   "weak contacts; a circle of radius 1 is isotropic. In three dimensions angles are those above the "
                   "horizontal", sets="network", axes=False, labels=False),
    "forces": Kind("packing", ANY, "histograms of normal forces and stiffnesses, divided by their means", sets="network",
                   labels=False),
    "snapshot": Kind("motion", 2, "displacements of the grains at a time after the pulse, which starts at the bottom wall "
                     "(periodic cells have none). A second FILE, a table of --table, is drawn in place of computing them",
                     ("time", "frames", "from", "to", "table"), "network signal", axes=False, labels=False),
    "fronts": Kind("arrivals", 32, "arrival times against distance, with fitted lines, from tables of `sonopack table "
                   "scaling' or `planes', `sonopack chain front' or `sonopack front'", ("signal",), "network signal"),
    "scaling": Kind("arrivals", 32, "local exponents gamma and alpha, from the same tables"),
    "ensemble": Kind("signals", 6, "tables with columns t, mean and rms, and low and high for a band around the mean"),
    "pareto": Kind("speeds", 1, "run time against error from a table of `sonopack bench', one symbol per method, hollow "
                   "for other programs, and the Pareto frontier", ("case",), labels=False),
    "spectrum": Kind("spectra", 32, "tables of `sonopack spectrum' dos, transmission, harmonic or participation, of "
                     "`sonopack modes', of `sonopack table spectrum', or packings (their density of states)",
                     ("column",), "network"),
    "dispersion": Kind("spectra", 2, "a table of `sonopack spectrum dispersion', or a packing; bars are half widths. A "
                       "table of S(k, omega) (--profile) is drawn as a map", sets="network"),
    "wave": Kind("waves", 6, "phase speed and attenuation against wave number from tables of `sonopack wave', and "
                 "Rayleigh's alpha = a k^(dimension + 1) through the points with alpha below k/10"),
    "amplitude": Kind("waves", 6, "speed over its linear limit and shares of contacts that opened and slid against "
                      "amplitude, from tables of `sonopack amplitude'; with --omega and --planes F2/F1^2 against height"),
    "column": Kind("tapped", 6, "a table of `sonopack column' (trajectory, strobe, lyapunov, bifurcation, compare, density "
                   "or energy); trajectories of lattice, longwave and bsr are drawn as surfaces side by side, two columns "
                   "of print wide, and a bifurcation above a table of lyapunov", ("surface", "column")),
    "mode": Kind("motion", 2, "the displacements of a mode as arrows on the grains, tinted where they rotate. A second "
                 "FILE, of `sonopack modes --vectors' (HDF5 or table) or a table of --table, is drawn in place of "
                 "computing the mode", ("mode", "frames", "table"), "network", axes=False, labels=False),
    "modes": Kind("spectra", 6, "omega^2 and a b against n, from tables of `sonopack modes'"),
    "softmodes": Kind("soft", ANY, "density of the lowest modes of many periodic packings, or of a table of --table, with "
                      "the power law of those that are no plane waves, and their participation ratios; the dotted line "
                      "is the first phonon", ("store", "lowest", "table"), "network", labels=False, needs=0),
    "sensitivity": Kind("packing", 2, "a packing with what each contact does to the arrival t10 when it becomes stiffer, "
                        "as the width of its line (growing as the root) and its colour: orange, the arrival is later; "
                        "blue, it is earlier. A second FILE, a table of `sonopack sensitivity --by kn,kt', is drawn in "
                        "place of computing that of t10", sets="network", axes=False, labels=False),
    "grains": Kind("packing", 2, "a packing whose grains are coloured by a table, the second FILE, with the column grain "
                   "and one of factor (sonopack design --rows grains), probability (coda), by_mass or by_radius "
                   "(sensitivity): orange above, blue below", sets="network", axes=False, labels=False, needs=2),
    "clusters": Kind("packing", 2, "a packing whose contacts are coloured by their rigid cluster, redundant ones thick. A "
                     "second FILE, a table of `sonopack clusters', is drawn in place of computing them", sets="network",
                     axes=False, labels=False),
    "transport": Kind("waves", 6, "D and mean free path against frequency from tables of `sonopack transport'"),
    "local": Kind("maps", 1, "a map of the shear moduli of the parts of a packing in two dimensions, from a table of "
                  "`sonopack moduli --probe local:W'", axes=False, labels=False),
    "spectrogram": Kind("maps", 1, "the power of a signal over time and frequency, with the ridge of the largest power, "
                        "from what `signal' takes", sets="network signal", labels=False),
}
