"""Progress functions and Ctrl-C: what the library calls back while it works."""
from __future__ import annotations

from collections.abc import Callable
from types import TracebackType
from typing import Any

from . import _core, _records
from ._native import ffi, lib


class Watch:
    """One call of the library that may be stopped. An exception in a callback, Ctrl-C among them, stops the work; `run`
    raises it again once the library has cleaned up."""

    def __init__(self, progress: Callable[[Any], object] | None,
                 row: Callable[[Any, Any, Any], None] | None = None) -> None:
        self.progress, self.row = progress, row
        self.stopped = False
        self.exception: BaseException | None = None
        self.handle = ffi.new_handle(self)

    def report(self, what: object) -> bool:
        """Passes progress on. False stops the work."""
        if self.progress is not None and self.exception is None and self.progress(what) is False:
            self.stopped = True
        return not self.stopped and self.exception is None

    def keep(self, exception: BaseException) -> None:
        if self.exception is None:
            self.exception = exception

    def run(self, function: Callable[..., int], *arguments: Any) -> None:
        try:
            _core.call(function, *arguments)
        except _core.SonopackError:
            if self.exception is None:
                raise
        exception, self.exception = self.exception, None
        if exception is not None:
            raise exception


def _on_error(kind: type[BaseException], exception: BaseException, trace: TracebackType | None) -> None:
    """cffi caught this in a callback. Its frame has the argument `user`, also if Ctrl-C came before the first line."""
    while trace is not None:
        user = trace.tb_frame.f_locals.get("user")
        if isinstance(user, ffi.CData):
            ffi.from_handle(user).keep(exception)
            return
        trace = trace.tb_next


@ffi.def_extern(error=False, onerror=_on_error)  # type: ignore[misc]
def sonopack_pack_watch(progress: Any, user: Any) -> bool:
    watch: Watch = ffi.from_handle(user)
    return watch.report(_core.record(_records.PackProgress, progress) if watch.progress else None)


@ffi.def_extern(error=False, onerror=_on_error)  # type: ignore[misc]
def sonopack_study_watch(progress: Any, user: Any) -> bool:
    watch: Watch = ffi.from_handle(user)
    return watch.report(_core.record(_records.StudyProgress, progress) if watch.progress else None)


@ffi.def_extern(error=False, onerror=_on_error)  # type: ignore[misc]
def sonopack_tapped_watch(share: float, user: Any) -> bool:
    watch: Watch = ffi.from_handle(user)
    return watch.report(share)


@ffi.def_extern(error=True, onerror=_on_error)  # type: ignore[misc]
def sonopack_tapped_stopped(user: Any) -> bool:
    watch: Watch = ffi.from_handle(user)
    return watch.stopped or watch.exception is not None


@ffi.def_extern(error=lib.SP_EINTERRUPTED, onerror=_on_error)  # type: ignore[misc]
def sonopack_tapped_row(t: float, y: Any, v: Any, user: Any, err: Any) -> int:
    watch: Watch = ffi.from_handle(user)
    if watch.row is not None:
        watch.row(t, y, v)
    return int(lib.SP_OK)
