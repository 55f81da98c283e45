"""Rays."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._arrays import numbers, same_length, triples
from ._scene import LoadOptions, Scene, SceneLike, scene_of

if TYPE_CHECKING:
    from typing_extensions import Unpack


def rays(scene: SceneLike | ArrayLike, faces: ArrayLike | None = None, **loading: Unpack[LoadOptions]) -> Rays:
    """Prepare a scene for rays.

    Args:
        scene: The path of a scene, a :class:`Scene`, or vertices of shape (N, 3).
        faces: The vertices of each triangle, shape (M, 3), if vertices are given.
        **loading: Options for a scene that is given by its path, see :class:`LoadOptions`.

    Returns:
        The scene, ready for rays. That takes about 2 microseconds per triangle.

    Raises:
        OSError: The scene cannot be read.
        FormatError: The scene is broken.
        ValueError: Vertices or faces are out of range.
    """
    return Rays(scene_of(scene, faces, dict(loading)))


class Rays:
    """A scene that is ready for rays; :func:`rays` makes one. It may be used from any number of threads."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._native = _native.Rays(scene._native)

    @property
    def scene(self) -> Scene:
        """The scene."""
        return self._scene

    def visibility(
        self,
        points: ArrayLike,
        suns: ArrayLike,
        normals: ArrayLike | None = None,
        *,
        lift: float = 1e-3,
    ) -> NDArray[np.float32]:
        """Trace a ray from each point to each sun.

        Runs on all cores, at about a microsecond per ray and core; other Python threads run meanwhile. Ctrl-C stops it.

        Args:
            points: Positions in world space, shape (N, 3), of any real type. A point that is not finite is lit.
            suns: Directions towards the suns, shape (K, 3), or of one sun, shape (3,), of any length. They may point below the
                horizon. :func:`sun_direction` computes them from angles.
            normals: Unit normals of the surfaces that the points are on, shape (N, 3). Give them for points on surfaces: their
                rays start ``lift`` above. Rays from points without normals start at the points.
            lift: Distance along the normals, in world units, finite. A surface that is nearer than this above
                a point does not shadow it.

        Returns:
            Visibilities, shape (N, K), or (N,) for one sun, float32: 1 sees the sun, 0 does not.

        Raises:
            ValueError: A shape is wrong, a sun is not finite or has no length, or the lift is not finite.
            TypeError: An array does not hold real numbers.
        """
        places = triples("points", points)
        upright = None if normals is None else triples("normals", normals)
        same_length(places, upright)
        directions = np.asarray(suns)
        one = directions.ndim == 1
        towards = triples("suns", directions[np.newaxis] if one else directions, double=True)
        wrong = ~(np.isfinite(towards).all(axis=1) & (towards != 0).any(axis=1))
        if wrong.any():
            row = int(np.argmax(wrong))
            raise ValueError(f"suns[{row}] is {towards[row]}, which is not a direction; give finite numbers, not all 0")
        if not np.isfinite(lift):
            raise ValueError(f"lift: {lift} is out of range; it must be finite")
        found = self._native.visibility(places, towards, upright, float(lift))
        return found[:, 0] if one else found

    def nearest(
        self, points: ArrayLike, direction: ArrayLike
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Find the nearest surface from each point in one direction.

        Rays straight down from above the scene find the points of a map and their normals.

        Args:
            points: Positions in world space, shape (N, 3), of any real type.
            direction: The direction, three numbers, of any length.

        Returns:
            The distances, shape (N,), in lengths of the direction, and infinite where there is no surface. The unit normals
            on the side that the ray comes from, shape (N, 3), and 0 where there is no surface.

        Raises:
            ValueError: A shape is wrong, or the direction is not finite or has no length.
            TypeError: An array does not hold real numbers.
        """
        along = numbers("direction", direction, 3)
        if not np.isfinite(along).all() or not any(along):
            raise ValueError(f"direction: {along} is not a direction; give finite numbers, not all 0")
        return self._native.nearest(triples("points", points), along)

    def __repr__(self) -> str:
        return f"<adumbra.Rays through {self._scene.triangles} triangles>"
