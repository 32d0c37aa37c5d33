"""The three ways in which reading and writing other programs' files fail."""
from __future__ import annotations

from .._core import FileError, InvalidInput, Refused, Status


def bad_file(text: str) -> InvalidInput:
    """A file says something wrong, or is cut."""
    return InvalidInput(text, Status.EFORMAT)


def bad_option(text: str, key: str = "") -> InvalidInput:
    """Options contradict each other or the file; key: the one at fault, with which the text then begins."""
    return InvalidInput(f"{key}{text}", Status.EINVAL, key)


def refused(text: str) -> Refused:
    """Digits are too few, or forces contradict overlaps."""
    return Refused(text, Status.EREFUSED)


def unreadable(path: str, fault: OSError) -> FileError:
    return FileError(f"{path}: cannot be opened: {fault.strerror or fault}", Status.EIO)
