"""Files of a moving sun."""

from __future__ import annotations

import os
from datetime import tzinfo
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._arrays import places_of, threads_of, whole
from ._axes import Up, Vector
from ._bake import DEFAULT_RESOLUTION, options_of
from ._loading import LoadOptions
from ._scene import SceneLike, scene_of
from ._sunlight import day_of
from ._times import seconds_of

if TYPE_CHECKING:
    from typing_extensions import Unpack


class SunPathFile:
    """The suns of a day, and which points see the sun at any moment of it. :func:`bake_path` and :meth:`open` return one.

    All coordinates are those of the scene, in which :attr:`up` points up. It never changes, may be used from any number of threads,
    and can be pickled.
    """

    def __init__(self, native: _native.Path) -> None:
        self._native = native

    @classmethod
    def open(cls, source: str | os.PathLike[str] | bytes | bytearray | memoryview) -> SunPathFile:
        """Read a sun path from its file, or from the file's bytes.

        Raises:
            OSError: The file cannot be read.
            FormatError: It is not a valid sun path.
        """
        if isinstance(source, (bytes, bytearray, memoryview)):
            return cls(_native.Path.from_bytes(bytes(source)))
        return cls(_native.Path.read(os.fspath(source)))

    def to_bytes(self) -> bytes:
        """Return the bytes that :meth:`save` writes."""
        return self._native.to_bytes()

    def save(self, path: str | os.PathLike[str]) -> int:
        """Write the file, and return its length in bytes. An earlier file is replaced as a whole."""
        return self._native.write(os.fspath(path))

    @property
    def up(self) -> Up:
        """The axis that points up: ``"y"`` or ``"z"``."""
        return self._native.up

    @property
    def keys(self) -> NDArray[np.datetime64]:
        """The moments of the keys, UTC, shape (K,)."""
        return np.array(self._native.keys).astype("datetime64[s]")

    def sun_at(self, time: Any, *, tz: str | tzinfo | None = None) -> Vector | None:
        """Return the unit vector towards the sun at a moment, or ``None`` at night and outside the path.

        Args:
            time: A ``datetime``, a pandas ``Timestamp`` or a ``datetime64``.
            tz: The zone of the clock that shows ``time``, if it has none itself, see :class:`SunPath`.

        Raises:
            ValueError: The time has no zone, or does not exist on the clock or exists twice.
        """
        found = self._native.sun_at(_moment(time, tz))
        return None if found is None else (found[0], found[1], found[2])

    def visibility(
        self,
        points: ArrayLike,
        time: Any,
        normals: ArrayLike | None = None,
        filter: int = 5,
        *,
        tz: str | tzinfo | None = None,
        quick: bool = False,
        threads: int | None = None,
    ) -> NDArray[np.float32]:
        """Look up which points see the sun at a moment, as ``adumbra query --time`` does.

        Runs on all cores; other Python threads run meanwhile.

        Args:
            points: Positions, shape (N, 3), of any real type.
            time: A moment of the path, see :meth:`sun_at`. At night no point sees the sun.
            normals: Unit normals of the surfaces that the points are on, shape (N, 3).
            filter: Texels along the side of the square whose mean is returned: 1, 3, 5, 9 or 17.
            tz: See :meth:`sun_at`.
            quick: March only where the two keys' own answers differ, which is less exact.
            threads: Number of threads, 1 to 1024. All cores unless it is given.

        Returns:
            Visibilities, shape (N,), float32: 1 sees the sun, 0 does not.

        Raises:
            ValueError: The moment is not on the path or has no zone, or a shape or the filter is out of range.
        """
        places = places_of(points, normals)
        seconds = _moment(time, tz)
        first, last = self._native.span
        if not first <= seconds <= last:
            raise ValueError(f"time: {time} is not on the path; give a moment of its day")
        width = whole("filter", filter, 0, 2**32 - 1)
        return self._native.visibility(places, seconds, width, bool(quick), threads_of(threads))

    def __reduce__(self) -> tuple[Any, ...]:
        return SunPathFile.open, (self.to_bytes(),)

    def __repr__(self) -> str:
        return f"<adumbra.SunPathFile of {len(self._native.keys)} keys>"


def bake_path(
    scene: SceneLike,
    *,
    lat: float,
    lon: float,
    date: object,
    from_: object,
    to: object,
    tz: str | None = None,
    step: int = 60,
    path_error: float = 0.1,
    lowest_sun: float = 3.0,
    resolution: int = DEFAULT_RESOLUTION,
    threads: int | None = None,
    **loading: Unpack[LoadOptions],
) -> SunPathFile:
    """Bake the path of a sun, as ``adumbra bake --sun-path`` does. Ctrl-C stops it.

    Args:
        scene: A :class:`Scene`, or the path of its file. North is -Z where Y points up, and +Y where Z points up.
        lat: See :func:`sun_hours`.
        lon: See :func:`sun_hours`.
        date: See :func:`sun_hours`.
        from_: See :func:`sun_hours`.
        to: See :func:`sun_hours`.
        tz: See :func:`sun_hours`.
        step: Seconds between suns, 1 to 86,400.
        path_error: Percent of the visible points, above 0 to 100, that may be wrong half way between two keys.
        lowest_sun: The least elevation of a key in degrees, 0.5 to below 90.
        resolution: See :func:`bake`.
        threads: Number of threads, 1 to 1024. All cores unless it is given.
        **loading: Options for a scene that is given by its path, see :class:`LoadOptions`.

    Raises:
        ValueError: A value is out of range, or the sun is never high enough.
        OSError: The scene cannot be read.
    """
    if not 0.0 < path_error <= 100.0:
        raise ValueError(f"path_error: {path_error} is out of range; it must be above 0 and at most 100")
    if not 0.5 <= lowest_sun < 90.0:
        raise ValueError(f"lowest_sun: {lowest_sun} is out of range; it must be from 0.5 to below 90")
    day = day_of(lat, lon, date, from_, to, tz, step)
    loaded = scene_of(scene, dict(loading))
    # Each key has its own sun, so this elevation has no effect.
    options = options_of(loaded, elevation=45.0, resolution=resolution)
    limits = float(path_error), float(lowest_sun)
    return SunPathFile(_native.Path.bake(loaded._native, day, options, limits, threads_of(threads)))


def _moment(time: Any, tz: str | tzinfo | None) -> float:
    return float(seconds_of(np.array([time]) if isinstance(time, np.datetime64) else [time], tz)[0])
