"""Where the sun is."""

from __future__ import annotations

from datetime import tzinfo
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._axes import Up, axis_of
from ._show import table
from ._times import seconds_of


class SunPath:
    """The sun's positions at a place and N times.

    Azimuths are degrees clockwise from true north, elevations are degrees above the horizon, both of the sun's centre, with the
    names of ``pvlib``. Positions are those of NREL's Solar Position Algorithm, to 0.0003 degrees in the centuries around ours.

        >>> import adumbra
        >>> from datetime import datetime, timezone
        >>> noon = datetime(2026, 6, 21, 11, 15, tzinfo=timezone.utc)
        >>> sun = adumbra.SunPath(lat=48.14, lon=11.58, times=[noon])
        >>> print(f"{sun.solar_azimuth[0]:.1f} {sun.apparent_elevation[0]:.1f}")
        179.7 65.3
    """

    def __init__(
        self,
        *,
        lat: float,
        lon: float,
        times: Any,
        tz: str | tzinfo | None = None,
        height: float = 0.0,
        refraction: bool = True,
        north_angle: float = 0.0,
    ) -> None:
        """Compute positions, on all cores.

        Args:
            lat: Latitude in degrees, -90 to 90, positive in the north.
            lon: Longitude in degrees, -180 to 180, positive in the east.
            times: A pandas ``DatetimeIndex`` with a zone, a list of ``datetime`` with zones, or NumPy ``datetime64`` of shape
                (N,) with ``tz``.
            tz: The zone of the clock that shows ``times``, if they have none themselves: an IANA name, or a ``tzinfo``.
            height: Metres above the sea, -500 to 9000.
            refraction: Whether the air bends light, as a standard atmosphere of 1013.25 hPa and 15 degrees Celsius does: by half a
                degree at the horizon.
            north_angle: Where true north is in the scene: degrees clockwise, as seen from above, from the scene's own north, which
                is -Z where Y points up, and +Y where Z points up.

        Raises:
            ValueError: Times have no zone, or do not exist on the clock or exist twice; a value is out of range; or the years are
                not within 1 to 2999.
            TypeError: The values are not times.
        """
        seconds = seconds_of(times, tz)
        place = (float(lat), float(lon), float(height))
        self._fill(seconds, *_native.sun_angles(place, seconds, bool(refraction)), north_angle)

    def _fill(
        self,
        seconds: NDArray[np.float64],
        azimuths: NDArray[np.float64],
        elevations: NDArray[np.float64],
        apparent: NDArray[np.float64],
        north_angle: float,
    ) -> None:
        if not np.isfinite(north_angle):
            raise ValueError(f"north_angle: {north_angle} is not a number of degrees")
        self._seconds = seconds
        self._angles = (azimuths, elevations, apparent)
        self._north_angle = float(north_angle)

    @classmethod
    def from_pvlib(cls, position: Any, *, north_angle: float = 0.0) -> SunPath:
        """Take the positions that ``pvlib.solarposition.get_solarposition`` returns.

        Args:
            position: A pandas ``DataFrame`` with the columns ``azimuth``, ``elevation`` and, if the air bends light,
                ``apparent_elevation``, and an index of times with a zone.
            north_angle: See :class:`SunPath`.

        Raises:
            ValueError: A column is missing or has numbers that are no angles in degrees, or the times have no zone.
        """
        columns = getattr(position, "columns", ())
        for name in ("azimuth", "elevation"):
            if name not in columns:
                raise ValueError(f"position: there is no column {name!r}; give what pvlib's get_solarposition returns")
        names = ("azimuth", "elevation", "apparent_elevation" if "apparent_elevation" in columns else "elevation")
        azimuths, elevations, apparent = (np.array(position[name], np.float64) for name in names)
        for name, values in zip(names, (azimuths, elevations, apparent), strict=True):
            if not (np.abs(values) <= (360.0 if name == "azimuth" else 90.0)).all():
                raise ValueError(f"position: the column {name!r} has numbers that are no angles in degrees; leave those times out")
        if getattr(position.index, "tz", None) is None:
            raise ValueError("position: its times have no time zone; give pvlib times with one, such as times.tz_localize(\"UTC\")")
        path = cls.__new__(cls)
        path._fill(seconds_of(position.index), azimuths, elevations, apparent, north_angle)
        return path

    @property
    def times(self) -> NDArray[np.datetime64]:
        """The times, UTC, shape (N,)."""
        return (self._seconds * 1e6).round().astype(np.int64).astype("datetime64[us]")

    @property
    def solar_azimuth(self) -> NDArray[np.float64]:
        """Degrees clockwise from true north, 0 to 360, shape (N,). It cannot be written to, like the other angles."""
        return _read_only(self._angles[0])

    @property
    def elevation(self) -> NDArray[np.float64]:
        """Degrees above the horizon, negative below it, as if there were no air, shape (N,)."""
        return _read_only(self._angles[1])

    @property
    def apparent_elevation(self) -> NDArray[np.float64]:
        """Degrees above the horizon as one sees the sun, shape (N,). Without refraction, the same as :attr:`elevation`."""
        return _read_only(self._angles[2])

    @property
    def is_up(self) -> NDArray[np.bool_]:
        """Whether the centre of the sun is seen above the horizon of a plain, shape (N,)."""
        return self._angles[2] > 0.0

    @property
    def north_angle(self) -> float:
        """Where true north is in the scene, see :class:`SunPath`."""
        return self._north_angle

    def to_sun(self, up: Up) -> NDArray[np.float64]:
        """Return the unit vectors towards the sun, shape (N, 3), in a scene in which ``up`` points up, see :attr:`Scene.up`.

        Raises:
            ValueError: ``up`` is not an axis.
        """
        return directions(self._angles[0] + self._north_angle, self._angles[2], up)

    def __getitem__(self, index: slice | NDArray[Any] | list[int]) -> SunPath:
        """Return the path at some of its times: a slice, a mask of N booleans or an array of numbers.

        Raises:
            TypeError: The index is of another kind. The direction at one time is ``sun.to_sun(up)[number]``.
            IndexError: A number is out of range, or a mask has another length.
        """
        if isinstance(index, tuple) or (not isinstance(index, slice) and np.ndim(index) != 1):
            raise TypeError("a sun path is not an array: give a slice or an array, or take one direction, sun.to_sun(up)[number]")
        path = SunPath.__new__(SunPath)
        azimuths, elevations, apparent = (angles[index].copy() for angles in self._angles)
        path._fill(self._seconds[index].copy(), azimuths, elevations, apparent, self._north_angle)
        return path

    __iter__ = None

    def __len__(self) -> int:
        return len(self._seconds)

    def __repr__(self) -> str:
        return f"<adumbra.SunPath of {len(self)} times, {int(self.is_up.sum())} of them by day>"

    def _repr_html_(self) -> str:
        rows = [("times", f"{len(self):,}"), ("by day", f"{int(self.is_up.sum()):,}")]
        if len(self):
            times = self.times.astype("datetime64[s]")
            rows += [("from", f"{times.min()} UTC"), ("to", f"{times.max()} UTC")]
            rows += [("highest", f"{self.apparent_elevation.max():.2f}°")]
        return table("adumbra.SunPath", rows)


def _read_only(angles: NDArray[np.float64]) -> NDArray[np.float64]:
    view = angles.view()
    view.flags.writeable = False
    return view


def sun_direction(azimuth: ArrayLike, elevation: ArrayLike, *, up: Up) -> NDArray[np.float64]:
    """Return unit vectors towards suns at these compass angles.

    Args:
        azimuth: Degrees clockwise from the scene's north as seen from above, of any shape. North is -Z where Y points up, and +Y
            where Z points up; 90 is +X.
        elevation: Degrees above the horizon, -90 to 90, of a compatible shape.
        up: The axis that points up in the scene: ``"y"`` or ``"z"``, see :attr:`Scene.up`.

    Returns:
        An array of float64 with one more axis of length 3. Two numbers give an array of shape (3,).

    Raises:
        ValueError: An angle is not finite, an elevation is out of its range, or ``up`` is not an axis.

    Example:
        >>> import adumbra
        >>> adumbra.sun_direction([0, 90], [90, 0], up="z").round(3).tolist()
        [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]
    """
    azimuths, elevations = np.broadcast_arrays(
        np.asarray(azimuth, np.float64), np.asarray(elevation, np.float64)
    )
    if not np.isfinite(azimuths).all():
        raise ValueError("azimuth: an angle is not finite")
    if not (np.abs(elevations) <= 90.0).all():
        raise ValueError("elevation: an angle is out of range; it must be from -90 to 90")
    return directions(azimuths.ravel(), elevations.ravel(), up).reshape((*azimuths.shape, 3))


def directions(
    azimuths: NDArray[np.float64], elevations: NDArray[np.float64], up: Any
) -> NDArray[np.float64]:
    """Return unit vectors towards suns."""
    azimuths, elevations = (np.require(angles, np.float64, ["C", "A"]) for angles in (azimuths, elevations))
    return _native.sun_directions(azimuths, elevations, axis_of(up))
