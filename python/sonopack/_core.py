"""What all parts stand on: calls of the C library, its errors, words for its enums, and arrays on its memory."""
from __future__ import annotations

import contextlib
import enum
import importlib
import inspect
import math
import os
import pickle
import re
import textwrap
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Generic, TypeVar, overload

import numpy as np
import numpy.typing as npt

from . import _records
from ._native import ffi, lib
from ._reference import COMMENTS, UNITS
from ._si import Members, converted, in_si

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Path = str | os.PathLike[str]


# ---- errors ---------------------------------------------------------------------------------------------------------

class Status(enum.IntEnum):
    """Why a call of the library failed: the numbers of sp_status."""

    EINVAL = lib.SP_EINVAL  #: invalid argument, option or scene
    EIO = lib.SP_EIO  #: a file could not be opened, read or written
    EFORMAT = lib.SP_EFORMAT  #: a file has the wrong format, or is truncated or inconsistent
    ENOMEM = lib.SP_ENOMEM  #: out of memory
    EFAILED = lib.SP_EFAILED  #: no equilibrium, no convergence
    EREFUSED = lib.SP_EREFUSED  #: withheld because the accuracy cannot be guaranteed
    EINTERRUPTED = lib.SP_EINTERRUPTED  #: stopped on request; finished work is kept


class SonopackError(Exception):
    """A call of the library failed. `status` is its Status, `key` the scene key, option or column at fault ("" if none),
    and the text names the place, the value, and what would be right."""

    def __init__(self, text: str, status: Status, key: str = "") -> None:
        super().__init__(text)
        self.status = status
        self.key = key

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (str(self), self.status, self.key)


class InvalidInput(SonopackError, ValueError):
    """An argument, a scene or a file says something wrong (EINVAL, EFORMAT)."""


class FileError(SonopackError, OSError):
    """A file could not be opened, read or written (EIO)."""


class NoMemory(SonopackError, MemoryError):
    """Memory ran out (ENOMEM)."""


class Refused(SonopackError):
    """The library withholds a result whose accuracy it cannot guarantee (EREFUSED)."""


class Interrupted(SonopackError):
    """A progress function returned False (EINTERRUPTED). Finished work is kept."""


_CLASSES: dict[Status, type[SonopackError]] = {
    Status.EINVAL: InvalidInput, Status.EFORMAT: InvalidInput, Status.EIO: FileError, Status.ENOMEM: NoMemory,
    Status.EREFUSED: Refused, Status.EINTERRUPTED: Interrupted}


def invalid(key: str, text: str) -> InvalidInput:
    return InvalidInput(f"{key}: {text}" if key else text, Status.EINVAL, key)


def text_of(chars: Any) -> str:
    """A C string as Python's; file names need not be UTF-8."""
    return os.fsdecode(ffi.string(chars)) if chars != ffi.NULL else ""


def taken_text(chars: Any) -> str:
    """A text of the library that is the caller's to free."""
    if chars == ffi.NULL:
        raise NoMemory("out of memory", Status.ENOMEM)
    try:
        return text_of(chars)
    finally:
        lib.sp_free(chars)


def c_path(path: Path) -> bytes:
    name = os.fsencode(path)
    if b"\0" in name:
        raise invalid("", f"file name {path!r}: must not contain a null character")
    return name


def check(status: int, err: Any) -> None:
    if status != lib.SP_OK:
        kind = Status(status)
        text = text_of(err.text) or text_of(lib.sp_status_name(status))
        raise _CLASSES.get(kind, SonopackError)(text, kind, text_of(err.key))


def call(function: Callable[..., int], *arguments: Any) -> None:
    """Calls a function of the library that ends with an sp_error, without the interpreter's lock; raises its error."""
    err = ffi.new("sp_error *")
    lib.sonopack_blas_begin()
    try:
        status = function(*arguments, err)
    finally:
        lib.sonopack_blas_end()
    if status != lib.SP_OK:
        check(status, err)


KEYWORDS = "keywords"  # the name of the text of a scene that was made from them


@contextlib.contextmanager
def without_place(name: str = KEYWORDS) -> Iterator[None]:
    """Errors without the place in a text that the caller has never seen, or an option of the command's: of keywords."""
    try:
        yield
    except SonopackError as fault:
        text = re.sub(rf"^(--set|{KEYWORDS}(:\d+)?): " if name == KEYWORDS else "^--set: ", "", str(fault))
        raise type(fault)(text, fault.status, fault.key) from None


# ---- words ----------------------------------------------------------------------------------------------------------

def _common(names: Sequence[str]) -> str:
    start = os.path.commonprefix(list(names))
    return start[:start.rfind("_") + 1]


_words: dict[str, dict[int, str]] = {}


def words(enum_name: str) -> dict[int, str]:
    """The words of an enum by their numbers, as the command writes them: SP_SIGNAL_LAX_WENDROFF is lax-wendroff."""
    if enum_name not in _words:
        elements = ffi.typeof(enum_name).elements
        # some of them count the others
        start = _common([name for name in elements.values() if not name.endswith(("S_MAX", "IZATIONS", "SP_PROBES"))])
        _words[enum_name] = {number: name.removeprefix(start).lower().replace("_", "-")
                             for number, name in sorted(elements.items())}
    return _words[enum_name]


def number_of(enum_name: str, word: str, key: str) -> int:
    for number, own in words(enum_name).items():
        if word == own:
            return number
    raise invalid(key, f"{word!r}: must be one of {', '.join(words(enum_name).values())}")


# ---- structs --------------------------------------------------------------------------------------------------------

_T = TypeVar("_T")


def value_of(ctype: Any, value: Any) -> Any:
    """A field of a struct as a plain value."""
    if ctype.kind == "enum":
        return words(ctype.cname).get(int(value), str(value))
    if ctype.kind == "struct":
        return record(_records.RECORDS[ctype.cname.removeprefix("struct ")], value)
    if ctype.kind in ("array", "pointer"):
        return text_of(value)
    return value


def record(cls: type[_T], struct: Any, material: Any = None) -> _T:
    """The dataclass of a struct; its fields have the names of the header. material: for its si()."""
    fields = ffi.typeof(struct).fields if ffi.typeof(struct).kind == "struct" else ffi.typeof(struct).item.fields
    made = cls(*(value_of(member.type, getattr(struct, name)) for name, member in fields))
    return made if material is None else with_material(made, material)


def made(cls: type[_T], material: Any, function: Callable[..., int], *given: Any) -> _T:
    """The dataclass of the struct that a function of the library fills, its last argument but for the error."""
    struct = ffi.new(next(name for name, own in _records.RECORDS.items() if own is cls) + " *")
    call(function, *given, struct)
    return record(cls, struct, material)


def with_material(result: _T, material: Any) -> _T:
    """A record that knows the material of its grains, for si()."""
    object.__setattr__(result, "_material", material)
    return result


def set_fields(struct: Any, values: Mapping[str, Any]) -> None:
    """Sets the fields that are given; None leaves the default. Words stand for numbers of enums."""
    ctype = ffi.typeof(struct)
    types = dict((ctype.item if ctype.kind == "pointer" else ctype).fields)
    for name, value in values.items():
        if value is None:
            continue
        member = types[name].type
        try:
            if member.kind == "enum":
                value = number_of(member.cname, value, name)
            setattr(struct, name, value)
        except OverflowError:
            raise invalid(name, f"{value!r}: must be {_range(member.cname)}") from None
        except TypeError as fault:
            raise invalid(name, f"{value!r}: {fault}") from None


def _range(ctype: str) -> str:
    """The numbers that a type of C holds."""
    if ctype == "_Bool":
        return "0 or 1"
    kind: Any = np.dtype(_NUMBERS.get(ctype, np.float64))
    most: Any = np.finfo(kind) if kind.kind == "f" else np.iinfo(kind)
    return f"{most.min} .. {most.max}"


def documented(c_name: str) -> Callable[[_T], _T]:
    """Adds the comment of the C header to a docstring, and the name of what it is about in C."""

    def add(target: _T) -> _T:
        own, _ = COMMENTS.get(c_name, ("", {}))
        if own:
            text = textwrap.fill(f"{own} (C: {c_name})", 110)
            target.__doc__ = f"{inspect.cleandoc(target.__doc__ or '')}\n\n{text}"
        return target

    return add


def new(c_name: str, free: Callable[[Any], None], none: Callable[[], Any] | None = None) -> Any:
    """A struct of the library that frees its arrays together with itself."""
    struct = ffi.new(c_name + " *")
    if none is not None:
        struct[0] = none()
    return ffi.gc(struct, free)


def options_of(c_name: str, values: Mapping[str, Any]) -> Any:
    """Options of the library, with those values that are not its own."""
    options = ffi.new(c_name + " *", getattr(lib, c_name + "_default")())
    set_fields(options, with_damping(values))
    return options


def damping_law(damping: float | str) -> Any:
    """Dashpots: a fraction of critical damping, or words such as "gamma:0.01", "mass:0.1:0.05"."""
    law = ffi.new("sp_damping *", {"value": 0.0, "ratio": 1.0})
    if isinstance(damping, str):
        call(lib.sp_damping_read, damping.encode(), law)
    else:
        set_fields(law, {"value": damping})
    return law


def with_damping(values: Mapping[str, Any]) -> dict[str, Any]:
    """Options with the three fields of dashpots in place of "damping"."""
    out = dict(values)
    if isinstance(out.get("damping"), str):
        law = damping_law(out["damping"])
        out.update(damping=law.value, damping_ratio=law.ratio, damping_kind=words("sp_damping_kind")[int(law.kind)])
    return out


# ---- arrays ---------------------------------------------------------------------------------------------------------

_NUMBERS = {"double": np.float64, "int32_t": np.int32, "int64_t": np.int64, "uint64_t": np.uint64, "uint8_t": np.uint8,
            "int": np.intc, "_Bool": np.bool_}
_dtypes: dict[str, np.dtype[Any]] = {}


def _make_dtype(ctype: Any) -> Any:
    if ctype.kind == "primitive":
        return np.dtype(_NUMBERS[ctype.cname])
    if ctype.kind == "enum":
        return np.dtype(np.int32)
    if ctype.kind == "array":
        return (_make_dtype(ctype.item), (ctype.length,))
    fields = ctype.fields
    return np.dtype({"names": [name for name, _ in fields], "formats": [_make_dtype(m.type) for _, m in fields],
                     "offsets": [m.offset for _, m in fields], "itemsize": ffi.sizeof(ctype)})


def dtype_of(c_name: str) -> np.dtype[Any]:
    """The dtype of a C type; of a struct with its fields at their places."""
    if c_name not in _dtypes:
        _dtypes[c_name] = _make_dtype(ffi.typeof(c_name))
    return _dtypes[c_name]


class _Memory:
    """Memory of the library as numpy reads it. The array's base is this object, which keeps the owner."""

    __slots__ = ("__array_interface__", "owner")

    def __init__(self, owner: Any, address: int, size: int) -> None:
        self.__array_interface__ = {"version": 3, "typestr": "|u1", "shape": (size,), "data": (address, True)}
        self.owner = owner


def view(owner: Any, pointer: Any, shape: tuple[int, ...], c_name: str | None = None) -> npt.NDArray[Any]:
    """An array on memory of the library, without a copy. It cannot be written to, and keeps its owner alive."""
    kind = dtype_of(c_name or ffi.typeof(pointer).item.cname)
    size = math.prod(shape) * kind.itemsize
    if size == 0:
        return np.empty(shape, kind)
    memory = np.asarray(_Memory(owner, int(ffi.cast("uintptr_t", pointer)), size))
    return memory.view(kind).reshape(shape)


class Owner:
    """A Python object that owns a struct of the library, `_c`."""

    _type = ""
    _missing = "not computed"  # why an array is not there
    _c: Any

    def __init_subclass__(cls) -> None:
        if cls._type:
            documented(cls._type)(cls)

    def _make(self, *given: Any) -> None:
        """Makes the struct from what its sp_..._make takes before it."""
        self._c = new(self._type, getattr(lib, f"{self._type}_free"), getattr(lib, f"{self._type}_none"))
        call(getattr(lib, f"{self._type}_make"), *given, self._c)


def in_child(work: Callable[[], _T]) -> _T:
    """What `work` returns or raises, done in a child process; EOFError if that dies."""
    there, here = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            with os.fdopen(here, "wb") as out:
                try:
                    outcome: tuple[Any, Exception | None] = work(), None
                except Exception as fault:
                    outcome = None, fault
                pickle.dump(outcome, out)
        finally:
            os._exit(0)
    os.close(here)
    with os.fdopen(there, "rb") as back:
        data = back.read()
    with contextlib.suppress(ChildProcessError):  # where a program ignores its children, nobody waits for them
        os.waitpid(child, 0)
    try:
        found, raised = pickle.loads(data)
    except pickle.UnpicklingError:  # cut
        raise EOFError from None
    if raised is not None:
        raise raised
    return found  # type: ignore[no-any-return]


def figure_of_kind(kind: str) -> Callable[..., Any]:
    """The function of sonopack.plot that draws a kind of figure."""
    from .plot.kinds import KINDS
    if kind not in KINDS:
        raise invalid("kind", f"{kind!r}: must be one of {', '.join(KINDS)}")
    draw: Callable[..., Any] = getattr(importlib.import_module("sonopack.plot"), kind)
    return draw


class Drawn:
    """An object with figures: plot() makes one, and a notebook shows the usual one."""

    _figure = ""

    def plot(self, kind: str | None = None, *more: Any, **words: Any) -> Any:
        """Draws a figure of a kind of sonopack.plot, by default the usual one, and returns its Axes. more, words: the other
        arguments of that function, such as material, in whose SI units it is drawn, and ax."""
        return figure_of_kind(kind or self._figure)(self, *more, **words)

    def _repr_png_(self) -> bytes | None:
        try:
            frame = importlib.import_module("sonopack.plot._frame")
        except ModuleNotFoundError:  # without matplotlib there is the text
            return None
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found: bytes = frame.picture(self.plot())
        return found


class Result(Owner):
    """An owner of numbers with units, whose members are fields of the struct."""

    def _members(self) -> dict[str, Any]:
        """The fields that have been computed."""
        names = [name for kind in type(self).__mro__ for name, field in vars(kind).items() if isinstance(field, _Field)]
        return {name: getattr(self, name) for name in names if hasattr(self, name)}

    def _known_material(self) -> Any:
        """The material of the packing of which this is a result, if any."""
        of = getattr(self, "network", self)
        return getattr(getattr(of, "packing", of), "material", None)

    def si(self, material: Any = None) -> Members:
        """The members in SI units (m, s, kg, N, Pa), as copies. material: of the grains, by default that of the packing of
        which this is a result. InvalidInput (key "material") if it is not known."""
        material, units = material or self._known_material(), UNITS.get(self._type, {})
        found = {}
        for name, value in self._members().items():
            ctype = dict(ffi.typeof(self._type).fields)[name.rstrip("_")].type
            inner = UNITS.get(ctype.item.cname.removeprefix("struct "), {}) if ctype.kind == "pointer" else {}
            found[name] = converted(value, units.get(name.rstrip("_"), ""), inner, material)
        return Members(type(self).__name__, found, {name: in_si(units[name], material)[1] for name in found if name in units})

    def __repr__(self) -> str:
        shown = []
        for name, value in self._members().items():
            if isinstance(value, np.ndarray):
                shown.append(f"{name} {list(value.shape)}")
            elif isinstance(value, float) or (isinstance(value, (int, str)) and value != ""):
                shown.append(f"{name} = {value:.6g}" if isinstance(value, float) else f"{name} = {value}")
        return f"<{type(self).__name__}: {', '.join(shown)}>"


class NetworkResult(Result):
    """A result that a network and options make."""

    def __init__(self, network: Any, *given: Any) -> None:
        self.network = network
        self._make(network._c, *given)


class _Field:
    """A field of the owner's struct. A name that the header does not have is an error at import."""

    def __set_name__(self, owner: type[Owner], name: str) -> None:
        self.name = name
        self.c_name = name.rstrip("_")
        self.ctype = dict(ffi.typeof(owner._type).fields)[self.c_name].type
        self.__doc__ = COMMENTS.get(owner._type, ("", {}))[1].get(self.c_name, "")

    def __set__(self, owner: Owner, value: object) -> None:
        raise AttributeError(f"{type(owner).__name__}.{self.name} cannot be set")


class Array(_Field):
    """An array of the owner's struct, without a copy. shape: a function of the struct."""

    def __init__(self, shape: Callable[[Any], tuple[int, ...]]) -> None:
        self.shape = shape

    @overload
    def __get__(self, owner: None, cls: type) -> "Array": ...
    @overload
    def __get__(self, owner: Owner, cls: type) -> npt.NDArray[Any]: ...

    def __get__(self, owner: Owner | None, cls: type) -> "npt.NDArray[Any] | Array":
        if owner is None:
            return self
        shape, pointer = self.shape(owner._c), getattr(owner._c, self.c_name)
        if pointer == ffi.NULL and 0 not in shape:
            raise AttributeError(f"{self.name}: {owner._missing}")
        return view(owner._c, pointer, shape)


class Value(_Field, Generic[_T]):
    """A number, a word or a record of the owner's struct."""

    @overload
    def __get__(self, owner: None, cls: type) -> "Value[_T]": ...
    @overload
    def __get__(self, owner: Owner, cls: type) -> _T: ...

    def __get__(self, owner: Owner | None, cls: type) -> "_T | Value[_T]":
        if owner is None:
            return self
        result: _T = value_of(self.ctype, getattr(owner._c, self.c_name))
        return result


def floats(values: npt.ArrayLike, key: str, shape: tuple[int, ...] | None = None) -> Floats:
    """Numbers of the caller as the library reads them: doubles in rows."""
    try:
        array = np.ascontiguousarray(values, dtype=np.float64)
    except (TypeError, ValueError) as fault:
        raise invalid(key, str(fault)) from None
    if shape is not None and array.shape != shape:
        raise invalid(key, f"has the shape {array.shape}, must have {shape}")
    return array


def row(values: npt.ArrayLike, key: str) -> Floats:
    """A number, or a row of them."""
    array = floats(np.atleast_1d(np.asarray(values)), key)
    if array.ndim != 1:
        raise invalid(key, f"has the shape {array.shape}, must be a row of numbers")
    return array


def pointer_to(array: npt.NDArray[Any], c_type: str = "double *") -> Any:
    """For one call; the caller keeps the array."""
    return ffi.cast(c_type, array.ctypes.data)


def pair(values: Sequence[float], key: str) -> tuple[float, float]:
    """Two numbers of the caller."""
    try:
        low, high = map(float, values)
    except (TypeError, ValueError):
        raise invalid(key, f"{values!r}: must be two numbers") from None
    return low, high
