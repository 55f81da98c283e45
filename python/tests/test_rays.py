"""Rays: agreement with files and geometry, normals, nights, the sun's disc, and shapes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from conftest import DAY, SUN, Mesh, points_of

import adumbra


@pytest.fixture(scope="module")
def plate() -> adumbra.Scene:
    """Return a level plate of 10 km, 10 m above the origin, with an edge above it from south to north."""
    corners = [[0, -1e4, 10], [1e4, -1e4, 10], [1e4, 1e4, 10], [0, 1e4, 10]]
    return adumbra.Scene.from_arrays(corners, [[0, 1, 2], [0, 2, 3]], up="z")


@pytest.fixture(scope="module")
def day() -> adumbra.SunPath:
    """Return the suns of each hour of a day."""
    hours = np.array([f"2026-03-20T{hour:02}:00" for hour in range(24)], "datetime64[m]")
    return adumbra.SunPath(lat=48.14, lon=11.58, times=hours, tz="Europe/Berlin")


def test_rays_agree_with_the_file_as_often_as_in_verify(
    mesh: Mesh, scene: adumbra.Scene, shadows: adumbra.ShadowFile
) -> None:
    points, normals = points_of(mesh, 50_000)
    towards = normals @ np.array(shadows.to_sun)
    points, normals = points[towards > 0.1], normals[towards > 0.1]
    traced = scene.sunlit(points, normals, SUN)
    baked = shadows.visibility(points, normals, 1)
    verified = shadows.verify(scene, samples=50_000)
    assert (traced == baked).mean() > verified.agreement - 0.005 > 0.98
    assert traced.mean() == pytest.approx(1 - verified.shadowed_share, abs=0.1)


def test_every_sun_has_a_column(mesh: Mesh, scene: adumbra.Scene) -> None:
    points, normals = points_of(mesh, 2_000)
    suns = adumbra.sun_direction([90, 140, 250], [20, 45, 70], up="y")
    found = scene.sunlit(points, normals, suns)
    assert found.shape == (2_000, 3) and found.dtype == np.bool_
    for column, sun in enumerate(suns):
        one = scene.sunlit(points, normals, 7 * sun)
        assert one.shape == (2_000,)
        assert np.array_equal(found[:, column], one)
    assert set(np.unique(found)) == {False, True}
    single = scene.sunlit(points.astype(np.float32), normals.astype(np.float32), suns)
    assert (single == found).mean() > 0.999
    assert scene.sunlit(points[:0], None, suns).shape == (0, 3)
    assert scene.sunlit(points, None, np.empty((0, 3))).shape == (2_000, 0)
    assert scene.triangles == len(mesh[1])


def test_large_arrays_give_the_same_answers_as_small_ones(mesh: Mesh, scene: adumbra.Scene) -> None:
    some, _ = points_of(mesh, 100)
    some += (0, 0.01, 0)
    suns = adumbra.sun_direction(np.arange(0, 360, 120), 30, up="y")
    many = scene.sunlit(np.tile(some, (600, 1)), None, suns)
    assert np.array_equal(many, np.tile(scene.sunlit(some, None, suns), (600, 1)))


def test_points_that_are_not_finite_are_lit(scene: adumbra.Scene) -> None:
    points = np.array([[np.nan, 0, 0], [np.inf, 0, 0]])
    assert scene.sunlit(points, None, SUN).tolist() == [True, True]


def test_surfaces_that_face_away_are_dark(scene: adumbra.Scene) -> None:
    sky = np.tile([[20.0, 90.0, 20.0]], (4, 1))
    normals = np.array([[0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [-0.9999, -0.0141, 0.0], [1.0, 0.0, 0.0]])
    assert scene.sunlit(sky, None, [0, 1, 0]).all()
    assert scene.sunlit(sky, normals, [0, 1, 0]).tolist() == [True, False, False, False]
    assert scene.sunlit(sky, normals, [[1, 0, 0], [-1, 0, 0]])[2:].tolist() == [[False, True], [True, False]]
    assert scene.visibility(sky, normals, [0, 1, 0]).tolist() == [1, 0, 0, 0]
    assert scene.visibility(sky.astype(np.float32), normals.astype(np.float32), [0, 1, 0]).tolist() == [1, 0, 0, 0]


def test_a_sun_path_has_a_column_for_each_time_and_nights_are_dark(
    mesh: Mesh, scene: adumbra.Scene, day: adumbra.SunPath
) -> None:
    points, normals = points_of(mesh, 500)
    points[0], normals[0] = (20, 90, 20), (0, 1, 0)
    assert len(day) == 24 and 10 < day.is_up.sum() < 14
    for upright in (normals, None):
        found = scene.sunlit(points, upright, day)
        assert found.shape == (500, 24) and found.dtype == np.bool_
        assert not found[:, ~day.is_up].any()
        assert np.array_equal(found[:, day.is_up], scene.sunlit(points, upright, day.to_sun("y")[day.is_up]))
        assert np.array_equal(found[0], day.is_up)
    shares = scene.visibility(points[:20], normals[:20], day)
    assert shares.shape == (20, 24) and not shares[:, ~day.is_up].any() and np.array_equal(shares[0], day.is_up)
    none = adumbra.SunPath(lat=48, lon=11, times=np.array([], "M8[s]"), tz="UTC")
    assert scene.sunlit(points, normals, none).shape == (500, 0)


def test_visibility_is_the_share_of_the_disc(plate: adumbra.Scene) -> None:
    points = [[0, 0, 0], [-1, 0, 0], [1, 0, 0]]
    found = plate.visibility(points, None, [0, 0, 3])
    assert found.dtype == np.float32
    assert found[0] == pytest.approx(0.5, abs=0.02) and found[1:].tolist() == [1, 0]
    # A disc of 90 degrees is 10 m wide on each side of the middle at the plate's height.
    wide = plate.visibility(points, None, [0, 0, 1], sun_degrees=90)
    assert wide[0] == pytest.approx(0.5, abs=0.02) and 0.5 < wide[1] < 0.7 and wide[1] + wide[2] == pytest.approx(1, abs=0.02)
    sharp = plate.visibility(points[1:], None, [[0, 0, 1], [1, 0, 0]], sun_degrees=0)
    assert np.array_equal(sharp, plate.sunlit(points[1:], None, [[0, 0, 1], [1, 0, 0]]))


def test_visibility_is_between_0_and_1(mesh: Mesh, scene: adumbra.Scene) -> None:
    points, normals = points_of(mesh, 300)
    found = scene.visibility(points, normals, adumbra.sun_direction([90, 140], [20, 45], up="y"), sun_degrees=5)
    assert found.shape == (300, 2) and ((found >= 0) & (found <= 1)).all()
    assert ((found > 0) & (found < 1)).any()
    for degrees in (-1, 181, np.nan):
        with pytest.raises(ValueError, match="sun_degrees: .* is out of range; it must be from 0 to 180"):
            scene.visibility(points, normals, SUN, sun_degrees=degrees)


def test_errors_name_wrong_suns(scene: adumbra.Scene) -> None:
    points = np.zeros((2, 3))
    wrong: list[tuple[Any, float, str]] = [
        ([[0, 1, 0], [0, 0, 0]], 0.0, r"to_sun\[1\] is"),
        ([0, np.nan, 1], 0.0, r"to_sun\[0\] is"),
        ([[1, 0, 0], [0.3, -1e-8, 0]], 0.0, r"to_sun\[1\] is .* below the horizon"),
        ([0, 1], 0.0, r"to_sun: an array of shape \(3,\) or \(T, 3\) is needed, not \(2,\)"),
        ([0, 1, 0], np.inf, "lift: inf is out of range"),
    ]
    for suns, lift, message in wrong:
        with pytest.raises(ValueError, match=message):
            scene.sunlit(points, None, suns, lift=lift)
        with pytest.raises(ValueError, match=message):
            scene.visibility(points, None, suns, lift=lift)
    with pytest.raises(ValueError, match="normals: 1 rows for 2 points"):
        scene.sunlit(points, points[:1], SUN)
    with pytest.raises(TypeError, match="to_sun: real numbers are needed"):
        scene.sunlit(points, None, ["a", "b", "c"])
    masked = np.ma.masked_equal([[0.0, 1.0, 0.5], [1.0, 1.0, 0.0]], 0.5)
    for ask in (lambda: scene.sunlit(points, None, masked), lambda: scene.nearest(points, masked[0])):
        with pytest.raises(ValueError, match="some values are masked"):
            ask()
    with pytest.raises(ValueError, match="to_sun: some values are masked"):
        adumbra.bake(scene, to_sun=masked[0])
    turned = scene.sunlit([[20, 90, 20]], None, [1, -1e-17, 0])
    assert turned.tolist() == [True]


@pytest.mark.parametrize("type", [np.float32, np.float64])
def test_normals_that_are_not_unit_vectors_are_refused(scene: adumbra.Scene, type: Any) -> None:
    points = np.zeros((3, 3), type)
    for wrong in ([0, 0, 0], [0, 2, 0], [0, np.nan, 1], [0, np.inf, 0]):
        normals = np.array([[0, 1, 0], wrong, wrong], type)
        asked: list[Callable[[], object]] = [
            lambda normals=normals: scene.sunlit(points, normals, SUN),  # type: ignore[misc]
            lambda normals=normals: scene.visibility(points, normals, SUN),  # type: ignore[misc]
            lambda normals=normals: adumbra.sky(scene, points, normals),  # type: ignore[misc]
            lambda normals=normals: adumbra.sun_hours(scene, points, normals, **DAY),  # type: ignore[misc]
        ]
        for ask in asked:
            with pytest.raises(ValueError, match=r"normals\[1\] is .* not a unit vector; divide normals by"):
                ask()
    slightly = np.array([[0, 1.005, 0]], type)
    assert scene.sunlit([[20, 90, 20]], slightly, SUN).tolist() == [True]


def test_few_points_and_many_suns_are_answered_like_many_points(scene: adumbra.Scene, mesh: Mesh) -> None:
    points, normals = points_of(mesh, 7)
    suns = adumbra.sun_direction(np.linspace(0, 350, 40_000), np.linspace(5, 85, 40_000), up="y")
    found = scene.sunlit(points, normals, suns)
    assert 0.05 < found.mean() < 0.95
    for some in (slice(0, 9), slice(20_000, 20_003), slice(39_990, None)):
        assert np.array_equal(found[:, some], scene.sunlit(points, normals, suns[some]))
    shares = scene.visibility(points, normals, suns[:1500], sun_degrees=4)
    assert np.array_equal(shares[:, 700:703], scene.visibility(points, normals, suns[700:703], sun_degrees=4))


def test_sun_directions_run_clockwise_from_north() -> None:
    half = np.sqrt(0.5)
    assert adumbra.sun_direction(0, 45, up="y") == pytest.approx([0, half, -half])
    assert adumbra.sun_direction(90, 45, up="y") == pytest.approx([half, half, 0])
    assert adumbra.sun_direction(0, 45, up="z") == pytest.approx([0, half, half])
    assert adumbra.sun_direction(90, 45, up="z") == pytest.approx([half, 0, half])
    assert adumbra.sun_direction(123, 90, up="y") == pytest.approx([0, 1, 0])
    assert adumbra.sun_direction(180, -45, up="y") == pytest.approx([0, -half, half])
    assert adumbra.sun_direction([[0], [90]], [10, 20, 30], up="y").shape == (2, 3, 3)
    assert adumbra.sun_direction([], [], up="y").shape == (0, 3)
    for azimuth, elevation in [(0, -91), (0, 91), (0, np.nan), (np.nan, 3)]:
        with pytest.raises(ValueError):
            adumbra.sun_direction(azimuth, elevation, up="y")
    wrong: Any = "x"
    with pytest.raises(ValueError, match="up: 'x' is not an axis"):
        adumbra.sun_direction(0, 45, up=wrong)


def test_the_nearest_surface_is_found(mesh: Mesh, scene: adumbra.Scene) -> None:
    points, normals = points_of(mesh, 50_000)
    away, found = scene.nearest(points + 2.0 * normals, [0.0, -0.5, 0.0])
    up = normals[:, 1] > 0.5
    assert away[up] == pytest.approx(4.0, abs=1e-4)
    assert found[up] == pytest.approx(normals[up], abs=1e-4)
    outside = np.array([[-1.0, 5.0, -1.0], [np.nan, 5.0, 1.0]], np.float32)
    away, found = scene.nearest(outside, (0, -1, 0))
    assert away.tolist() == [np.inf, np.inf] and not found.any()
    for direction in [(0, 0, 0), (0, np.nan, 1), (1, 2)]:
        with pytest.raises(ValueError, match="direction"):
            scene.nearest(points, direction)
