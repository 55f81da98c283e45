"""Where the sun is: published positions, those of pvlib, and times with their zones."""

from __future__ import annotations

import pickle
from datetime import datetime, timedelta, timezone, tzinfo
from typing import Any
from zoneinfo import ZoneInfo

import numpy as np
import pytest
from numpy.typing import NDArray

import adumbra

MUNICH: Any = {"lat": 48.14, "lon": 11.58}
REMEDY = 'they have no time zone, .* give times with a zone, such as .*tz="Europe/Berlin"'


def by_minutes(*texts: str) -> NDArray[np.datetime64]:
    """Return times without a zone."""
    return np.array(texts, "datetime64[m]")


def turn(azimuths: Any, others: Any) -> NDArray[np.float64]:
    """Return the degrees between azimuths."""
    degrees: NDArray[np.float64] = np.abs((np.asarray(azimuths) - np.asarray(others) + 180) % 360 - 180)
    return degrees


def test_positions_match_the_worked_example_of_nrel() -> None:
    """The example of NREL/TP-560-34302, appendix A.5. Its zenith of 50.11162 degrees is with another atmosphere's refraction."""
    time = datetime(2003, 10, 17, 12, 30, 30, tzinfo=timezone(timedelta(hours=-7)))
    sun = adumbra.SunPath(lat=39.742476, lon=-105.1786, times=[time], height=1830.14)
    assert sun.solar_azimuth[0] == pytest.approx(194.340241, abs=0.0003)
    assert sun.elevation[0] == pytest.approx(39.872046, abs=0.0003)
    assert 0.01 < sun.apparent_elevation[0] - sun.elevation[0] < 0.03
    assert sun.times.tolist() == [datetime(2003, 10, 17, 19, 30, 30)]
    azimuth, elevation = np.radians([194.340241, 39.872046])
    east, north, up = np.cos(elevation) * np.sin(azimuth), np.cos(elevation) * np.cos(azimuth), np.sin(elevation)
    bare = adumbra.SunPath(lat=39.742476, lon=-105.1786, times=[time], height=1830.14, refraction=False)
    assert bare.to_sun("z")[0] == pytest.approx([east, north, up], abs=1e-5)
    assert bare.to_sun("y")[0] == pytest.approx([east, up, -north], abs=1e-5)


def test_positions_match_pvlib() -> None:
    pandas, pvlib = pytest.importorskip("pandas"), pytest.importorskip("pvlib")
    times = pandas.date_range("2026-01-01", "2026-12-31", freq="53h", tz="Europe/Berlin")
    found = adumbra.SunPath(**MUNICH, times=times, refraction=False)
    expected = pvlib.solarposition.get_solarposition(times, 48.14, 11.58)
    assert np.abs(found.elevation - expected["elevation"].to_numpy()).max() < 0.0003
    assert turn(found.solar_azimuth, expected["azimuth"]).max() < 0.0003
    assert np.array_equal(found.apparent_elevation, found.elevation)
    assert np.linalg.norm(found.to_sun("y"), axis=1) == pytest.approx(1)


def test_the_sun_rises_and_sets_in_the_seconds_of_pvlib() -> None:
    pandas, pvlib = pytest.importorskip("pandas"), pytest.importorskip("pvlib")
    days = pandas.DatetimeIndex(["2015-01-02", "2015-08-02"], tz="America/Denver")
    events = pvlib.solarposition.sun_rise_set_transit_spa(days, 39.742476, -105.1786)
    compared = 0
    for name, sign in [("sunrise", 1), ("sunset", -1)]:
        for event in events[name]:
            if event.day != event.tz_convert("UTC").day:
                # Of such an event, pvlib has the time of the day before.
                continue
            around = event.round("1s") + pandas.to_timedelta([-1, 0, 1], unit="s")
            sun = adumbra.SunPath(lat=39.742476, lon=-105.1786, times=around, refraction=False)
            # The upper rim of the refracted sun is at the horizon, in NREL's algorithm as seen from the centre of the earth.
            is_up = sign * (sun.elevation + 0.0024 + 0.8333) > 0
            assert not is_up[0] and is_up[2], (name, event)
            compared += 1
    assert compared == 3
    transit = pandas.DatetimeIndex(events["transit"]).round("1s")
    for moment in transit:
        around = moment + pandas.to_timedelta([-1, 1], unit="s")
        azimuths = adumbra.SunPath(lat=39.742476, lon=-105.1786, times=around).solar_azimuth
        assert azimuths[0] < 180 < azimuths[1], moment


def test_positions_of_pvlib_are_taken() -> None:
    pandas, pvlib = pytest.importorskip("pandas"), pytest.importorskip("pvlib")
    times = pandas.date_range("2026-01-01", "2026-12-31", freq="53h", tz="Europe/Berlin")
    position = pvlib.solarposition.get_solarposition(times, 48.14, 11.58)
    taken = adumbra.SunPath.from_pvlib(position, north_angle=30)
    own = adumbra.SunPath(**MUNICH, times=times, north_angle=30)
    assert np.array_equal(taken.times, own.times) and taken.north_angle == 30
    assert turn(taken.solar_azimuth, own.solar_azimuth).max() < 0.02
    assert np.abs(taken.elevation - own.elevation).max() < 0.02
    day = own.elevation > -0.5
    assert 0.3 < day.mean() < 0.7
    assert np.abs(taken.apparent_elevation - own.apparent_elevation)[day].max() < 0.02
    assert np.abs(taken.to_sun("z") - own.to_sun("z"))[day].max() < 0.001
    bare = adumbra.SunPath.from_pvlib(position[["azimuth", "elevation"]])
    assert np.array_equal(bare.apparent_elevation, bare.elevation)
    for name in ("azimuth", "elevation"):
        with pytest.raises(ValueError, match=f"position: there is no column '{name}'; give what pvlib's get_solarposition"):
            adumbra.SunPath.from_pvlib(position.drop(columns=name))
    with pytest.raises(ValueError, match="no column 'azimuth'"):
        adumbra.SunPath.from_pvlib(times)
    with pytest.raises(ValueError, match="the column 'elevation' has numbers that are no angles in degrees"):
        adumbra.SunPath.from_pvlib(position.assign(elevation=np.nan))
    with pytest.raises(ValueError, match="no time zone"):
        adumbra.SunPath.from_pvlib(position.tz_localize(None))


def test_every_form_of_time_gives_the_same_positions() -> None:
    utc = by_minutes("2026-06-21T10:00", "2026-06-21T11:30")
    expected = adumbra.SunPath(**MUNICH, times=utc, tz="UTC")
    assert np.array_equal(expected.times, utc)
    fixed = timezone(timedelta(hours=2))
    local = by_minutes("2026-06-21T12:00", "2026-06-21T13:30")
    berlin = ZoneInfo("Europe/Berlin")
    forms: list[tuple[Any, str | tzinfo | None]] = [
        ([datetime(2026, 6, 21, 12, 0, tzinfo=fixed), datetime(2026, 6, 21, 13, 30, tzinfo=berlin)], None),
        ([datetime(2026, 6, 21, 12, 0), datetime(2026, 6, 21, 13, 30)], "Europe/Berlin"),
        (local, "Europe/Berlin"),
        (local.astype("datetime64[ns]"), berlin),
        (local, fixed),
        (utc.astype("datetime64[s]"), timezone.utc),
    ]
    for times, tz in forms:
        found = adumbra.SunPath(**MUNICH, times=times, tz=tz)
        assert np.array_equal(found.times, utc)
        assert np.array_equal(found.solar_azimuth, expected.solar_azimuth)
        assert np.array_equal(found.apparent_elevation, expected.apparent_elevation)


def test_times_of_pandas_give_the_same_positions() -> None:
    pandas = pytest.importorskip("pandas")
    index = pandas.date_range("2026-06-21 12:00", periods=2, freq="90min", tz="Europe/Berlin")
    expected = adumbra.SunPath(**MUNICH, times=by_minutes("2026-06-21T10:00", "2026-06-21T11:30"), tz="UTC")
    naive = index.tz_localize(None)
    forms: list[tuple[Any, str | None]] = [(index, None), (index.tz_convert("Asia/Tokyo"), None), (list(index), None)]
    forms += [(pandas.Series(index), None), (naive, "Europe/Berlin"), (list(naive), "Europe/Berlin")]
    for times, tz in forms:
        found = adumbra.SunPath(**MUNICH, times=times, tz=tz)
        assert np.array_equal(found.times, expected.times)
        assert np.array_equal(found.solar_azimuth, expected.solar_azimuth)
        assert np.array_equal(found.elevation, expected.elevation)
    with pytest.raises(ValueError, match=REMEDY):
        adumbra.SunPath(**MUNICH, times=naive)
    with pytest.raises(ValueError, match="tz: the times have a zone already"):
        adumbra.SunPath(**MUNICH, times=index, tz="Europe/Berlin")
    with pytest.raises(ValueError, match="NaT"):
        adumbra.SunPath(**MUNICH, times=pandas.DatetimeIndex([index[0], pandas.NaT]))


def test_naive_times_are_refused() -> None:
    forms: list[Any] = [
        by_minutes("2026-06-21T10:00"),
        [datetime(2026, 6, 21, 10, 0)],
        np.array([datetime(2026, 6, 21, 10, 0)], object),
        [datetime(2026, 6, 21, 10, 0, tzinfo=timezone.utc), datetime(2026, 6, 21, 10, 0)],
    ]
    for times in forms:
        with pytest.raises(ValueError, match=REMEDY):
            adumbra.SunPath(**MUNICH, times=times)


def test_a_zone_is_given_once() -> None:
    for tz in ("UTC", "Europe/Berlin"):
        with pytest.raises(ValueError, match="tz: the times have a zone already; leave tz out, or convert them"):
            adumbra.SunPath(**MUNICH, times=[datetime(2026, 6, 21, 10, 0, tzinfo=timezone.utc)], tz=tz)
    for tz in ("Mars", "", "../Berlin"):
        with pytest.raises(ValueError, match='is not an IANA name, such as "Europe/Berlin"'):
            adumbra.SunPath(**MUNICH, times=by_minutes("2026-06-21T10:00"), tz=tz)


@pytest.mark.parametrize(
    ("time", "message"),
    [
        ("2026-03-29T02:30", "2026-03-29 02:30:00 does not exist on the clock of Europe/Berlin"),
        ("2026-10-25T02:30", "2026-10-25 02:30:00 exists twice on the clock of Europe/Berlin"),
    ],
)
def test_times_at_which_the_clock_is_changed_are_refused(time: str, message: str) -> None:
    for times in (by_minutes("2026-06-21T10:00", time), [datetime.fromisoformat(time)]):
        with pytest.raises(ValueError, match=f"{message}, which is changed then; give such times with their offset"):
            adumbra.SunPath(**MUNICH, times=times, tz="Europe/Berlin")
    with_offset = [datetime.fromisoformat(f"{time}+02:00")]
    assert len(adumbra.SunPath(**MUNICH, times=with_offset)) == 1
    assert len(adumbra.SunPath(**MUNICH, times=by_minutes(time), tz="UTC")) == 1


def test_times_with_zones_are_those_of_their_clock() -> None:
    pytz, tz = pytest.importorskip("pytz"), pytest.importorskip("dateutil.tz")
    berlin = ZoneInfo("Europe/Berlin")
    noon = datetime(2026, 6, 21, 10, tzinfo=timezone.utc).timestamp()
    for time in (
        datetime(2026, 6, 21, 12, tzinfo=berlin),
        datetime(2026, 6, 21, 12, tzinfo=tz.gettz("Europe/Berlin")),
        pytz.timezone("Europe/Berlin").localize(datetime(2026, 6, 21, 12)),
        datetime(2026, 6, 21, 12, tzinfo=timezone(timedelta(hours=2))),
    ):
        assert adumbra.SunPath(**MUNICH, times=[time]).times.astype("M8[s]").astype(int).tolist() == [noon]
    pandas = pytest.importorskip("pandas")
    half_hours = pandas.date_range("2026-10-24 22:00", periods=12, freq="30min", tz="UTC")
    for zone in (pytz.timezone("Europe/Berlin"), "Europe/Berlin", tz.gettz("Europe/Berlin")):
        local = half_hours.tz_convert(zone)
        for form in (local, list(local), pandas.Series(local)):
            found = adumbra.SunPath(**MUNICH, times=form).times
            assert np.array_equal(found, half_hours.tz_localize(None).to_numpy().astype("M8[us]")), zone
    for early in ([datetime(1, 1, 1, tzinfo=timezone(timedelta(hours=2)))], [datetime(9999, 12, 31, 23, tzinfo=timezone(-timedelta(hours=5)))]):
        with pytest.raises(ValueError, match="year"):
            adumbra.SunPath(**MUNICH, times=early)
    with pytest.raises(ValueError, match="year must be from 1 to 2999"):
        adumbra.SunPath(**MUNICH, times=[datetime(1, 1, 1)], tz="Asia/Tokyo")
    twice = [datetime(2026, 10, 25, 2, 30, tzinfo=berlin, fold=fold) for fold in (0, 1)]
    assert np.diff(adumbra.SunPath(**MUNICH, times=twice).times).astype("m8[s]").astype(int).tolist() == [3600]
    wrong = {
        datetime(2026, 6, 21, 12, tzinfo=pytz.timezone("Europe/Berlin")): r"has an offset that Europe/Berlin does not have then; write zone\.localize",
        datetime(2026, 3, 29, 2, 30, tzinfo=berlin): "does not exist on the clock",
        datetime(2026, 3, 29, 2, 30, tzinfo=tz.gettz("Europe/Berlin")): "does not exist on the clock",
    }
    for time, message in wrong.items():
        with pytest.raises(ValueError, match=message):
            adumbra.SunPath(**MUNICH, times=[time])
    with pytest.raises(ValueError, match="does not exist on the clock"):
        adumbra.SunPath(**MUNICH, times=[datetime(2026, 3, 29, 2, 30)], tz=tz.gettz("Europe/Berlin"))


def test_a_path_is_cut_by_slices_masks_and_numbers() -> None:
    times = by_minutes(*(f"2026-06-21T{hour:02}:00" for hour in range(24)))
    sun = adumbra.SunPath(**MUNICH, times=times, tz="UTC", north_angle=30)
    for index in (slice(3, 9), np.arange(3, 9), [3, 4, 5, 6, 7, 8], (times >= times[3]) & (times < times[9])):
        part = sun[index]
        assert len(part) == 6 and part.north_angle == 30 and np.array_equal(part.times, sun.times[3:9])
        assert np.array_equal(part.to_sun("z"), sun.to_sun("z")[3:9])
    wrong: list[Any] = [3, np.int64(3), None, np.ones((2, 3), int), (3,), (3, 4), (slice(0, 3), 0)]
    for index in wrong:
        with pytest.raises(TypeError, match=r"give a slice or an array, or take one direction, sun\.to_sun\(up\)\[number\]"):
            sun[index]
    again = pickle.loads(pickle.dumps(sun))
    assert np.array_equal(again.to_sun("z"), sun.to_sun("z")) and np.array_equal(again.times, sun.times)
    for change in (sun.solar_azimuth, sun.elevation, sun.apparent_elevation, sun[:3].elevation, again.elevation):
        with pytest.raises(ValueError, match="read-only"):
            change[0] = 5
    plate = adumbra.Scene.from_arrays([[0, 0, 3], [4, 0, 3], [0, 4, 3]], [[0, 1, 2]], up="z")
    to_sun: Any = sun
    with pytest.raises(TypeError, match="a file has one sun"):
        adumbra.bake(plate, to_sun=to_sun)


def test_positions_match_published_ones_on_other_continents() -> None:
    # Ladybug's tests: New York 2017-09-15 11:00 (UTC-5), Sydney 2017-11-15 11:00 (UTC+10), NOAA's formulas to 0.1 degrees.
    for lat, lon, time, hours, elevation, azimuth in [
        (40.72, -74.02, datetime(2017, 9, 15, 11), -5, 50.35, 159.72),
        (-33.87, 151.22, datetime(2017, 11, 15, 11), 10, 72.26, 32.37),
    ]:
        zone = timezone(timedelta(hours=hours))
        found = adumbra.SunPath(lat=lat, lon=lon, times=[time.replace(tzinfo=zone)], refraction=False)
        assert found.elevation[0] == pytest.approx(elevation, abs=0.1) and found.solar_azimuth[0] == pytest.approx(azimuth, abs=0.2)


def test_wrong_times_and_places_are_refused() -> None:
    utc = by_minutes("2026-06-21T10:00", "2026-06-21T11:30")
    wrong: list[tuple[Any, type[Exception]]] = [
        ([1.0], TypeError),
        (["2026-06-21"], TypeError),
        ([None], TypeError),
        (utc.reshape(1, 2), ValueError),
        (utc[0], ValueError),
        (np.array(["NaT"], "M8[s]"), ValueError),
    ]
    for times, error in wrong:
        with pytest.raises(error, match="times"):
            adumbra.SunPath(**MUNICH, times=times, tz="UTC")
    for place, message in [
        ({"lat": 91, "lon": 11}, "latitude 91"),
        ({"lat": 48, "lon": 181}, "longitude 181"),
        ({"lat": 48, "lon": 11, "height": 9001}, "9001"),
        ({"lat": 48, "lon": 11, "north_angle": np.nan}, "north_angle: nan is not a number of degrees"),
    ]:
        options: Any = place
        with pytest.raises(ValueError, match=message):
            adumbra.SunPath(**options, times=utc, tz="UTC")
    up: Any = "x"
    with pytest.raises(ValueError, match="up: 'x' is not an axis"):
        adumbra.SunPath(**MUNICH, times=utc, tz="UTC").to_sun(up)


def test_the_north_angle_turns_directions() -> None:
    times = by_minutes("2026-06-21T07:00", "2026-06-21T13:00", "2026-06-21T23:00")
    straight, quarter = (adumbra.SunPath(**MUNICH, times=times, tz="Europe/Berlin", north_angle=angle) for angle in (0, 90))
    # True north is where the scene has east, so directions turn clockwise by a quarter.
    x, y, z = straight.to_sun("y").T
    assert quarter.to_sun("y") == pytest.approx(np.column_stack([-z, y, x]))
    x, y, z = straight.to_sun("z").T
    assert quarter.to_sun("z") == pytest.approx(np.column_stack([y, -x, z]))
    assert straight.to_sun("y") == pytest.approx(np.column_stack([x, z, -y]))
    assert np.array_equal(quarter.solar_azimuth, straight.solar_azimuth)
    assert (straight.north_angle, quarter.north_angle) == (0, 90)
    assert straight.is_up.tolist() == quarter.is_up.tolist() == [True, True, False]


def test_refraction_raises_the_sun() -> None:
    times = np.array([f"2026-03-20T{hour:02}:30" for hour in range(24)], "datetime64[m]")
    bent, straight = (adumbra.SunPath(**MUNICH, times=times, tz="Europe/Berlin", refraction=is_bent) for is_bent in (True, False))
    assert np.array_equal(bent.elevation, straight.elevation) and np.array_equal(straight.apparent_elevation, straight.elevation)
    raised = (bent.apparent_elevation - bent.elevation)[bent.elevation > 0]
    assert (raised > 0).all() and raised.max() < 0.6
    assert np.array_equal(bent.is_up, bent.apparent_elevation > 0)


def test_notebooks_show_the_figures_of_a_path() -> None:
    times = np.array([f"2026-06-21T{hour:02}:00" for hour in range(24)], "datetime64[m]")
    sun = adumbra.SunPath(**MUNICH, times=times, tz="UTC")
    shown = sun._repr_html_()
    days = int(sun.is_up.sum())
    for figure in ("<td>24</td>", f"<td>{days}</td>", "2026-06-21T23:00:00", " UTC", f"{sun.apparent_elevation.max():.2f}°"):
        assert figure in shown
    assert 14 <= days <= 17 and repr(sun) == f"<adumbra.SunPath of 24 times, {days} of them by day>"
    none = adumbra.SunPath(**MUNICH, times=times[:0], tz="UTC")
    assert len(none) == 0 and none.to_sun("y").shape == (0, 3) and "<td>0</td>" in none._repr_html_()
