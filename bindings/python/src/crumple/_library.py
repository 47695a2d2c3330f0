"""Loads the shared library that the wheel contains, and turns results into exceptions."""

import ctypes
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from . import _native as native

BINARIES = Path(__file__).parent / "_bin"
"""The folder of the wheel's shared library and command."""

_NAMES = {"win32": "crumple.dll", "darwin": "libcrumple.dylib"}


class CrumpleError(Exception):
    """A call of the library failed. The text is the library's own message: it names the wrong value and what would be right.

    A failed call changes nothing, and everything stays usable.
    """

    def __init__(self, message: str, result: native.CrumpleResult) -> None:
        super().__init__(message)
        self.result = result
        """Why it failed, such as ``Result.ERROR_MESH``."""


def _load() -> Any:
    path = os.environ.get("CRUMPLE_LIBRARY") or str(BINARIES / _NAMES.get(sys.platform, "libcrumple.so"))
    try:
        library = ctypes.CDLL(path)
        native.declare(library)
    except OSError as error:
        raise ImportError(f"the Crumple library {path} cannot be loaded: {error}") from error
    except AttributeError as error:
        raise ImportError(f"{path} is no Crumple library of version {_version(native.VERSION)}: {error}") from error
    if library.crumple_version() // 1000 != native.VERSION // 1000:
        text = library.crumple_version_string().decode()
        raise ImportError(f"{path} has version {text}; this package needs {_version(native.VERSION)}")
    return library


def _version(number: int) -> str:
    return f"{number // 1000000}.{number // 1000 % 1000}.{number % 1000}"


library = _load()


def check(code: int) -> None:
    """Raises the library's message unless the call succeeded."""
    if code != native.CrumpleResult.OK:
        raise CrumpleError(library.crumple_last_error().decode(), native.CrumpleResult(code))


def needed(call: Callable[..., int], *arguments: Any, size: Any) -> int:
    """Asks a call that fills an array how many elements it has. `size` is the number that the call writes."""
    code = call(*arguments, None, 0, ctypes.byref(size))
    if code != native.CrumpleResult.ERROR_BUFFER_TOO_SMALL:
        check(code)
    return size.value


def filled(call: Callable[..., int], *arguments: Any) -> bytes:
    """The bytes that a call writes."""
    size = ctypes.c_size_t()
    data = ctypes.create_string_buffer(needed(call, *arguments, size=size))
    check(call(*arguments, data, len(data), ctypes.byref(size)))
    return data.raw[: size.value]
