"""Rays: agreement with files and geometry, and shapes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from conftest import SUN, Mesh, points_of

import adumbra


def test_rays_agree_with_the_file_as_often_as_in_verify(mesh: Mesh, shadows: adumbra.ShadowFile) -> None:
    points, normals = points_of(mesh, 50_000)
    towards = normals @ np.array(shadows.sun)
    points, normals = points[towards > 0.1], normals[towards > 0.1]
    traced = adumbra.rays(*mesh).visibility(points, SUN, normals)
    baked = shadows.visibility(points, normals, 1)
    verified = shadows.verify(mesh, samples=50_000)
    assert (traced == baked).mean() > verified.agreement - 0.005 > 0.98
    assert traced.mean() == pytest.approx(1 - verified.shadowed_share, abs=0.1)


def test_every_sun_has_a_column(mesh: Mesh) -> None:
    tracer = adumbra.rays(*mesh)
    points, normals = points_of(mesh, 2_000)
    suns = adumbra.sun_direction([90, 140, 250], [20, 45, 70])
    found = tracer.visibility(points, suns, normals)
    assert found.shape == (2_000, 3) and found.dtype == np.float32
    for column, sun in enumerate(suns):
        one = tracer.visibility(points, 7 * sun, normals)
        assert one.shape == (2_000,)
        assert np.array_equal(found[:, column], one)
    assert set(np.unique(found)) == {0, 1}
    single = tracer.visibility(points.astype(np.float32), suns, normals.astype(np.float32))
    assert (single == found).mean() > 0.999
    assert tracer.visibility(points[:0], suns).shape == (0, 3)
    assert tracer.visibility(points, np.empty((0, 3))).shape == (2_000, 0)
    assert "rays" in type(tracer).__name__.lower() and tracer.scene.triangles == len(mesh[1])


def test_large_arrays_give_the_same_answers_as_small_ones(mesh: Mesh) -> None:
    tracer = adumbra.rays(*mesh)
    some, _ = points_of(mesh, 100)
    some += (0, 0.01, 0)
    suns = adumbra.sun_direction(np.arange(0, 360, 120), 30)
    many = tracer.visibility(np.tile(some, (600, 1)), suns)
    assert np.array_equal(many, np.tile(tracer.visibility(some, suns), (600, 1)))


def test_a_sun_below_the_horizon_is_hidden_by_the_ground(mesh: Mesh) -> None:
    above = np.array([[20.0, 5.0, 1.0]])
    assert adumbra.rays(*mesh).visibility(above, [[0, -1, 0], [0, 1, 0]]).tolist() == [[0, 1]]


def test_points_that_are_not_finite_are_lit(mesh: Mesh) -> None:
    points = np.array([[np.nan, 0, 0], [np.inf, 0, 0]])
    assert adumbra.rays(*mesh).visibility(points, SUN).tolist() == [1, 1]


def test_errors_name_wrong_suns(mesh: Mesh) -> None:
    tracer = adumbra.rays(*mesh)
    points = np.zeros((2, 3))
    wrong: list[tuple[Any, float, str]] = [
        ([[0, 1, 0], [0, 0, 0]], 0.0, r"suns\[1\] is"),
        ([0, np.nan, 1], 0.0, r"suns\[0\] is"),
        ([0, 1], 0.0, r"suns: an array of shape \(N, 3\)"),
        ([0, 1, 0], np.inf, "lift: inf is out of range"),
    ]
    for suns, lift, message in wrong:
        with pytest.raises(ValueError, match=message):
            tracer.visibility(points, suns, lift=lift)
    with pytest.raises(ValueError, match="normals: 1 rows for 2 points"):
        tracer.visibility(points, SUN, points[:1])


def test_sun_directions_run_clockwise_from_minus_z() -> None:
    half = np.sqrt(0.5)
    assert adumbra.sun_direction(0, 45) == pytest.approx([0, half, -half])
    assert adumbra.sun_direction(90, 45) == pytest.approx([half, half, 0])
    assert adumbra.sun_direction([[0], [90]], [10, 20, 30]).shape == (2, 3, 3)
    assert adumbra.sun_direction([], []).shape == (0, 3)
    for azimuth, elevation in [(0, 0), (0, -3), (0, 91), (np.nan, 3)]:
        with pytest.raises(ValueError):
            adumbra.sun_direction(azimuth, elevation)


def test_the_nearest_surface_is_found(mesh: Mesh) -> None:
    tracer = adumbra.rays(*mesh)
    points, normals = points_of(mesh, 200_000)
    away, found = tracer.nearest(points + 2.0 * normals, [0.0, -0.5, 0.0])
    up = normals[:, 1] > 0.5
    assert away[up] == pytest.approx(4.0, abs=1e-4)
    assert found[up] == pytest.approx(normals[up], abs=1e-4)
    outside = np.array([[-1.0, 5.0, -1.0], [np.nan, 5.0, 1.0]], np.float32)
    away, found = tracer.nearest(outside, (0, -1, 0))
    assert away.tolist() == [np.inf, np.inf] and not found.any()
    for direction in [(0, 0, 0), (0, np.nan, 1), (1, 2)]:
        with pytest.raises(ValueError, match="direction"):
            tracer.nearest(points, direction)
