"""Checks of arrays that users pass."""

from __future__ import annotations

from typing import Any, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray


def plain(name: str, values: ArrayLike) -> NDArray[Any]:
    """Return ``values`` as an array, of which no value is masked."""
    if np.ma.is_masked(values):
        raise ValueError(f"{name}: some values are masked; leave those rows out")
    return np.asarray(values)


def triples(name: str, values: ArrayLike, *, double: bool = False) -> NDArray[Any]:
    """Return ``values`` as a contiguous array of N x 3 floats. Keep single precision unless ``double``."""
    array = plain(name, values)
    if array.dtype.kind not in "iuf":
        raise TypeError(f"{name}: real numbers are needed, not an array of {array.dtype}")
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"{name}: an array of shape (N, 3) is needed, not {array.shape}")
    single = array.dtype.kind == "f" and array.dtype.itemsize == 4 and not double
    return np.require(array, np.float32 if single else np.float64, ["C", "A"])


def numbers(name: str, values: ArrayLike, count: int) -> tuple[float, ...]:
    """Return ``count`` numbers as floats."""
    array = plain(name, values)
    if array.dtype.kind not in "iuf":
        raise TypeError(f"{name}: {count} numbers are needed, not an array of {array.dtype}")
    if array.shape != (count,):
        raise ValueError(f"{name}: {count} numbers are needed, not an array of shape {array.shape}")
    return tuple(float(value) for value in array)


Places = tuple[NDArray[Any], Union[NDArray[Any], None]]
"""Points, and the normals of the surfaces that they are on, if these are known."""


def places_of(points: ArrayLike, normals: ArrayLike | None) -> Places:
    """Return points and normals as contiguous arrays, with one normal for each point."""
    places = triples("points", points)
    if normals is None:
        return places, None
    upright = triples("normals", normals)
    if len(upright) != len(places):
        raise ValueError(f"normals: {len(upright)} rows for {len(places)} points; give one for each point")
    return places, upright


def origins_of(points: ArrayLike, normals: ArrayLike | None, lift: float) -> tuple[Places, float]:
    """Return points and normals, and how far from the points rays start."""
    if not np.isfinite(lift):
        raise ValueError(f"lift: {lift} is out of range; it must be finite")
    return places_of(points, normals), float(lift)


def whole(name: str, value: int, least: int, most: int) -> int:
    """Return a whole number within its range."""
    try:
        number = value.__index__()
    except AttributeError:
        raise TypeError(f"{name}: a whole number is needed, not {value!r}") from None
    if not least <= number <= most:
        raise ValueError(f"{name}: {number} is out of range; it must be from {least} to {most}")
    return number


def threads_of(threads: int | None) -> int | None:
    """Return a number of threads within its range."""
    return None if threads is None else whole("threads", threads, 1, 1024)
