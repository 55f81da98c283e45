"""Scenes: loading, its options and warnings, and errors."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from conftest import Mesh

import adumbra

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n"


def test_loaded_scene_bakes_like_its_path(city: Path) -> None:
    scene = adumbra.Scene.load(city)
    assert scene.triangles == 148_276
    assert scene.sun == pytest.approx(np.array((0.5, 0.8, 0.35)) / np.linalg.norm((0.5, 0.8, 0.35)))
    vertices, faces = scene.mesh()
    assert faces.shape == (148_276, 3)
    assert faces.dtype == np.uint32 and vertices.dtype == np.float64
    assert (tuple(vertices[faces].min((0, 1))), tuple(vertices[faces].max((0, 1)))) == scene.bounds
    assert adumbra.bake(scene, resolution=512) == adumbra.bake(str(city), resolution=512)
    assert "148276 triangles" in repr(scene)


def test_scene_returns_the_mesh_it_was_made_from(mesh: Mesh) -> None:
    scene = adumbra.Scene.from_mesh(*mesh)
    vertices, faces = scene.mesh()
    assert np.array_equal(vertices[faces], mesh[0].astype(np.float32)[mesh[1]])
    assert scene.bounds[0] == (0.0, 0.0, 0.0)


def test_omissions_are_warnings_or_errors_if_strict(tmp_path: Path) -> None:
    path = tmp_path / "lines.obj"
    path.write_text(TRIANGLE + "l 1 2\nf 1 1 2\n")
    with pytest.warns(adumbra.SceneWarning) as caught:
        scene = adumbra.Scene.load(path)
    said = " ".join(str(warning.message) for warning in caught)
    assert "lines.obj" in said and "left out" in said and "1 degenerate triangles skipped" in said
    assert scene.triangles == 1
    with pytest.raises(adumbra.AdumbraError, match="not all of it can be loaded"):
        adumbra.Scene.load(path, strict=True)


def test_broken_scenes_are_refused(tmp_path: Path) -> None:
    for name, text, error, message in [
        ("a.glb", "glTF but not really", adumbra.FormatError, "not a valid glTF file"),
        ("a.ply", "ply\n", adumbra.FormatError, "not a valid PLY file"),
        ("a.obj", "v 0 0 0\nf 1 2 3\n", adumbra.FormatError, "a.obj"),
        ("b.obj", "v 0 0 0\n", adumbra.FormatError, "contains no triangles"),
        ("c.obj", TRIANGLE.replace("1 0 0", "nan 0 0"), adumbra.FormatError, "c.obj"),
        ("a.stl", "solid", ValueError, "unknown scene format; give a .glb, .gltf, .obj or .ply file"),
    ]:
        path = tmp_path / name
        path.write_text(text)
        for use in (adumbra.bake, adumbra.rays, adumbra.Scene.load):
            with pytest.raises(error, match=message):
                use(path)
    for use in (adumbra.bake, adumbra.rays, adumbra.Scene.load):
        with pytest.raises(FileNotFoundError) as missing:
            use(tmp_path / "none.glb")
        assert missing.value.filename == str(tmp_path / "none.glb")


def test_options_of_loading_are_checked(city: Path, mesh: Mesh) -> None:
    with pytest.raises(ValueError, match="is not a valid glob"):
        adumbra.Scene.load(city, only=["["])
    with pytest.raises(ValueError, match="after the name filter"):
        adumbra.Scene.load(city, only=["no such name"])
    with pytest.raises(TypeError, match=r"only: give a list of patterns, such as \['a'\]"):
        adumbra.Scene.load(city, only="a")
    with pytest.raises(TypeError, match="'onyl' is not an option"):
        adumbra.Scene.load(city, onyl=["a"])  # type: ignore[call-arg]
    with pytest.raises(TypeError, match="the scene is a path"):
        adumbra.bake(city, mesh[1])
    with pytest.raises(TypeError, match="has been loaded"):
        adumbra.bake(adumbra.Scene.from_mesh(*mesh), mesh[1])
    with pytest.raises(TypeError, match="give a path, a Scene, or vertices and faces"):
        adumbra.bake(mesh[0])
