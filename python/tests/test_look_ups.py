"""Look-ups: the answers of the program, every form of array, and rejected shapes."""

from __future__ import annotations

import json
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import SUN, Mesh, Program, points_of
from numpy.typing import NDArray

import adumbra


@pytest.mark.parametrize("filter", [1, 3, 5, 9, 17])
def test_answers_match_the_program(
    filter: int, mesh: Mesh, shadows: adumbra.ShadowFile, program: Program, tmp_path: Path
) -> None:
    points, normals = points_of(mesh, 20_000)
    normals = normals.astype(np.float32)
    points[7], normals[9] = np.nan, np.inf
    shadows.save(tmp_path / "town.adumbra")
    normals.tofile(tmp_path / "normals")
    forms: list[tuple[str, NDArray[Any]]] = [("--points-f64", points), ("--points", points.astype(np.float32))]
    for option, values in forms:
        values.tofile(tmp_path / "points")
        for with_normals in (True, False):
            words = [option, tmp_path / "points", "--filter", filter, "-o", tmp_path / "answers"]
            words += ["--normals", tmp_path / "normals"] if with_normals else []
            program("query", tmp_path / "town.adumbra", *words)
            expected = np.fromfile(tmp_path / "answers", np.float32)
            found = shadows.visibility(values, normals if with_normals else None, filter)
            assert found.dtype == np.float32
            assert np.array_equal(found.view(np.uint32), expected.view(np.uint32))
            assert 0.1 < found.mean() < 0.9


def test_answers_with_a_bias_match_the_program(mesh: Mesh, shadows: adumbra.ShadowFile, program: Program, tmp_path: Path) -> None:
    points, normals = points_of(mesh, 5_000)
    shadows.save(tmp_path / "town.adumbra")
    points.tofile(tmp_path / "points")
    normals.astype(np.float32).tofile(tmp_path / "normals")
    words = ["--bias-constant", 3, "--bias-slope", 1.5, "--bias-normal", 0.5, "-o", tmp_path / "answers"]
    given = ["--points-f64", tmp_path / "points", "--normals", tmp_path / "normals"]
    program("query", tmp_path / "town.adumbra", *given, *words)
    found = shadows.visibility(
        points, normals.astype(np.float32), 1, bias_constant=3, bias_slope=1.5, bias_normal=0.5
    )
    assert np.array_equal(found, np.fromfile(tmp_path / "answers", np.float32))
    assert not np.array_equal(found, shadows.visibility(points, normals, 1))
    with pytest.raises(ValueError, match="a term of the bias: 17"):
        shadows.visibility(points, bias_slope=17)


@pytest.mark.parametrize("count", [0, 1, 4095, 4097, (1 << 20) + 1])
def test_any_number_of_points_is_answered(count: int, mesh: Mesh, shadows: adumbra.ShadowFile) -> None:
    some, upright = points_of(mesh, 1000)
    points, normals = np.resize(some, (count, 3)), np.resize(upright, (count, 3))
    found = shadows.visibility(points, normals)
    assert found.shape == (count,)
    assert np.array_equal(found, np.resize(shadows.visibility(some, upright), count))


def test_shadow_of_a_wall_has_the_right_length() -> None:
    """A wall of 10 m, under a sun 45 degrees high in +X: its shadow is 10 m long."""
    vertices = np.array(
        [[0, 0, -50], [0, 0, 50], [0, 10, 50], [0, 10, -50], [-50, 0, -50], [-50, 0, 50], [50, 0, 50], [50, 0, -50]]
    )
    faces = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]])
    scene = adumbra.Scene.from_arrays(vertices, faces, up="y")
    file = adumbra.bake(scene, azimuth=90, elevation=45, resolution=4096)
    x = np.arange(-20, 20, 0.25) + 0.125
    points = np.column_stack([x, np.zeros_like(x), np.zeros_like(x)])
    up = np.tile([0.0, 1.0, 0.0], (len(x), 1))
    expected = ~((x > -10) & (x < 0))
    assert np.array_equal(file.visibility(points, up, 1), expected)
    assert np.array_equal(scene.sunlit(points, up, file.to_sun), expected)


def test_points_that_are_not_finite_are_lit(shadows: adumbra.ShadowFile) -> None:
    points = np.array([[np.nan, 0, 0], [np.inf, 0, 0], [0, -np.inf, 0], [1e300, 1e300, -1e300], [20, -1e9, 20]])
    assert np.array_equal(shadows.visibility(points)[:3], [1, 1, 1])
    assert np.isfinite(shadows.visibility(points, np.full((5, 3), np.nan))).all()
    assert np.isfinite(shadows.visibility(points, np.full((5, 3), 1e308))).all()


@pytest.mark.parametrize(
    ("points", "normals", "filter", "error", "message"),
    [
        (np.zeros((2, 2)), None, 5, ValueError, r"points: an array of shape \(N, 3\) is needed, not \(2, 2\)"),
        (np.zeros(3), None, 5, ValueError, r"points: an array of shape \(N, 3\) is needed, not \(3,\)"),
        (np.zeros((1, 1, 3)), None, 5, ValueError, "points: an array of shape"),
        (np.zeros((2, 3)), np.zeros((3, 3)), 5, ValueError, "normals: 3 rows for 2 points"),
        (np.zeros((2, 3)), np.zeros((2, 4)), 5, ValueError, "normals: an array of shape"),
        (np.zeros((2, 3), complex), None, 5, TypeError, "points: real numbers are needed, not an array of complex128"),
        (np.zeros((2, 3), bool), None, 5, TypeError, "points: real numbers"),
        (np.array([["a", "b", "c"]]), None, 5, TypeError, "points: real numbers"),
        (np.array([[None, None, None]]), None, 5, TypeError, "points: real numbers"),
        (np.zeros((2, 3)), None, 4, ValueError, "the filter's width: 4 is out of range; it must be 1, 3, 5, 9 or 17"),
        (np.zeros((2, 3)), None, -1, ValueError, "filter: -1 is out of range"),
        (np.zeros((2, 3)), None, 5.0, TypeError, "filter: a whole number is needed"),
    ],
)
def test_errors_name_wrong_arrays(
    points: NDArray[Any], normals: NDArray[Any] | None, filter: int, error: type, message: str, shadows: adumbra.ShadowFile
) -> None:
    with pytest.raises(error, match=message):
        shadows.visibility(points, normals, filter)


def test_the_native_part_refuses_wrong_shapes_too(shadows: adumbra.ShadowFile, scene: adumbra.Scene) -> None:
    native, traced = shadows._native, scene._native
    look_up = (5, (None, None, None))
    good = np.zeros((4, 3))
    for points, normals in [(np.zeros((3, 4)), None), (np.zeros((4, 6))[:, ::2], None), (good, np.zeros((3, 3)))]:
        with pytest.raises(ValueError):
            native.visibility((points, normals), look_up, None)
        with pytest.raises(ValueError):
            traced.sunlit(((points, normals), 0.0), np.ones((1, 3)), None)
        with pytest.raises(ValueError):
            traced.visibility(((points, normals), 0.0), np.ones((1, 3)), 0.53, None)
    with pytest.raises(ValueError):
        traced.sunlit(((good, None), 0.0), np.ones((3, 1)), None)
    with pytest.raises(ValueError, match="vertex 9"):
        adumbra._native.Scene.from_arrays(good, np.full((1, 3), 9, np.uint32), np.zeros(0, np.float32), "y")
    with pytest.raises(ValueError, match="2 numbers for 1 triangles"):
        adumbra._native.Scene.from_arrays(good, np.zeros((1, 3), np.uint32), np.zeros(2, np.float32), "y")


def test_verify_figures_match_the_program(city: Path, program: Program, tmp_path: Path) -> None:
    path = tmp_path / "city.adumbra"
    baked = adumbra.bake(city, to_sun=SUN, resolution=2048, assume_ground=False, output=path)
    cases: list[tuple[dict[str, Any], list[Any]]] = [
        ({}, []),
        ({"filter": 5, "seed": 3, "threads": 1}, ["--filter", 5, "--seed", 3]),
        ({"volume": True, "min_interior": 1.0, "bias_slope": 1}, ["--volume", "--min-interior", 1, "--bias-slope", 1]),
    ]
    for options, words in cases:
        printed = json.loads(program("verify", path, "--scene", city, "--samples", 20_000, "--json", *words))
        found = baked.verify(city, samples=20_000, **options)
        classes = printed["classes"]
        figures = [field.name for field in fields(found) if field.name not in ("classes", "checked", "passed")]
        assert {name: printed[name] for name in figures} == {name: getattr(found, name) for name in figures}
        for row, of_class in zip(classes, found.classes, strict=True):
            assert (row.pop("class"), row.pop("holds")) == (of_class.name, of_class.passed)
            assert row == {name: getattr(of_class, name) for name in row}
        assert found.checked
        assert found.passed == all(of_class.passed for of_class in found.classes)


def test_verify_rejects_bad_options_few_points_and_wrong_scenes(
    mesh: Mesh, scene: adumbra.Scene, shadows: adumbra.ShadowFile
) -> None:
    for options, message in [
        ({"volume": True}, "bake it with assume_ground=False"),
        ({"samples": 0}, "samples: 0 is out of range; it must be from 1 to 1000000000"),
        ({"seed": -1}, "seed: -1 is out of range"),
        ({"min_interior": 2.0}, "min_interior: 2.0 is out of range"),
        ({"filter": 2}, "the filter's width"),
    ]:
        with pytest.raises(ValueError, match=message):
            shadows.verify(scene, **options)  # type: ignore[arg-type]
    few = shadows.verify(scene, samples=10)
    assert not few.checked and not few.passed
    assert "too few points" in few._repr_html_()
    assert shadows.verify(scene, samples=20_000).passed
    other = adumbra.bake(scene, to_sun=(-0.5, 0.8, 0.35), resolution=1024)
    moved = adumbra.Scene.from_arrays(mesh[0] + (5.0, 0.0, 0.0), mesh[1], up="y")
    assert not other.verify(moved, samples=20_000).passed


def test_notebooks_show_the_figures_of_a_verification(scene: adumbra.Scene, shadows: adumbra.ShadowFile) -> None:
    found = shadows.verify(scene, samples=20_000)
    shown = found._repr_html_()
    points = next(of_class.points for of_class in found.classes if of_class.name == "interior")
    for figure in (f"{found.samples:,}", f"{100 * found.agreement:.4f} %", f"interior, {points:,} points", "<td>yes</td>"):
        assert figure in shown
