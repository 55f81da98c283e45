"""Scenes in which Z points up answer in their own coordinates, as those of the same meshes that are turned."""

from __future__ import annotations

from datetime import datetime, timezone
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from conftest import DAY, Mesh, points_of, write_ply
from numpy.typing import NDArray

import adumbra

Rows = NDArray[np.float64]


def to_y_up(rows: Any) -> Rows:
    """Return rows of coordinates, of which Z points up, as those of which Y does."""
    given = np.asarray(rows, np.float64).reshape(-1, 3)
    return np.column_stack([given[:, 0], given[:, 2], 0.0 - given[:, 1]])


class Pair(NamedTuple):
    """A town with Z up, the same one with Y up, and points on it with their normals, of which Z points up."""

    z: adumbra.Scene
    y: adumbra.Scene
    mesh: Mesh
    points: Rows
    normals: Rows


@pytest.fixture(scope="module")
def pair(mesh: Mesh) -> Pair:
    """Return the town of the other tests, with Z up and with Y up."""
    single = mesh[0].astype(np.float32).astype(np.float64)
    vertices = np.column_stack([single[:, 0], 0.0 - single[:, 2], single[:, 1]])
    points, normals = points_of((vertices, mesh[1]), 2_000)
    z = adumbra.Scene.from_arrays(vertices, mesh[1], up="z")
    y = adumbra.Scene.from_arrays(to_y_up(vertices), mesh[1], up="y")
    return Pair(z, y, (vertices, mesh[1]), points, normals)


@pytest.fixture(scope="module")
def files(pair: Pair) -> tuple[adumbra.ShadowFile, adumbra.ShadowFile]:
    """Return the files of both, for a sun in the southeast."""
    z, y = (adumbra.bake(scene, azimuth=125, elevation=53, resolution=1024) for scene in (pair.z, pair.y))
    return z, y


def test_scenes_have_the_coordinates_of_their_arrays(pair: Pair) -> None:
    vertices, faces = pair.z.mesh()
    corners = pair.mesh[0][pair.mesh[1]]
    assert (pair.z.up, pair.y.up) == ("z", "y")
    assert np.array_equal(vertices[faces], corners)
    assert pair.z.bounds == (tuple(corners.min((0, 1))), tuple(corners.max((0, 1))))
    assert np.array_equal(to_y_up(vertices), pair.y.mesh()[0])
    assert to_y_up(pair.z.to_sun) == pytest.approx(np.array([pair.y.to_sun]))
    assert pair.z.to_sun[2] > 0.7 and ", z up" in repr(pair.z)


def test_the_nearest_surface_is_found_in_the_scenes_coordinates(pair: Pair) -> None:
    above = pair.points[pair.normals[:, 2] > 0.5] + (0.0, 0.0, 30.0)
    away, normals = pair.z.nearest(above, (0, 0, -1))
    expected, upright = pair.y.nearest(to_y_up(above), (0, -1, 0))
    assert away == pytest.approx(expected) and to_y_up(normals) == pytest.approx(upright, abs=1e-12)
    assert (normals[:, 2] > 0.99).all() and (away <= 30.0 + 1e-4).all()
    for direction in ((0.0, 1.0, 0.0), (1.0, 0.5, 0.0), (-0.3, 0.2, -1.0)):
        away, normals = pair.z.nearest(above - (0.0, 0.0, 29.0), direction)
        expected, upright = pair.y.nearest(to_y_up(above - (0.0, 0.0, 29.0)), to_y_up(direction)[0])
        assert away == pytest.approx(expected) and to_y_up(normals) == pytest.approx(upright, abs=1e-12)
        hit = np.isfinite(away)
        assert 10 < hit.sum() and (normals[hit] @ direction < 0.0).all()


def test_the_nearest_wall_is_found_where_it_is() -> None:
    wall = [[0.0, 7.0, 0.0], [4.0, 7.0, 0.0], [4.0, 7.0, 3.0], [0.0, 7.0, 3.0]]
    scene = adumbra.Scene.from_arrays(wall, [[0, 1, 2], [0, 2, 3]], up="z")
    away, normals = scene.nearest([[1, 2, 1], [1, 9, 1], [9, 2, 1]], (0, 1, 0))
    assert away.tolist() == [5.0, np.inf, np.inf] and normals.tolist() == [[0, -1, 0], [0, 0, 0], [0, 0, 0]]


def test_rays_take_points_normals_and_suns_in_the_scenes_coordinates(pair: Pair) -> None:
    turned, upright = to_y_up(pair.points), to_y_up(pair.normals)
    angles = ([20, 140, 225], [30, 60, 35])
    suns = adumbra.sun_direction(*angles, up="z")
    assert to_y_up(suns) == pytest.approx(adumbra.sun_direction(*angles, up="y"), abs=1e-15)
    found = pair.z.sunlit(pair.points, pair.normals, suns)
    assert np.array_equal(found, pair.y.sunlit(turned, upright, adumbra.sun_direction(*angles, up="y")))
    assert 0.1 < found.mean() < 0.9
    air = pair.points + (0.0, 0.0, 1.0)
    assert np.array_equal(pair.z.sunlit(air, None, suns[0]), pair.y.sunlit(to_y_up(air), None, to_y_up(suns)[0]))
    shares = pair.z.visibility(pair.points[:200], pair.normals[:200], suns, sun_degrees=3)
    assert np.array_equal(shares, pair.y.visibility(turned[:200], upright[:200], to_y_up(suns), sun_degrees=3))
    times = np.array([f"2026-03-20T{hour:02}:00" for hour in range(5, 20)], "M8[m]")
    day = adumbra.SunPath(lat=48.14, lon=11.58, times=times, tz="Europe/Berlin")
    lit = pair.z.sunlit(pair.points, pair.normals, day)
    assert np.array_equal(lit, pair.y.sunlit(turned, upright, day)) and lit.any()


def test_files_answer_in_the_scenes_coordinates(
    pair: Pair, files: tuple[adumbra.ShadowFile, adumbra.ShadowFile]
) -> None:
    z, y = files
    assert (z.up, y.up) == ("z", "y")
    assert to_y_up(z.to_sun) == pytest.approx(np.array([y.to_sun]))
    assert z.to_sun == pytest.approx(adumbra.sun_direction(125, 53, up="z"))
    turned = {"up", "to_sun"}
    assert {name: value for name, value in z.info.items() if name not in turned} == {
        name: value for name, value in y.info.items() if name not in turned
    }
    found = z.visibility(pair.points, pair.normals)
    assert np.array_equal(found, y.visibility(to_y_up(pair.points), to_y_up(pair.normals)))
    assert np.array_equal(found, z.visibility(pair.points.tolist(), pair.normals.tolist()))
    single = pair.points.astype(np.float32)
    assert np.array_equal(z.visibility(single, filter=1), y.visibility(to_y_up(single), filter=1))
    facing = pair.normals @ np.array(z.to_sun) > 0.1
    lit = pair.z.sunlit(pair.points, pair.normals, z.to_sun)
    assert (z.visibility(pair.points, pair.normals, 1) == lit)[facing].mean() > 0.96
    assert adumbra.ShadowFile.open(z.to_bytes()).up == "z"


def test_suns_and_bounds_of_a_bake_are_in_the_scenes_coordinates(pair: Pair) -> None:
    box = (5.0, -33.0, 0.0, 35.0, -9.0, 20.0)
    z = adumbra.bake(pair.z, to_sun=(0, 0, 2), resolution=256, bounds=box)
    y = adumbra.bake(pair.y, to_sun=(0, 2, 0), resolution=256, bounds=(5, 0, 9, 35, 20, 33))
    assert (z.to_sun, z.bounds) == ((0, 0, 1), (box[:3], box[3:]))
    assert (y.to_sun, y.bounds) == ((0, 1, 0), ((5, 0, 9), (35, 20, 33)))
    assert np.array_equal(z.visibility(pair.points), y.visibility(to_y_up(pair.points)))
    with pytest.raises(ValueError, match="above the horizon"):
        adumbra.bake(pair.z, to_sun=(0, 1, 0), resolution=64)


def test_files_of_scene_files_keep_the_axis(
    pair: Pair, files: tuple[adumbra.ShadowFile, adumbra.ShadowFile], tmp_path: Path
) -> None:
    path = tmp_path / "town.ply"
    write_ply(path, pair.mesh)
    loaded = adumbra.Scene(path, up="z")
    assert (loaded.up, loaded.bounds) == ("z", pair.z.bounds)
    baked = adumbra.bake(path, azimuth=125, elevation=53, resolution=1024, up="z")
    assert baked == files[0]
    # The file holds the axis, so its scene is loaded as for the bake.
    found = baked.verify(path, samples=20_000)
    assert found.passed and found.agreement == baked.verify(pair.z, samples=20_000).agreement


def test_hours_of_sun_and_skies_are_those_of_the_turned_scene(pair: Pair) -> None:
    points, normals = pair.points[:40], pair.normals[:40]
    found = adumbra.sun_hours(pair.z, points, normals, **DAY)
    assert np.array_equal(found.hours, adumbra.sun_hours(pair.y, to_y_up(points), to_y_up(normals), **DAY).hours)
    assert 0 < found.hours.mean() < 10
    skies = adumbra.sky(pair.z, points, normals)
    assert np.array_equal(skies.patches, adumbra.sky(pair.y, to_y_up(points), to_y_up(normals)).patches)
    assert 0.1 < skies.sky_view_factor.mean() < 1


def test_files_of_a_moving_sun_answer_in_the_scenes_coordinates(pair: Pair) -> None:
    day: Any = {"lat": 48, "lon": 11, "date": "2026-03-20", "from_": 12, "to": "12:30", "resolution": 256}
    z, y = (adumbra.bake_path(scene, **day) for scene in (pair.z, pair.y))
    time = datetime(2026, 3, 20, 11, 13, tzinfo=timezone.utc)
    sun = z.sun_at(time)
    assert sun is not None and sun[2] > 0.5
    assert to_y_up(sun) == pytest.approx(np.array([y.sun_at(time)]))
    found = z.visibility(pair.points, time, pair.normals)
    assert np.array_equal(found, y.visibility(to_y_up(pair.points), time, to_y_up(pair.normals)))
    assert 0 < found.mean() < 1
