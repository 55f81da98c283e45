"""Checks of arrays that users pass."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray


def triples(name: str, values: ArrayLike, *, double: bool = False) -> NDArray[Any]:
    """Return ``values`` as a contiguous array of N x 3 floats. Keep single precision unless ``double``."""
    if np.ma.is_masked(values):
        raise ValueError(f"{name}: some values are masked; leave those rows out")
    array = np.asarray(values)
    if array.dtype.kind not in "iuf":
        raise TypeError(f"{name}: real numbers are needed, not an array of {array.dtype}")
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"{name}: an array of shape (N, 3) is needed, not {array.shape}")
    single = array.dtype.kind == "f" and array.dtype.itemsize == 4 and not double
    return np.require(array, np.float32 if single else np.float64, ["C", "A"])


def numbers(name: str, values: ArrayLike, count: int) -> tuple[float, ...]:
    """Return ``count`` numbers as floats."""
    array = np.asarray(values)
    if array.dtype.kind not in "iuf":
        raise TypeError(f"{name}: {count} numbers are needed, not an array of {array.dtype}")
    if array.shape != (count,):
        raise ValueError(f"{name}: {count} numbers are needed, not an array of shape {array.shape}")
    return tuple(float(value) for value in array)


def same_length(points: NDArray[Any], normals: NDArray[Any] | None) -> None:
    """Reject normals unless there is one for each point."""
    if normals is not None and len(normals) != len(points):
        raise ValueError(f"normals: {len(normals)} rows for {len(points)} points; give one for each point")


def whole(name: str, value: int, least: int, most: int) -> int:
    """Return a whole number within its range."""
    try:
        number = value.__index__()
    except AttributeError:
        raise TypeError(f"{name}: a whole number is needed, not {value!r}") from None
    if not least <= number <= most:
        raise ValueError(f"{name}: {number} is out of range; it must be from {least} to {most}")
    return number
