"""sonopack trace: arrivals, speeds and spectra of measured traces, with errors from their noise."""
from __future__ import annotations

import argparse
import dataclasses
import math
import os
import re
from collections.abc import Sequence
from typing import Any

import numpy as np

from .. import __version__
from .._command import DONE, Failed, Parser, may_write, note, number, usage, write_table
from .._core import Floats
from .._records import Material
from .._table import Table, material_of
from .arrivals import WAYS, arrivals, line
from .read import KINDS, MICROSECONDS, OWN_TIME, Form, Trace, read
from .transfer import Response, against, transfer

_ABOUT = (
    "Reads traces (text of oscilloscopes with any delimiter and decimals, WAV, SAC, miniSEED, our tables) and prints when "
    "the first front of each arrives, in four ways: t10, 10 % of the first peak, as `sonopack front'; t_aic, Akaike's criterion; "
    "t_xcorr, the delay behind the pulse by cross-correlation; t_peak, the first peak. Errors follow from the noise before the "
    "arrival. Comments give the speed in each way where traces have distances.")
_MORE = """\
Times are in us, distances in mm, speeds in m/s and frequencies in kHz; of our own tables all are in own units. T is a
number with or without unit (20us, 1.5ms), as is a frequency (200kHz).

  sonopack trace scope.csv --columns F=CH1,F=CH2 --distance 0,25 --trigger CH1
  sonopack trace near.csv far.csv --distance 10,40 --filter 20kHz:300kHz --write cleaned.tsv
  sonopack trace scope.csv --distance 10,40 --transfer 1:2 -o ratio.tsv
  sonopack trace scope.csv --columns F=CH2 --against signal.tsv --material E=70e9,nu=0.22,rho=2500,d=1e-3"""


def parser() -> Parser:
    """The options of the command."""
    own = Parser("trace", usage="sonopack trace [OPTION...] FILE...", description=_ABOUT, epilog=_MORE)
    own._negative_number_matcher = re.compile(r"-[0-9.]")  # --window -5:20 has a value, not one more option
    own.add_argument("files", metavar="FILE", nargs="+", help="traces")
    form = own.add_argument_group("Reading")
    form.add_argument("--from", dest="kind", choices=KINDS, default="", help="kind of the files (by their content)")
    form.add_argument("--columns", metavar="t=NAME,F=NAME,...", default="",
                      help="columns of text files, by name or number; F=-NAME turns the sign (all columns)")
    form.add_argument("--time-unit", choices=(*MICROSECONDS, "own"), default="", help="unit of times in text files")
    form.add_argument("--step", metavar="T", type=number(1e-300, 1e300), default=0.0,
                      help="interval of samples in text files without times, in their unit")
    work = own.add_argument_group("Preparation")
    work.add_argument("--trigger", metavar="T|NAME", help="time of the pulse, or the channel whose t10 it is (0)")
    work.add_argument("--window", metavar="A:B", help="use only this part, times after the trigger")
    work.add_argument("--filter", metavar="LOW:HIGH", help="Butterworth filter of order 4, forth and back: without delay")
    work.add_argument("--distance", metavar="D,...", help="distance of each trace from the pulse, in their order")
    work.add_argument("--write", metavar="FILE", help="write the prepared traces, a table for front and plot")
    more = own.add_argument_group("Results")
    more.add_argument("--rise", metavar="X", type=number(0.01, 0.9), default=0.1, help="part of the first peak at t10 (0.1)")
    more.add_argument("--pulse", metavar="NAME", help="trace with which others are correlated (the first)")
    more.add_argument("--transfer", metavar="A:B", help="print the transfer function from trace A to B, speeds and Q")
    more.add_argument("--band", metavar="LOW:HIGH", help="frequencies of --transfer (all that stand out from the noise)")
    more.add_argument("--against", metavar="SIGNAL", help="fit a computed signal to the first front; print both")
    more.add_argument("--response", metavar="F0:Q|FILE", help="--against: transducers with this resonance, or with the measured pulse "
                                                              "of FILE, such as their signal face to face")
    more.add_argument("--free-trigger", action="store_true", help="--against: fit the time of the pulse too")
    return own


def run(arguments: argparse.Namespace) -> int:
    _check(arguments)
    form = _form(arguments)
    traces = [trace for path in arguments.files for trace in read(path, form)]
    if len({trace.t_unit for trace in traces}) > 1:
        raise Failed("some traces are in us, others in own units: must be the same")
    _distances(arguments, traces)
    _prepare(arguments, traces)
    for trace, text in dict.fromkeys((trace.file if "interval" in text or "unit" in text else trace.name, text)
                                     for trace in traces for text in trace.notes):
        note(arguments, f"{trace}: {text}")
    if arguments.write:
        _written(traces).save(arguments.write)
    table = (_transfer if arguments.transfer else _against if arguments.against else _arrivals)(arguments, traces)
    table.add_comment(f"sonopack {__version__}")
    write_table(arguments, table)
    return DONE


# ---- the command line -----------------------------------------------------------------------------------------------

def _check(arguments: argparse.Namespace) -> None:
    wrong = {"--set: no key of a scene changes anything here": arguments.set,
             "--units si: measured traces have SI units, and our own tables are converted by `sonopack signal --units si'":
                 arguments.units == "si",
             "--transfer and --against: must be one of them": arguments.transfer and arguments.against,
             "--free-trigger: needs --against": arguments.free_trigger and not arguments.against,
             "--response: needs --against": arguments.response and not arguments.against,
             "--band: needs --transfer": arguments.band and not arguments.transfer}
    for text, is_wrong in wrong.items():
        if is_wrong:
            raise usage(text)
    if arguments.output:
        may_write(arguments, arguments.output, (".tsv", ".csv", ".json"))
    if arguments.write:
        may_write(arguments, arguments.write, (".tsv",))


def _form(arguments: argparse.Namespace) -> Form:
    form, values = Form(arguments.time_unit, arguments.step, kind=arguments.kind), []
    for pair in arguments.columns.split(",") if arguments.columns else ():
        key, _, name = str(pair).partition("=")
        if key not in ("t", "F") or not name:
            raise usage(f"--columns {arguments.columns:.60}: must be t=NAME,F=NAME,...")
        if key == "t":
            form.time = name
        else:
            values.append(name)
    form.values = values
    return form


def _amount(option: str, text: str, factors: dict[str, float], own: bool) -> float:
    """A number, with a unit where traces have one."""
    found = re.fullmatch(r"\s*([0-9.eE+-]*[0-9.])\s*([A-Za-z]*)\s*", text)
    try:
        if not found or found[2] and (own or found[2] not in factors):
            raise ValueError
        return float(found[1]) * (factors[found[2]] if found[2] else 1.0)
    except ValueError:
        raise usage(f"{option} {text:.60}: must be a number" + ("" if own else f", or one with a unit: {', '.join(factors)}")) from None


def _range(option: str, text: str | None, factors: dict[str, float], own: bool) -> tuple[float, float]:
    if text is None:
        return -math.inf, math.inf
    low, colon, high = text.partition(":")
    limits = tuple(_amount(option, part, factors, own) if part else end for part, end in ((low, -math.inf), (high, math.inf)))
    if not colon or not limits[0] < limits[1]:
        raise usage(f"{option} {text:.60}: must be LOW:HIGH, LOW: or :HIGH, the first below the second")
    return limits[0], limits[1]


_KHZ = {"Hz": 1e-3, "kHz": 1.0, "MHz": 1e3}


def _is_own(traces: Sequence[Trace]) -> bool:
    return traces[0].t_unit != "us"


def _distances(arguments: argparse.Namespace, traces: Sequence[Trace]) -> None:
    if arguments.distance is None:
        return
    texts = arguments.distance.split(",")
    if len(texts) != len(traces):
        raise usage(f"--distance {arguments.distance:.60}: {len(texts)} for {len(traces)} traces, must be one for each: "
                    + ", ".join(trace.name for trace in traces)[:200])
    for trace, text in zip(traces, texts):
        trace.distance = _amount("--distance", text, {"mm": 1.0, "cm": 10.0, "m": 1e3}, _is_own(traces))


def _named(option: str, traces: Sequence[Trace], name: str) -> int:
    """The trace of a name (channel or file:channel), or of a number from 1 in their order."""
    found = [k for k, trace in enumerate(traces) if name in (trace.channel, trace.name)]
    if not found and name.isdigit() and 1 <= int(name) <= len(traces):
        found = [int(name) - 1]
    if len(found) != 1:
        raise usage(f"{option} {name:.60}: must be one of {', '.join(trace.name for trace in traces)[:300]}, or its number")
    return found[0]


# ---- preparation ----------------------------------------------------------------------------------------------------

def _prepare(arguments: argparse.Namespace, traces: Sequence[Trace]) -> None:
    own = _is_own(traces)
    if arguments.filter:
        for trace in traces:
            trace.f = _filtered(trace, _range("--filter", arguments.filter, _KHZ, own), 1.0 if own else 1e-3)
    text, zero = arguments.trigger, 0.0
    if text is not None and re.fullmatch(r"[0-9.eE+-]+[mun]?s?", text):
        zero = _amount("--trigger", text, MICROSECONDS, own)
    elif text is not None:
        first = arrivals([traces[_named("--trigger", traces, text)]], rise=arguments.rise)[0]
        zero = float(first.times[0])
        if math.isnan(zero):
            raise Failed(f"--trigger {text:.60}: the channel has no t10 above its noise")
        note(arguments, f"the pulse is at {zero:.6g} {traces[0].t_unit}, error {first.errors[0]:.2g}, t10 of {text:.60}")
    low, high = _range("--window", arguments.window, MICROSECONDS, own)
    for trace in traces:
        trace.t = trace.t - zero
        keep = (trace.t >= low) & (trace.t <= high)
        if np.sum(keep) < 32:
            raise Failed(f"{trace.name}: {np.sum(keep)} samples in the window, must be 32 or more")
        trace.t, trace.f = trace.t[keep], trace.f[keep]


def _filtered(trace: Trace, band: tuple[float, float], unit: float) -> Floats:
    import scipy.signal
    half = 0.5 / trace.step / unit
    inside = [limit for limit in band if math.isfinite(limit) and limit > 0]
    if not inside or max(inside) >= half:
        raise usage(f"--filter: limits must be above 0 and below half the rate of samples, {half:.6g}")
    kind = "bandpass" if len(inside) == 2 else "lowpass" if math.isfinite(band[1]) else "highpass"
    sections = scipy.signal.butter(4, np.array(inside) / half if len(inside) == 2 else inside[0] / half, kind, output="sos")
    out: Floats = scipy.signal.sosfiltfilt(sections, trace.f - np.median(trace.f[:max(8, len(trace.f) // 50)]),
                                           padtype="even")  # an odd continuation keeps the noise of the first sample
    return out


def _written(traces: Sequence[Trace]) -> Table:
    first = traces[0]
    for trace in traces:
        if len(trace.t) != len(first.t) or not np.allclose(trace.t, first.t, rtol=0, atol=1e-6 * first.step):
            raise Failed(f"{trace.name}: has other times than {first.name}, must have the same to be written beside it")
    names = ["F"] if len(traces) == 1 else [f"F{k + 1}" for k in range(len(traces))]
    said = {name if len(names) > 1 else "F1":
            (f"from bottom to plane:{trace.distance}, " if trace.distance == trace.distance else "")
            + f"{trace.channel} of {os.path.basename(trace.file)}" for name, trace in zip(names, traces)}
    return Table.from_columns({"t": first.t, **{name: trace.f for name, trace in zip(names, traces)}},
                              {"t": first.t_unit, **{name: trace.f_unit for name, trace in zip(names, traces)}}, said)


# ---- tables ---------------------------------------------------------------------------------------------------------

def _arrivals(arguments: argparse.Namespace, traces: Sequence[Trace]) -> Table:
    pulse = _named("--pulse", traces, arguments.pulse) if arguments.pulse else 0
    found = arrivals(traces, pulse, arguments.rise)
    own = _is_own(traces)
    columns: dict[str, Any] = {"file": [trace.file for trace in traces], "channel": [trace.channel for trace in traces],
                               "distance": np.array([trace.distance for trace in traces]),
                               "noise": np.array([one.noise for one in found])}
    units = {"distance": "d" if own else "mm", "noise": traces[0].f_unit, "amplitude": traces[0].f_unit,
             "amplitude_err": traces[0].f_unit}
    for k, name in enumerate(WAYS):
        columns |= {name: np.array([one.times[k] for one in found]), f"{name}_err": np.array([one.errors[k] for one in found])}
        units |= {name: traces[0].t_unit, f"{name}_err": traces[0].t_unit}
    columns |= {"amplitude": np.array([one.amplitude for one in found]),
                "amplitude_err": np.array([one.amplitude_err for one in found])}
    for trace, one in zip(traces, found):
        if math.isnan(one.times[0]):
            note(arguments, f"{trace.name}: noise is {one.noise / one.amplitude:.2g} of the first peak, too much for t10: --filter "
                            "or a larger --rise")
        before = trace.f[trace.t < one.times[3]]
        if one.offset - before.min(initial=math.inf) > 0.5 * one.amplitude + 5 * one.noise:
            note(arguments, f"{trace.name}: falls before its first peak: if its sign is wrong, F=-{trace.channel} turns it")
    return Table.from_columns(columns, units, _speeds(traces, found, pulse))


def _speeds(traces: Sequence[Trace], found: Sequence[Any], pulse: int) -> dict[str, str]:
    """The speeds by each way as comments, where traces have different distances."""
    distance = np.array([trace.distance for trace in traces])
    factor, unit = (1.0, "d/(d/sqrt(E* / rho))") if _is_own(traces) else (1e3, "m/s")
    said = {"pulse": traces[pulse].name}
    for k, name in enumerate(WAYS):
        fit = line(distance, found, k, distance[pulse] if name == "t_xcorr" else math.nan)
        if fit and (name != "t_xcorr" or math.isfinite(distance[pulse])):
            misfit = f"chi^2 {fit.chi2:.3g} of {fit.freedom} degrees of freedom, " if fit.freedom else ""
            said[f"speed_{name.removeprefix('t_')}"] = (f"{fit.speed * factor:.8g} {unit}, error {fit.error * factor:.3g}, {misfit}"
                                                        f"time at distance 0 {fit.start:.6g}{'' if _is_own(traces) else ' us'}")
    return said


def _transfer(arguments: argparse.Namespace, traces: Sequence[Trace]) -> Table:
    first, colon, second = arguments.transfer.partition(":")
    if not colon:
        raise usage(f"--transfer {arguments.transfer:.60}: must be A:B, two traces")
    own = _is_own(traces)
    unit = 1.0 if own else 1e-3
    low, high = _range("--band", arguments.band, _KHZ, own)
    a, b = (traces[_named("--transfer", traces, name)] for name in (first, second))
    ratio = transfer(a, b, (max(low, 0.0) * unit, high * unit))
    for text in ratio.notes:
        note(arguments, text)
    columns, speed = dict(ratio.columns), 1.0 if own else 1e3
    columns["frequency"] = columns["frequency"] / unit
    columns |= {name: columns[name] * speed for name in ("speed", "speed_err", "group", "group_err")}
    units = {"frequency": "sqrt(E* / rho)/d" if own else "kHz", "phase": "rad", "phase_err": "rad",
             **{name: "sqrt(E* / rho)" if own else "m/s" for name in ("speed", "speed_err", "group", "group_err")}}
    loss, error = ratio.q_inverse, ratio.q_inverse_err
    said = {"from": a.name, "to": b.name, "1/Q": f"{loss:.8g}, error {error:.3g}"}
    said["Q"] = (f"{1 / loss:.8g}, error {error / loss**2:.3g}" if loss > 2 * error else f"above {1 / (loss + 2 * error):.4g}"
                 if loss + 2 * error > 0 else "none: the gain rises with the frequency")
    return Table.from_columns(columns, units, said)


def _against(arguments: argparse.Namespace, traces: Sequence[Trace]) -> Table:
    signals = read(arguments.against)
    if len(traces) != 1 or len(signals) != 1:
        raise usage(f"--against: {len(traces)} traces and {len(signals)} signals, must be one of each: --columns F=NAME")
    own = Table.read(arguments.against).metadata
    response = _response(arguments, _is_own(traces)) if arguments.response else None
    fit = against(traces[0], signals[0], arguments.free_trigger, arguments.window is not None, response)
    unit = traces[0].t_unit
    said = {"scale": f"{fit.scale:.10g} {unit} for {signals[0].t_unit}, error {fit.scale_err:.3g}",
            "amplitude": f"{fit.amplitude:.8g}", "misfit": f"{fit.rms:.4g} times the noise"}
    if response:
        said["response"] = arguments.response
    if arguments.free_trigger:
        said["pulse_at"] = f"{fit.start:.8g} {unit}, error {fit.start_err:.3g}"
    material = arguments.material or (material_of(own["material"]) if "material" in own else None)
    if material and unit == "us" and signals[0].t_unit == OWN_TIME:
        said |= _constants(material, fit.scale, fit.scale_err, own.get("pressure", ""))
    return Table.from_columns({"t": fit.t, "F1": fit.f, "F2": fit.model},
                              {"t": unit, "F1": traces[0].f_unit, "F2": traces[0].f_unit}, said)


def _response(arguments: argparse.Namespace, own: bool) -> Response:
    """Of a frequency and a Q, or of the one trace of a file."""
    text = arguments.response
    if re.fullmatch(r"[0-9.]+([eE][+-]?[0-9]+)?[A-Za-z]*:.*", text) and not os.path.exists(text):
        frequency, _, q = text.partition(":")
        f0 = _amount("--response", frequency, _KHZ, own) * (1.0 if own else 1e-3)
        if not f0 > 0:
            raise usage(f"--response {text:.60}: the frequency must be above 0")
        try:
            return Response((f0, number(0.5, 1e4)(q)))
        except argparse.ArgumentTypeError as fault:
            raise usage(f"--response {text:.60}: Q {fault}") from None
    pulses = read(text)
    if len(pulses) != 1 or (pulses[0].t_unit != "us") != own:
        raise usage(f"--response {text:.60}: must be one pulse, with times as those of the trace")
    return Response(pulses[0])


def _constants(material: Material, scale: float, error: float, pressure: str) -> dict[str, str]:
    """E* of the material that makes the time scale d sqrt(rho / E*); or, at the E* given, the pressure, since speeds grow as
    p^(1/6) while the contacts stay."""
    stiff = material.density * (material.diameter / (scale * 1e-6)) ** 2
    said = {"E*": f"{stiff:.8g} Pa, error {2 * stiff * error / scale:.3g}"}
    if re.match(r"[0-9.eE+-]+$", pressure):
        own = material.diameter * math.sqrt(material.density * (1 - material.poisson**2) / material.young) * 1e6
        p = float(pressure) * (own / scale) ** 6
        said["p"] = f"{p:.8g} E*, error {6 * p * error / scale:.3g}, with E* of the material and the contacts of the signal"
    return said
