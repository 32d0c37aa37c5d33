"""Sound in compressed granular packings.

    import sonopack

    scene = sonopack.Scene(packing={"grains": 600, "pressure": 1e-4})
    packing = sonopack.Packing.make(scene)
    signal = packing.network().signal()
    print(signal.front())

Packing has the grains and contacts, Network (packing.network()) the springs and everything that follows from them: K,
modes, signals, moduli, spectra. study() fills a Store with the samples of a scene; Table reads the tables of the command;
Column is the tapped column. Lengths are in mean grain diameters d, pressures in E*, times in d / sqrt(E* / rho).

Numbers are those of the command `sonopack`, bit for bit. Arrays are views of the library's memory: they are not copied,
cannot be written to, and keep it alive. Long calls run without the interpreter's lock. Failures raise SonopackError.
"""
from ._amplitude import solitary
from ._column import Column, ColumnRun
from ._core import FileError, Interrupted, InvalidInput, NoMemory, Refused, SonopackError, Status, text_of as _text_of
from ._modes import DampedModes, Modes
from ._native import lib as _lib
from ._network import SPRING, Network
from ._packing import BACK, BOTTOM, CONTACT, FRONT, LEFT, RIGHT, TOP, Packing
from ._place import Place
from ._records import (AmplitudeEnergy, AmplitudeFront, AmplitudeHarmonics, AmplitudeNumber, AmplitudePlane,
                       AmplitudeSecond, Audit, CoherentWave, FiniteStrain, Front, Material, Moduli, PackProgress, ParticipationBin,
                       ProbeModuli, Solitary, Stability, Statics, StudyProgress, TappedTap, ZeroModes)
from ._scene import Scene, scene_help
from ._signal import Pulse, Signal, front, signal_window
from ._spectra import (CONTINUUM_ROW, DISPERSION_POINT, WAVE_FIT, Continuum, DensityOfStates, Dispersion, Harmonic,
                       Transmission, WaveSection)
from ._study import Sample, Store, study
from ._table import Table, quantity

#: version of the library
__version__ = _text_of(_lib.sp_version())

__all__ = [
    "AmplitudeEnergy", "AmplitudeFront", "AmplitudeHarmonics", "AmplitudeNumber", "AmplitudePlane", "AmplitudeSecond",
    "Audit", "BACK", "BOTTOM", "CONTACT", "CONTINUUM_ROW", "CoherentWave", "Column", "ColumnRun", "Continuum",
    "DISPERSION_POINT", "DampedModes", "DensityOfStates", "Dispersion", "FRONT", "FileError", "FiniteStrain",
    "Front", "Harmonic", "Interrupted", "InvalidInput", "LEFT", "Material", "Modes", "Moduli", "Network",
    "NoMemory", "PackProgress", "Packing", "ParticipationBin", "Place", "ProbeModuli", "Pulse", "RIGHT", "Refused",
    "SPRING", "Sample", "Scene", "Signal", "Solitary", "SonopackError", "Stability", "Statics", "Status", "Store",
    "StudyProgress", "TOP", "Table", "TappedTap", "Transmission", "WAVE_FIT", "WaveSection", "ZeroModes", "front",
    "quantity", "scene_help", "signal_window", "solitary", "study",
]
