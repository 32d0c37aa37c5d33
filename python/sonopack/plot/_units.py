"""Units of tables as text of figures, and factors to SI."""
from __future__ import annotations

import math
import re

from .._command import Failed
from .._core import call, set_fields, text_of
from .._native import ffi, lib
from .._records import Material

LENGTH, PRESSURE, FORCE, WAVE = "d", "E*", "E* d^2", "1/d"
TIME, FREQUENCY, SPEED = "d/sqrt(E* / rho)", "sqrt(E* / rho)/d", "sqrt(E* / rho)"

#: units with roots read better as powers of the ratio
_SPELLED = {
    LENGTH: "$d$", WAVE: "$1/d$", PRESSURE: r"$E^*$", FORCE: r"$E^*\,d^2$", "E* d": r"$E^*\,d$",
    SPEED: r"$(E^*/\rho)^{1/2}$", TIME: r"$d\,(\rho/E^*)^{1/2}$", FREQUENCY: r"$(E^*/\rho)^{1/2}/d$",
    "d sqrt(E* / rho)": r"$d\,(E^*/\rho)^{1/2}$", "modes d/sqrt(E* / rho)": r"modes $d\,(\rho/E^*)^{1/2}$",
    "E* d^3/sqrt(E* / rho)": r"$E^*d^3\,(\rho/E^*)^{1/2}$", "l/c": r"$\ell/c$", "K l": r"$K\,\ell$"}
_SQUARE = {LENGTH: "$d^2$", FREQUENCY: r"$E^*/(\rho\,d^2)$"}
_INVERSE = {LENGTH: "$1/d$", WAVE: "$d$", TIME: _SPELLED[FREQUENCY], FREQUENCY: _SPELLED[TIME], "rad/s": "s"}


def same_unit(a: str, b: str) -> bool:
    return a.replace(" ", "") == b.replace(" ", "")


def _spelled(unit: str, spellings: dict[str, str]) -> str | None:
    return next((text for own, text in spellings.items() if same_unit(own, unit)), None)


def plain(text: str) -> str:
    """A text of the user: no part of it is a formula, and control characters show."""
    shown = "".join(c if c.isprintable() else "?" for c in text.encode(errors="replace").decode())
    return shown.replace("$", r"\$")


def unit_text(unit: str) -> str:
    """A unit as figures show it: "d/sqrt(E* / rho)" with powers, "us" as µs, "m^2" with a raised 2."""
    own = _spelled(unit, _SPELLED)
    if own is not None:
        return own
    text = re.sub(r"(?<![A-Za-z])u(?=[smNgPJ](?![A-Za-z])|Pa)", "µ", plain(unit))
    return re.sub(r"\^(-?\d+)", r"$^{\1}$", text)


def square(unit: str) -> str:
    """The text of the square of a unit."""
    return _spelled(unit, _SQUARE) or (_group(unit) + "$^2$" if unit else "")


def inverse(unit: str) -> str:
    """The text of one over a unit."""
    return _spelled(unit, _INVERSE) or ("1/" + _group(unit) if unit else "")


def _group(unit: str) -> str:
    return f"({unit_text(unit)})" if re.search(r"[ /*^(]", unit) else unit_text(unit)


def label(symbol: str, unit: str = "") -> str:
    """The label of an axis: symbol and unit of a table."""
    return worded(symbol, unit_text(unit))


def worded(symbol: str, text: str) -> str:
    """The label of an axis: symbol, and the text of its unit in brackets."""
    return f"{symbol}  [{text}]" if text else symbol


def to_si(unit: str, material: Material | None) -> tuple[float, str]:
    """The factor from one of our units to SI, and the SI unit; (1, unit) without a material."""
    if material is None:
        return 1.0, unit
    struct, factor, si = ffi.new("sp_material *"), ffi.new("double *"), ffi.new("char[40]")
    set_fields(struct, {name: getattr(material, name) for name in material.__dataclass_fields__})
    call(lib.sp_unit_to_si, unit.encode(), struct, factor, si)
    return float(factor[0]), text_of(si)


def is_ours(unit: str) -> bool:
    """Whether a unit has E*, rho or d."""
    return bool(lib.sp_unit_is_ours(unit.encode()))


def number(value: float, digits: int = 4) -> str:
    """A number in a text: 0.25, 3 10^-5."""
    text = f"{value:.{digits}g}"
    if 0 < abs(value) < 9.99e-4 and "e" not in text:
        text = re.sub(r"\.?0*e", "e", f"{value:.{digits - 1}e}")
    mantissa, e, exponent = text.partition("e")
    if not e:
        return text.replace("-", "\N{MINUS SIGN}")
    power = f"10^{{{int(exponent)}}}"
    return f"${power}$" if mantissa == "1" else rf"${mantissa}\times{power}$"


def measured(value: float, error: float) -> str:
    """A value with its standard error in the last digits, for formulas: 0.166(4), 0.152(17)."""
    if not 1e-4 * abs(value) < error < 1e300:
        return f"{value:.3g}"
    places = -math.floor(math.log10(error))
    places = max(places + (round(error * 10**places) < 3), 0)
    return f"{value:.{places}f}({round(error * 10**places)})"


def refuse(name: str, text: str) -> Failed:
    """Data that a figure cannot show. name: the file, "" if there is none."""
    return Failed(f"{name}: {text}" if name else text)
