"""numpy arrays as the library's inputs and streams."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from . import _native as native

Vector = ArrayLike
"""Three numbers."""


def elements(values: ArrayLike, name: str, components: int, dtype: DTypeLike = np.float32) -> NDArray[Any]:
    """`values` as rows of `components` numbers. Copies only if the type or the order inside a row differs."""
    array = np.asarray(values, dtype)
    if components > 1 and array.ndim == 1 and array.size == 0:
        array = array.reshape(0, components)
    shape = f"(n, {components})" if components > 1 else "(n,)"
    if array.ndim != (2 if components > 1 else 1) or (components > 1 and array.shape[1] != components):
        raise ValueError(f"{name} has the shape {array.shape}; it must be {shape}")
    packed = components == 1 or array.strides[1] == array.itemsize
    return array if packed and array.strides[0] > 0 else np.ascontiguousarray(array)


def given(array: NDArray[Any] | None) -> native.CrumpleInput:
    """An array that the library reads. The caller keeps the array alive during the call."""
    if array is None or array.size == 0:
        return native.CrumpleInput()
    return native.CrumpleInput(array.ctypes.data, _reach(array), array.strides[0])


def stream(
    array: NDArray[Any] | None, name: str, count: int, components: int, dtype: type[np.generic] = np.float32
) -> native.CrumpleStream:
    """Memory that the library writes. It is never a copy, so an array that does not fit is an error."""
    if array is None:
        return native.CrumpleStream()
    if not isinstance(array, np.ndarray) or array.dtype != dtype:
        kind = array.dtype if isinstance(array, np.ndarray) else type(array).__name__
        raise TypeError(f"{name} is {kind}; it must be a numpy array of {dtype.__name__}, since Crumple writes into it")
    if array.shape != (count, components):
        raise ValueError(f"{name} has the shape {array.shape}; it must be ({count}, {components})")
    if not array.flags.writeable or array.strides[1] != array.itemsize or array.strides[0] < components * array.itemsize:
        raise ValueError(f"{name} must be writable, with the {components} numbers of a vertex beside each other")
    return native.CrumpleStream(array.ctypes.data, _reach(array), 0, array.strides[0])


def directions(array: NDArray[Any] | None, name: str, count: int, floats: int) -> tuple[native.CrumpleStream, int]:
    """Memory for normals or tangents, and their CrumpleDirectionFormat: octahedral for uint16."""
    if isinstance(array, np.ndarray) and array.dtype == np.uint16:
        return stream(array, name, count, 2, np.uint16), native.CrumpleDirectionFormat.OCTAHEDRAL
    return stream(array, name, count, floats), native.CrumpleDirectionFormat.FLOAT


def _reach(array: NDArray[Any]) -> int:
    """Bytes from the first element to the end of the last."""
    inside = array.itemsize * (array.shape[1] if array.ndim == 2 else 1)
    return (len(array) - 1) * array.strides[0] + inside


def vector(values: Vector, name: str) -> native.CrumpleVec3:
    array = np.asarray(values, np.float32)
    if array.shape != (3,):
        raise ValueError(f"{name} has the shape {array.shape}; it must be three numbers")
    return native.CrumpleVec3(*array.tolist())


def matrix(values: ArrayLike) -> NDArray[np.float32]:
    """A 4 x 4 matrix that transforms columns, as the 16 floats of a column-major matrix."""
    array = np.asarray(values, np.float32)
    if array.shape != (4, 4):
        raise ValueError(f"the transform has the shape {array.shape}; it must be (4, 4)")
    return np.ascontiguousarray(array.T).reshape(16)


def vector3(value: native.CrumpleVec3) -> NDArray[np.float32]:
    return np.array((value.x, value.y, value.z), np.float32)
