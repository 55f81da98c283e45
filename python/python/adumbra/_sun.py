"""Directions towards the sun."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._arrays import numbers
from ._scene import Scene


def sun_direction(azimuth: ArrayLike, elevation: ArrayLike) -> NDArray[np.float64]:
    """Return unit vectors towards suns at these compass angles.

    Args:
        azimuth: Degrees clockwise from -Z as seen from above, of any shape: 90 is +X. If -Z is north, that is the azimuth of
            almanacs and of libraries such as ``astral`` and ``pvlib``.
        elevation: Degrees above the horizon, above 0 and at most 90, of a compatible shape.

    Returns:
        An array of float64 with one more axis of length 3. Two numbers give an array of shape (3,).

    Raises:
        ValueError: An angle is not finite, or an elevation is out of its range. Leave out the hours of night.
    """
    azimuths, elevations = np.broadcast_arrays(
        np.asarray(azimuth, np.float64), np.asarray(elevation, np.float64)
    )
    suns = [
        _native.sun_from_angles(float(a), float(e)) for a, e in zip(azimuths.flat, elevations.flat, strict=True)
    ]
    return np.array(suns, np.float64).reshape((*azimuths.shape, 3))


def choose_sun(
    scene: Scene, sun: ArrayLike | None, azimuth: float | None, elevation: float | None
) -> tuple[float, ...]:
    """Return the given direction towards the sun, or else that of the scene."""
    if sun is not None:
        if azimuth is not None or elevation is not None:
            raise ValueError("sun: give a direction or angles, not both")
        return numbers("sun", sun, 3)
    if elevation is not None:
        return tuple(float(c) for c in sun_direction(0.0 if azimuth is None else azimuth, elevation))
    if azimuth is not None:
        raise ValueError("azimuth: give an elevation too")
    return scene.sun
