"""Hours of sun, and the visible sky: the answers of the program."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import DAY, Mesh, Program, points_of

import adumbra


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
    spans = [(i, *(round(1000 * end) for end in span)) for i, point in enumerate(expected) for span in point["intervals"]]
    times = zip(found.span_points, found.span_starts.astype(int), found.span_ends.astype(int), strict=True)
    assert list(times) == spans and 0 < found.hours.mean() < 10


def test_intervals_are_a_table_in_local_time(mesh: Mesh, scene: adumbra.Scene) -> None:
    pandas = pytest.importorskip("pandas")
    points, normals = points_of(mesh, 200)
    reports: list[tuple[int, int]] = []
    found = adumbra.sun_hours(scene, points, normals, **DAY, progress=lambda *both: reports.append(both))
    table = found.intervals()
    assert list(table.columns) == ["point", "start", "end"] and str(table.start.dt.tz) == "Europe/Berlin"
    assert table.start.min() >= pandas.Timestamp("2026-03-20 08:00", tz="Europe/Berlin")
    lasting = (table.end - table.start).dt.total_seconds().groupby(table.point).sum() / 3600
    assert np.allclose(found.hours[lasting.index], lasting) and reports[-1] == (1, 1)
    with pytest.raises(ValueError, match="no time zone"):
        adumbra.sun_hours(scene, points, **{**DAY, "tz": "Mars"})


def test_skies_are_open_above_and_hidden_below(scene: adumbra.Scene) -> None:
    for patches, count in (("tregenza", 145), ("reinhart", 577)):
        found = adumbra.sky(scene, [[20, 90, 20], [20, 0.1, 1]], patches=patches)  # type: ignore[arg-type]
        assert found.patches.shape == (2, count) and found.patches.dtype == np.bool_
        assert found.patches[0].all() and not found.patches[1].all()
        assert found.sky_view_factor[0] == pytest.approx(1) and found.shade_fraction[0] == pytest.approx(0)
        assert 0 < found.sky_view_factor[1] < 1
    with pytest.raises(ValueError, match="patches"):
        adumbra.sky(scene, [[0, 1, 0]], patches="some")  # type: ignore[arg-type]
