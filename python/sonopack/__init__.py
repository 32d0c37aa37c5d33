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
from ._chain import solitary
from ._column import Column, ColumnRun
from ._core import FileError, Interrupted, InvalidInput, NoMemory, Refused, SonopackError, Status, text_of as _text_of
from ._inference import CODA_CANDIDATE, DESIGN_STEP, Coda, Design, Uncertain, Uncertainty, design, uncertainty
from ._modes import (CONTINUUM_ROW, DISPERSION_POINT, WAVE_FIT, Clusters, ComplexModes, Continuum, DampedModes, DensityOfStates,
                     Dispersion, Harmonic, LocalModuli, Modes, Response, Transmission, WaveSection, free_path, ioffe_regel)
from ._native import lib as _lib
from ._network import ENERGY, FLUX, SPRING, Network
from ._packing import BACK, BOTTOM, CONTACT, FRONT, LEFT, RIGHT, TOP, Packing
from ._place import Place
from ._records import (AmplitudeEnergy, AmplitudeFront, AmplitudeHarmonics, AmplitudeNumber, AmplitudePlane,
                       AmplitudeSecond, Audit, CoherentWave, Energy, FiniteStrain, FreePath, Front, Kubo, Material,
                       Moduli, PackProgress, ParticipationBin, ProbeModuli, RingModuli, RingStatics, Solitary, Split,
                       Spread, Stability, Statics, StudyProgress, TappedTap, ZeroModes)
from ._scene import Scene, scene_help
from ._sensitivity import Gradient
from ._signal import Pulse, Signal, front, signal_window
from ._soft import PowerLaw, SoftModes, power_law, soft_modes
from ._study import Sample, Store, study
from ._table import Table, quantity

#: version of the library
__version__ = _text_of(_lib.sp_version())

__all__ = [
    "AmplitudeEnergy", "AmplitudeFront", "AmplitudeHarmonics", "AmplitudeNumber", "AmplitudePlane", "AmplitudeSecond",
    "Audit", "BACK", "BOTTOM", "CODA_CANDIDATE", "CONTACT", "CONTINUUM_ROW", "Clusters", "Coda", "CoherentWave",
    "Column", "ColumnRun", "ComplexModes", "Continuum", "DESIGN_STEP", "DISPERSION_POINT", "DampedModes",
    "DensityOfStates", "Design", "Dispersion", "ENERGY", "Energy", "FLUX", "FRONT", "FileError", "FiniteStrain",
    "FreePath", "Front", "Gradient", "Harmonic", "Interrupted", "InvalidInput", "Kubo", "LEFT", "LocalModuli",
    "Material", "Modes", "Moduli", "Network", "NoMemory", "PackProgress", "Packing", "ParticipationBin", "Place",
    "PowerLaw", "ProbeModuli", "Pulse", "RIGHT", "Refused", "Response", "RingModuli", "RingStatics", "SPRING", "Sample",
    "Scene", "Signal", "SoftModes", "Solitary", "SonopackError", "Split", "Spread", "Stability", "Statics", "Status", "Store",
    "StudyProgress", "TOP", "Table", "TappedTap", "Transmission", "Uncertain", "Uncertainty", "WAVE_FIT", "WaveSection",
    "ZeroModes", "design", "free_path", "front", "ioffe_regel", "power_law", "quantity", "scene_help", "signal_window",
    "soft_modes", "solitary", "study", "uncertainty",
]
