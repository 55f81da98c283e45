"""Times, and the zones of the clocks that show them."""

from __future__ import annotations

from datetime import datetime, timezone, tzinfo
from typing import Any
from zoneinfo import ZoneInfo

import numpy as np
from numpy.typing import NDArray

_NAIVE = (
    "times: they have no time zone, and an hour could be that of any clock; give times with a zone, such as "
    "datetime(…, tzinfo=ZoneInfo(\"Europe/Berlin\")) or pandas.date_range(…, tz=\"Europe/Berlin\"), or their zone, such as "
    "tz=\"Europe/Berlin\""
)


def seconds_of(times: Any, tz: str | tzinfo | None = None) -> NDArray[np.float64]:
    """Return times as seconds after 1970, UTC. ``tz`` is the zone of the clock that shows them, if they have none."""
    if getattr(times, "tz", None) is not None:
        _refuse_second_zone(tz)
        times, tz = times.tz_convert("UTC").tz_localize(None), "UTC"
    array = np.asarray(times)
    if array.dtype.kind not in "MO":
        raise TypeError(f"times: datetime64 or datetimes are needed, not an array of {array.dtype}")
    if array.ndim != 1:
        raise ValueError(f"times: an array of shape (N,) is needed, not {array.shape}")
    if array.dtype.kind == "O":
        return np.array([_seconds(time, tz) for time in array], np.float64)
    if np.isnat(array).any():
        raise ValueError("times: NaT is no time; leave missing times out")
    if tz is None:
        raise ValueError(_NAIVE)
    moments = array.astype("datetime64[us]")
    zone = _zone(tz)
    if zone is timezone.utc:
        return moments.astype(np.int64) / 1e6
    return np.array([_seconds(time, zone) for time in moments.astype(object)], np.float64)


def _seconds(time: Any, tz: str | tzinfo | None) -> float:
    if not isinstance(time, datetime) or time != time:
        raise TypeError(f"times: datetimes are needed, not {time!r}")
    # The zones of pytz do not understand pandas.
    moment: datetime = time.to_pydatetime(warn=False) if hasattr(time, "to_pydatetime") else time
    try:
        if moment.tzinfo is not None:
            _refuse_second_zone(tz)
            _refuse_wrong_offset(moment)
            return moment.timestamp()
        if tz is None:
            raise ValueError(_NAIVE)
        zone = _zone(tz)
        first, second = (moment.replace(tzinfo=zone, fold=fold) for fold in (0, 1))
        _refuse_wrong_offset(first)
        if first.utcoffset() != second.utcoffset():
            raise ValueError(f"times: {time} exists twice on the clock of {zone}, which is changed then; {_WITH_OFFSET}")
        return first.timestamp()
    except OverflowError:
        raise ValueError(f"times: {time} is out of range; its year must be from 1 to 2999") from None


_WITH_OFFSET = "give such times with their offset, as datetime(…, tzinfo=timezone(timedelta(hours=…)))"


def _refuse_wrong_offset(time: datetime) -> None:
    """Reject a time that its clock never shows, and one with another offset than its zone has then."""
    zone: Any = time.tzinfo
    if isinstance(zone, timezone):
        return
    bare = time.replace(tzinfo=None, fold=0)
    shown = time.astimezone(timezone.utc).astimezone(zone).replace(tzinfo=None, fold=0)
    # A time of pytz holds an offset, which is wrong unless the zone gave it.
    is_of_zone = not hasattr(zone, "normalize") or zone.normalize(time).utcoffset() == time.utcoffset()
    if is_of_zone and shown != bare:
        raise ValueError(f"times: {bare} does not exist on the clock of {zone}, which is changed then; {_WITH_OFFSET}")
    if not is_of_zone:
        raise ValueError(
            f"times: {time} has an offset that {zone} does not have then; write zone.localize(datetime(…)) and "
            "zone.normalize(…), or use zoneinfo.ZoneInfo"
        )


def _refuse_second_zone(tz: Any) -> None:
    if tz is not None:
        raise ValueError("tz: the times have a zone already; leave tz out, or convert them")


def _zone(tz: str | tzinfo) -> tzinfo:
    if not isinstance(tz, str):
        # A zone of pytz cannot be attached to a time.
        name = getattr(tz, "zone", None)
        return _zone(name) if isinstance(name, str) else tz
    if tz.upper() == "UTC":
        return timezone.utc
    try:
        return ZoneInfo(tz)
    except (KeyError, ValueError, OSError) as error:
        remedy = "or no time zones are installed: pip install tzdata"
        raise ValueError(f"tz: {tz!r} is not an IANA name, such as \"Europe/Berlin\"; {remedy}") from error
