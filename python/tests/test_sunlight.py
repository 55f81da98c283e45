"""Where the sun is, hours of sun, and the visible sky: the answers of the program and of pvlib."""

from __future__ import annotations

import json
from datetime import datetime, timedelta, timezone
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import Mesh, Program, points_of

import adumbra

DAY: Any = {"lat": 48.14, "lon": 11.58, "date": "2026-03-20", "from_": 8, "to": "18:00", "tz": "Europe/Berlin"}


def test_sun_positions_match_pvlib() -> None:
    pandas, pvlib = pytest.importorskip("pandas"), pytest.importorskip("pvlib")
    times = pandas.date_range("2026-01-01", "2026-12-31", freq="53h", tz="Europe/Berlin")
    found = adumbra.sun_positions(48.14, 11.58, times, refraction=False)
    expected = pvlib.solarposition.get_solarposition(times, 48.14, 11.58)
    assert np.abs(found.elevation - expected["elevation"].to_numpy()).max() < 0.01
    turn = (found.azimuth - expected["azimuth"].to_numpy() + 180) % 360 - 180
    assert np.abs(turn).max() < 0.01
    assert np.linalg.norm(found.direction, axis=1) == pytest.approx(1)


def test_every_form_of_time_gives_the_same_positions() -> None:
    utc = np.array(["2026-06-21T10:00", "2026-06-21T11:30"], "datetime64[m]")
    berlin = timezone(timedelta(hours=2))
    aware = [datetime(2026, 6, 21, 12, 0, tzinfo=berlin), datetime(2026, 6, 21, 13, 30, tzinfo=berlin)]
    expected = adumbra.sun_positions(48, 11, utc)
    assert np.array_equal(adumbra.sun_positions(48, 11, aware).azimuth, expected.azimuth)
    for wrong, error in [([1.0], TypeError), (utc.reshape(1, 2), ValueError), (np.array(["NaT"], "M8[s]"), ValueError)]:
        with pytest.raises(error, match="times"):
            adumbra.sun_positions(48, 11, wrong)
    with pytest.raises(ValueError, match="latitude 91"):
        adumbra.sun_positions(91, 11, utc)


def test_sun_hours_match_the_program(city: Path, program: Program, tmp_path: Path) -> None:
    output = tmp_path / "hours.json"
    given = [f"--{key.strip('_')}={value}" for key, value in DAY.items()]
    table = tmp_path / "points.csv"
    points = np.random.default_rng(1).uniform((-100, 1, -100), (100, 30, 100), (500, 3))
    np.savetxt(table, points, delimiter=",", fmt="%.17g")
    program("sun-hours", city, "--points", table, *given, "-o", output)
    expected = json.loads(output.read_text())["points"]
    found = adumbra.sun_hours(city, points, **DAY)
    assert np.array_equal(found.hours, [point["hours"] for point in expected])
    spans = [(i, *span) for i, point in enumerate(expected) for span in point["intervals"]]
    times = zip(found.span_points, found.span_starts.astype(int), found.span_ends.astype(int), strict=True)
    assert list(times) == spans and 0 < found.hours.mean() < 10


def test_intervals_are_a_table_in_local_time(mesh: Mesh) -> None:
    pandas = pytest.importorskip("pandas")
    points, normals = points_of(mesh, 200)
    told: list[tuple[int, int]] = []
    found = adumbra.sun_hours(mesh, points, normals, **DAY, progress=lambda *both: told.append(both))
    table = found.intervals()
    assert list(table.columns) == ["point", "start", "end"] and str(table.start.dt.tz) == "Europe/Berlin"
    assert table.start.min() >= pandas.Timestamp("2026-03-20 08:00", tz="Europe/Berlin")
    lasting = (table.end - table.start).dt.total_seconds().groupby(table.point).sum() / 3600
    assert np.allclose(found.hours[lasting.index], lasting) and told[-1] == (1, 1)
    with pytest.raises(ValueError, match="no time zone"):
        adumbra.sun_hours(mesh, points, **{**DAY, "tz": "Mars"})


def test_skies_are_open_above_and_hidden_below(mesh: Mesh) -> None:
    for patches, count in (("tregenza", 145), ("reinhart", 577)):
        found = adumbra.sky(mesh, [[20, 90, 20], [20, 0.1, 1]], patches=patches)  # type: ignore[arg-type]
        assert found.patches.shape == (2, count) and found.patches.dtype == np.bool_
        assert found.patches[0].all() and not found.patches[1].all()
        assert found.sky_view_factor[0] == pytest.approx(1) and found.shade_fraction[0] == pytest.approx(0)
        assert 0 < found.sky_view_factor[1] < 1
    with pytest.raises(ValueError, match="patches"):
        adumbra.sky(mesh, [[0, 1, 0]], patches="some")  # type: ignore[arg-type]
