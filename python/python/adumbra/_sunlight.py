"""Hours of sun, and the visible sky."""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._arrays import origins_of, threads_of, whole
from ._loading import LoadOptions
from ._progress import Progress, reporting
from ._scene import SceneLike, scene_of

if TYPE_CHECKING:
    from typing_extensions import Unpack


@dataclass(frozen=True)
class SunHours:
    """When N points see the sun in a span of a day. The spans of all points are in one list, in the order of the points."""

    hours: NDArray[np.float64]
    """How long each point sees the sun, hours, shape (N,)."""
    span_points: NDArray[np.int64]
    """The point of each span, shape (S,)."""
    span_starts: NDArray[np.datetime64]
    """When each span begins, UTC, milliseconds, shape (S,)."""
    span_ends: NDArray[np.datetime64]
    """When each span ends, UTC, milliseconds, shape (S,)."""
    time_zone: str
    """The zone of the clock: an IANA name, or an offset such as ``+01:00``."""

    def intervals(self) -> Any:
        """Return the spans as a pandas ``DataFrame``: ``point``, and ``start`` and ``end`` with the clock's time zone.

        Raises:
            ImportError: pandas is not installed.
        """
        pandas = importlib.import_module("pandas")
        local = {
            name: pandas.DatetimeIndex(times).tz_localize("UTC").tz_convert(self.time_zone)
            for name, times in (("start", self.span_starts), ("end", self.span_ends))
        }
        return pandas.DataFrame({"point": self.span_points, **local})


@dataclass(frozen=True)
class Skies:
    """Which patches of the sky N points see."""

    patches: NDArray[np.bool_]
    """Whether the middle of each patch is seen, shape (N, 145) or (N, 577): rows of patches from the horizon up, each
    clockwise from north, and the zenith."""
    sky_view_factor: NDArray[np.float64]
    """Share of an evenly bright sky's light that arrives, shape (N,): 1 on an open plain."""
    shade_fraction: NDArray[np.float64]
    """Share of the sky's solid angle that is hidden, shape (N,): 0 on an open plain."""


def sun_hours(
    scene: SceneLike,
    points: ArrayLike,
    normals: ArrayLike | None = None,
    *,
    lat: float,
    lon: float,
    date: object,
    from_: object,
    to: object,
    tz: str | None = None,
    height: float = 0.0,
    refraction: bool = True,
    lift: float = 1e-3,
    threads: int | None = None,
    progress: Progress = None,
    **loading: Unpack[LoadOptions],
) -> SunHours:
    """Trace when points see the sun in a span of a day, as ``adumbra sun-hours`` does.

    Spans are exact to a tenth of a second for the centre of the sun, and none is missed, however short, except through the holes
    of alpha masks, which are looked at each second.

    Runs on all cores; other Python threads run meanwhile. Ctrl-C stops it.

    Args:
        scene: A :class:`Scene`, or the path of its file. North is -Z where Y points up, and +Y where Z points up.
        points: Positions, shape (N, 3), of any real type.
        normals: Unit normals of the surfaces that the points are on, shape (N, 3): a point is dark if the sun
            is behind its surface. Without normals, points are in space.
        lat: Latitude in degrees, -90 to 90, positive in the north.
        lon: Longitude in degrees, -180 to 180, positive in the east.
        date: The day on which the span begins: ``"2026-06-21"`` or a ``datetime.date``.
        from_: Start by the local clock, such as ``7`` or ``"07:30"``.
        to: End by the local clock; 24 is the end of the day. An end before the start is on the next day.
        tz: The clock's zone: an IANA name, or an offset such as ``"+01:00"``. Without it, the whole hour nearest to the
            longitude.
        height: Metres above the sea, -500 to 9000.
        refraction: Whether the air bends light.
        lift: Distance along the normals at which rays start, in world units, finite.
        threads: Number of threads, 1 to 1024. All cores unless it is given.
        progress: As that of :func:`bake`, for blocks of points.
        **loading: Options for a scene that is given by its path, see :class:`LoadOptions`.

    Raises:
        ValueError: A value or a shape is out of range.
        TypeError: An array does not hold real numbers.
        OSError: The scene cannot be read.
    """
    origins = origins_of(points, normals, lift)
    day = day_of(lat, lon, date, from_, to, tz, height=height, refraction=refraction)
    loaded = scene_of(scene, dict(loading))
    with reporting(progress, "block") as report:
        hours, of_points, starts, ends, zone = _native.sun_hours(
            loaded._native, origins, day, threads_of(threads), report
        )
    moments = [(1000.0 * times).round().astype("datetime64[ms]") for times in (starts, ends)]
    return SunHours(hours, of_points, moments[0], moments[1], zone)


def sky(
    scene: SceneLike,
    points: ArrayLike,
    normals: ArrayLike | None = None,
    *,
    patches: Literal["tregenza", "reinhart"] = "tregenza",
    lift: float = 1e-3,
    threads: int | None = None,
    progress: Progress = None,
    **loading: Unpack[LoadOptions],
) -> Skies:
    """Trace which patches of the sky points see, as ``adumbra sky`` does.

    Runs on all cores; other Python threads run meanwhile. Ctrl-C stops it.

    Args:
        scene: A :class:`Scene`, or the path of its file. North is -Z where Y points up, and +Y where Z points up.
        points: Positions, shape (N, 3), of any real type.
        normals: Unit normals of the surfaces that the points are on, shape (N, 3). Without them, points measure light as a
            level surface does.
        patches: ``"tregenza"``: 145 patches. ``"reinhart"``: 577.
        lift: Distance along the normals at which rays start, in world units, finite.
        threads: Number of threads, 1 to 1024. All cores unless it is given.
        progress: As that of :func:`bake`, for blocks of points.
        **loading: Options for a scene that is given by its path, see :class:`LoadOptions`.

    Raises:
        ValueError: A value or a shape is out of range.
        TypeError: An array does not hold real numbers.
        OSError: The scene cannot be read.
    """
    if patches not in ("tregenza", "reinhart"):
        raise ValueError(f'patches: {patches!r} must be "tregenza" or "reinhart"')
    origins = origins_of(points, normals, lift)
    loaded = scene_of(scene, dict(loading))
    with reporting(progress, "block") as report:
        found = _native.sky(loaded._native, origins, patches == "reinhart", threads_of(threads), report)
    return Skies(*found)


def day_of(
    lat: float,
    lon: float,
    date: object,
    from_: object,
    to: object,
    tz: str | None,
    step: int = 60,
    height: float = 0.0,
    refraction: bool = True,
) -> str:
    """Return a span of a day as the program's ``--sun-path`` takes it."""
    words = {"lat": float(lat), "lon": float(lon), "date": date, "from": from_, "to": to, "height": float(height)}
    words |= {"step": whole("step", step, 1, 86_400), "refraction": "on" if refraction else "off"}
    words |= {} if tz is None else {"tz": tz}
    return ",".join(f"{key}={value}" for key, value in words.items())
