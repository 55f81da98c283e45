"""Scenes: loading, its options and warnings, arrays, meshes of other packages, pickles, and errors."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import SUN, Mesh, boxes

import adumbra

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n"

# Two level triangles, 3 m above the ground, east and west of x = 0.
CORNERS = [[0, 0, 3], [4, 0, 3], [0, 4, 3], [-4, 0, 3]]
FACES = [[0, 1, 2], [0, 2, 3]]
BELOW = [[1, 1, 0], [-1, 1, 0]]

USES: list[Callable[[Path], object]] = [adumbra.bake, adumbra.Scene]


def test_loaded_scene_bakes_like_its_path(city: Path) -> None:
    scene = adumbra.Scene(city)
    assert (scene.triangles, scene.up, scene.warnings) == (148_276, "y", ())
    assert scene.to_sun == pytest.approx(np.array((0.5, 0.8, 0.35)) / np.linalg.norm((0.5, 0.8, 0.35)))
    vertices, faces = scene.mesh()
    assert faces.shape == (148_276, 3)
    assert faces.dtype == np.uint32 and vertices.dtype == np.float64
    assert (tuple(vertices[faces].min((0, 1))), tuple(vertices[faces].max((0, 1)))) == scene.bounds
    assert adumbra.bake(scene, resolution=512) == adumbra.bake(str(city), resolution=512)
    assert "148276 triangles" in repr(scene)


def test_scene_returns_the_mesh_it_was_made_from(mesh: Mesh, scene: adumbra.Scene) -> None:
    vertices, faces = scene.mesh()
    assert np.array_equal(vertices[faces], mesh[0].astype(np.float32)[mesh[1]])
    assert scene.bounds[0] == (0.0, 0.0, 0.0)
    assert (scene.triangles, scene.up, scene.warnings) == (len(mesh[1]), "y", ())


def test_omissions_are_warnings_or_errors_if_strict(tmp_path: Path) -> None:
    path = tmp_path / "lines.obj"
    path.write_text(TRIANGLE + "l 1 2\nf 1 1 2\n")
    with pytest.warns(adumbra.SceneWarning) as caught:
        scene = adumbra.Scene(path)
    said = " ".join(str(warning.message) for warning in caught)
    assert "lines.obj" in said and "left out" in said and "1 degenerate triangles skipped" in said
    assert all(text in said for text in scene.warnings) and len(scene.warnings) == len(caught)
    assert scene.triangles == 1
    with pytest.raises(adumbra.AdumbraError, match="not all of it can be loaded"):
        adumbra.Scene(path, strict=True)


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
        for use in USES:
            with pytest.raises(error, match=message):
                use(path)
    for use in USES:
        with pytest.raises(FileNotFoundError) as missing:
            use(tmp_path / "none.glb")
        assert missing.value.filename == str(tmp_path / "none.glb")


def test_options_of_loading_are_checked(city: Path, mesh: Mesh) -> None:
    with pytest.raises(ValueError, match="is not a valid glob"):
        adumbra.Scene(city, only=["["])
    with pytest.raises(ValueError, match="after the name filter"):
        adumbra.Scene(city, only=["no such name"])
    with pytest.raises(TypeError, match=r"only: give a list of patterns, such as \['a'\]"):
        adumbra.Scene(city, only="a")
    with pytest.raises(TypeError, match="'onyl' is not an option"):
        adumbra.Scene(city, onyl=["a"])  # type: ignore[call-arg]
    wrong: Any = "x"
    with pytest.raises(ValueError, match="up: 'x' is not an axis; it must be 'y' or 'z'"):
        adumbra.Scene(city, up=wrong)
    with pytest.raises(ValueError, match="up: 'x' is not an axis"):
        adumbra.Scene.from_arrays(*mesh, up=wrong)


def test_arrays_in_place_of_a_scene_are_refused_with_the_remedy(mesh: Mesh, shadows: adumbra.ShadowFile) -> None:
    arrays: list[Any] = [mesh, mesh[0]]
    for given in arrays:
        remedy = rf"not a {type(given).__name__}; Scene.from_arrays\(vertices, faces, up=…\)"
        with pytest.raises(TypeError, match=f"give a path or an adumbra.Scene, {remedy}"):
            adumbra.bake(given)
        with pytest.raises(TypeError, match=remedy):
            shadows.verify(given)
        with pytest.raises(TypeError, match=remedy):
            adumbra.sky(given, [[0, 1, 0]])


def test_faces_with_low_alpha_cast_nothing() -> None:
    plain = adumbra.Scene.from_arrays(CORNERS, FACES, up="z")
    assert plain.sunlit(BELOW, None, [0, 0, 1]).tolist() == [False, False]
    cases: list[tuple[Any, list[bool]]] = [
        ([1, 0.49], [False, True]),
        ([0.0, 0.5], [True, False]),
        (np.array([True, False]), [False, True]),
    ]
    for alpha, lit in cases:
        scene = adumbra.Scene.from_arrays(CORNERS, FACES, up="z", alpha=alpha)
        assert scene.triangles == 1
        assert scene.sunlit(BELOW, None, [0, 0, 1]).tolist() == lit
        assert scene.visibility(BELOW, None, [0, 0, 1]).tolist() == lit
    assert adumbra.Scene.from_arrays(CORNERS, FACES, up="z", alpha=np.full(2, 0.5, np.float32)).triangles == 2


def test_wrong_shares_are_refused() -> None:
    wrong: list[tuple[Any, type[Exception], str]] = [
        ([1], ValueError, r"alpha: an array of shape \(2,\) is needed, one number for each face, not \(1,\)"),
        (0.5, ValueError, r"alpha: an array of shape \(2,\)"),
        ([[1], [1]], ValueError, r"alpha: an array of shape \(2,\)"),
        ([1, 1.5], ValueError, "alpha: a number is out of range; they must be from 0 to 1"),
        ([-0.1, 1], ValueError, "alpha: a number is out of range"),
        ([np.nan, 1], ValueError, "alpha: a number is out of range"),
        (["a", "b"], TypeError, "alpha: real numbers are needed"),
    ]
    for values, error, message in wrong:
        with pytest.raises(error, match=message):
            adumbra.Scene.from_arrays(CORNERS, FACES, up="z", alpha=values)
        with pytest.raises(error, match=message.replace("alpha", "transmissivity")):
            adumbra.Scene.from_arrays(CORNERS, FACES, up="z", transmissivity=values)
    with pytest.raises(ValueError, match="contains no triangles"):
        adumbra.Scene.from_arrays(CORNERS, FACES, up="z", alpha=[0, 0.4])


def test_crowns_let_their_share_of_light_through() -> None:
    crowns: dict[str, Any] = {"up": "z", "transmissivity": [0.25, 0.5]}
    scene = adumbra.Scene.from_arrays(CORNERS, FACES, **crowns)
    assert scene.visibility(BELOW, None, [0, 0, 1]).tolist() == [0.25, 0.5]
    assert scene.sunlit(BELOW, None, [0, 0, 1]).tolist() == [False, False]
    again = pickle.loads(pickle.dumps(scene))
    assert again.visibility(BELOW, None, [0, 0, 1]).tolist() == [0.25, 0.5]
    half = adumbra.Scene.from_arrays(CORNERS, FACES, **crowns, alpha=[0, 1])
    assert half.visibility(BELOW, None, [0, 0, 1]).tolist() == [1.0, 0.5]
    # The faces of a closed crown count once, and an opaque roof above them lets nothing through.
    vertices, faces = boxes(np.array([[0.0, 0.0, 2.0], [1.0, 0.0, 9.0]]), np.array([[2.0, 2.0, 2.0], [1.0, 2.0, 1.0]]))
    tree = adumbra.Scene.from_arrays(vertices, faces, up="z", transmissivity=np.repeat([0.125, 0.0], 12))
    assert tree.visibility([[0.5, 1.0, 0.0], [1.5, 1.0, 0.0], [5.0, 1.0, 0.0]], None, [0, 0, 1]).tolist() == [0.125, 0.0, 1.0]


def test_a_baked_crown_is_opaque() -> None:
    corners = [*CORNERS, [-9, -9, 0], [9, -9, 0], [9, 9, 0], [-9, 9, 0]]
    faces = [*FACES, [4, 5, 6], [4, 6, 7]]
    opaque = adumbra.Scene.from_arrays(corners, faces, up="z")
    crowns = adumbra.Scene.from_arrays(corners, faces, up="z", transmissivity=[0.03, 0.9, 0, 0])
    files = [adumbra.bake(scene, to_sun=(0, 0, 1), resolution=256) for scene in (opaque, crowns)]
    for shadows in files:
        assert shadows.visibility([*BELOW, [3, 3, 0]]).tolist() == [0.0, 0.0, 1.0]


class System:
    """A coordinate reference system, as those of rasterio and pyproj."""

    def __init__(self, name: str, is_geographic: bool) -> None:
        self.name, self.is_geographic = name, is_geographic

    def __str__(self) -> str:
        return self.name


def test_a_reference_system_in_degrees_is_refused() -> None:
    def from_heights(crs: Any) -> adumbra.Scene:
        return adumbra.Scene.from_heights(np.ones((2, 2)), 1, walls=True, crs=crs)

    def from_arrays(crs: Any) -> adumbra.Scene:
        return adumbra.Scene.from_arrays(CORNERS, FACES, up="z", crs=crs)

    for make in (from_heights, from_arrays):
        assert make(System("EPSG:25832", False)).triangles > 0
        with pytest.raises(ValueError, match="crs: EPSG:4326 is in degrees; project the coordinates to a system in metres first"):
            make(System("EPSG:4326", True))
        with pytest.raises(TypeError, match=r"crs: give one of rasterio or pyproj, such as pyproj.CRS\('EPSG:25832'\), not a str"):
            make("EPSG:25832")


PADDED = np.array([3, 0, 1, 2, 3, 0, 2, 3])
"""The two triangles as PyVista lists them."""


def test_padded_lists_of_faces_are_taken() -> None:
    expected = adumbra.Scene.from_arrays(CORNERS, FACES, up="z").mesh()
    forms: list[Any] = [PADDED, PADDED.astype(np.int32), PADDED.tolist()]
    for faces in forms:
        found = adumbra.Scene.from_arrays(CORNERS, faces, up="z").mesh()
        assert np.array_equal(found[0], expected[0]) and np.array_equal(found[1], expected[1])
    for wrong in ([4, 0, 1, 2, 3], [3, 0, 1, 2, 2, 0, 2, 3], [3, 0, 1, 2, 3]):
        with pytest.raises(ValueError, match=r"faces: an array of shape \(M, 3\) is needed, .* triangulate other polygons first"):
            adumbra.Scene.from_arrays(CORNERS, wrong, up="z")


class Trimesh:
    """Has what ``trimesh.Trimesh`` has."""

    vertices = np.array(CORNERS, np.float64)
    faces = np.array(FACES)


class TrimeshScene:
    """Has what ``trimesh.Scene`` has."""

    def to_mesh(self) -> Trimesh:
        return Trimesh()


class PolyData:
    """Has what ``pyvista.PolyData`` has: a quadrilateral, until it is triangulated."""

    points = np.array(CORNERS, np.float32)
    faces = np.array([4, 0, 1, 2, 3])
    is_all_triangles = False

    def extract_surface(self) -> PolyData:
        raise AssertionError("it is a surface already")

    def triangulate(self) -> PolyData:
        done = PolyData()
        done.faces = PADDED
        return done


class Grid:
    """Has what ``pyvista.UnstructuredGrid`` has."""

    def extract_surface(self) -> PolyData:
        return PolyData()


def test_meshes_of_other_packages_are_taken() -> None:
    expected = adumbra.Scene.from_arrays(CORNERS, FACES, up="z").mesh()
    for scene in (
        adumbra.Scene.from_trimesh(Trimesh(), up="z"),
        adumbra.Scene.from_trimesh(TrimeshScene(), up="z"),
        adumbra.Scene.from_pyvista(PolyData(), up="z"),
        adumbra.Scene.from_pyvista(Grid(), up="z"),
    ):
        found = scene.mesh()
        assert np.array_equal(found[0], expected[0]) and np.array_equal(found[1], expected[1])
        assert scene.up == "z"


def test_meshes_and_scenes_of_trimesh_are_taken() -> None:
    trimesh = pytest.importorskip("trimesh")
    box = trimesh.creation.box(extents=(2, 3, 4))
    one = adumbra.Scene.from_trimesh(box, up="z")
    assert (one.triangles, one.bounds) == (12, ((-1, -1.5, -2), (1, 1.5, 2)))
    several = trimesh.Scene()
    for x in (0, 10):
        several.add_geometry(box, transform=trimesh.transformations.translation_matrix((x, 0, 2)))
    both = adumbra.Scene.from_trimesh(several, up="z")
    assert (both.triangles, both.bounds) == (24, ((-1, -1.5, 0), (11, 1.5, 4)))
    assert both.sunlit(np.array([[4.5, 0, 0], [2, 0, 0]]), None, [1, 0, 1]).tolist() == [True, True]
    assert both.sunlit([[8, 0, 0], [-2, 0, 0]], None, [1, 0, 1]).tolist() == [False, False]


@pytest.mark.slow
def test_data_sets_of_pyvista_are_taken() -> None:
    pyvista = pytest.importorskip("pyvista")
    ball = adumbra.Scene.from_pyvista(pyvista.Sphere(radius=2.0), up="z")
    assert ball.triangles == 1680
    box = pyvista.Box((0, 1, 0, 2, 0, 3))
    image = pyvista.ImageData(dimensions=(2, 3, 4))
    for mesh in (box, image, image.cast_to_unstructured_grid(), pyvista.MultiBlock([box])):
        scene = adumbra.Scene.from_pyvista(mesh, up="z")
        assert scene.bounds == ((0, 0, 0), (1, 2, 3))
        assert scene.sunlit([[0.5, 1.0, -1.0], [5.0, 1.0, -1.0]], None, [0, 0, 1]).tolist() == [False, True]
    assert adumbra.Scene.from_pyvista(pyvista.Sphere().strip(), up="z").triangles == 1680


@pytest.mark.slow
def test_reference_systems_of_pyproj_and_rasterio_are_taken() -> None:
    pyproj, rasterio = pytest.importorskip("pyproj"), pytest.importorskip("rasterio.crs")
    for of in (pyproj.CRS.from_epsg, rasterio.CRS.from_epsg):
        assert adumbra.Scene.from_arrays(CORNERS, FACES, up="z", crs=of(25832)).triangles == 2
        with pytest.raises(ValueError, match="crs: EPSG:4326 is in degrees"):
            adumbra.Scene.from_arrays(CORNERS, FACES, up="z", crs=of(4326))


def test_objects_that_are_no_meshes_are_refused() -> None:
    with pytest.raises(TypeError, match="mesh: a dict has no vertices and faces"):
        adumbra.Scene.from_trimesh({}, up="y")
    with pytest.raises(TypeError, match="mesh: a Trimesh is no data set of pyvista"):
        adumbra.Scene.from_pyvista(Trimesh(), up="y")


@pytest.mark.parametrize("up", ["y", "z"])
def test_scenes_of_arrays_can_be_pickled(up: Any, mesh: Mesh) -> None:
    alpha = np.ones(len(mesh[1]))
    alpha[:12] = 0
    scene = adumbra.Scene.from_arrays(*mesh, up=up, alpha=alpha)
    again = pickle.loads(pickle.dumps(scene))
    assert (again.up, again.triangles, again.bounds) == (up, len(mesh[1]) - 12, scene.bounds)
    expected, found = scene.mesh(), again.mesh()
    assert np.array_equal(found[0], expected[0]) and np.array_equal(found[1], expected[1])
    assert adumbra.bake(again, to_sun=SUN, resolution=256) == adumbra.bake(scene, to_sun=SUN, resolution=256)


def test_scenes_of_files_are_loaded_again_when_they_are_unpickled(tmp_path: Path) -> None:
    path = tmp_path / "lines.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 1\nf 1 2 3\nl 1 2\no other\nf 1 3 2\n")
    with pytest.warns(adumbra.SceneWarning):
        scene = adumbra.Scene(path, up="z", exclude=["other"])
    # The warnings have been shown, and are errors in these tests.
    again = pickle.loads(pickle.dumps(scene))
    assert (again.up, again.triangles, again.bounds) == ("z", 1, scene.bounds)
    assert again.warnings == scene.warnings != ()


def test_notebooks_show_the_figures_of_a_scene(tmp_path: Path, mesh: Mesh, scene: adumbra.Scene) -> None:
    shown = scene._repr_html_()
    for figure in ("adumbra.Scene", f"<td>{len(mesh[1])}</td>", "<td>y</td>", "<td>0, 0, 0</td>", " × "):
        assert figure in shown
    path = tmp_path / "lines.obj"
    path.write_text(TRIANGLE + "l 1 2\n")
    with pytest.warns(adumbra.SceneWarning):
        lines = adumbra.Scene(path)
    assert "left out" in lines._repr_html_()
