"""Scenes."""

from __future__ import annotations

import os
import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal, TypedDict, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._arrays import triples, whole
from ._errors import SceneWarning

if TYPE_CHECKING:
    from typing_extensions import Unpack


class LoadOptions(TypedDict, total=False):
    """Options of everything that loads a scene from a file."""

    only: Sequence[str]
    """Load only triangles of nodes, meshes or materials whose name matches one of these patterns."""
    exclude: Sequence[str]
    """Skip triangles of nodes, meshes or materials whose name matches one of these patterns."""
    ignore_alpha: bool
    """Treat masked and blended materials as opaque."""
    include_animated: bool
    """Load animated instances as static ones, in their first pose. Without it they are skipped."""
    up: Literal["y", "z"] | None
    """The axis that points up in an OBJ or PLY file. With ``"z"`` the scene is turned: its (x, y, z) is (x, z, -y) in the world, in
    which Y points up. ``None`` takes Y, and warns if the scene looks otherwise. glTF is Y up by definition."""
    allow_outside: bool
    """Also read files outside the scene's folder. Only for scenes that you trust."""
    strict: bool
    """Reject a scene if the loader would leave anything out."""


class Scene:
    """A scene: triangles, loaded once for any number of bakes and rays.

    Every function that needs a scene takes a path too, or vertices and faces, and loads them itself.
    """

    def __init__(self, native: _native.Scene) -> None:
        self._native = native

    @classmethod
    def load(cls, path: str | os.PathLike[str], **options: Unpack[LoadOptions]) -> Scene:
        """Load a scene from a ``.glb``, ``.gltf``, ``.obj`` or ``.ply`` file.

        Args:
            path: The file.
            **options: See :class:`LoadOptions`.

        Returns:
            The scene.

        Warns:
            SceneWarning: Parts of the file were left out or changed.

        Raises:
            OSError: A file cannot be read; ``FileNotFoundError`` if there is none.
            FormatError: The scene is broken, or holds nothing that casts a shadow.
            ValueError: The ending is unknown, or a pattern is wrong.
            AdumbraError: The scene names files outside its folder, needs an extension that is not read, or takes too much memory.
        """
        native = _native.Scene.load(os.fspath(path), {**loading_of(dict(options)), "max_memory": None})
        for note in native.notes:
            warnings.warn(f"{os.fspath(path)}: {note}", SceneWarning, stacklevel=2)
        return cls(native)

    @classmethod
    def from_mesh(cls, vertices: ArrayLike, faces: ArrayLike) -> Scene:
        """Make a scene of triangles.

        Args:
            vertices: Positions in world space, shape (N, 3), of any real type. They are kept in single precision, relative to
                an origin near them if they are far from 0.
            faces: The vertices of each triangle, shape (M, 3), of any integer type. Triangles without area are skipped.

        Returns:
            The scene: one opaque mesh.

        Raises:
            ValueError: A shape is wrong, an index is out of range, a vertex is not finite, or nothing casts a shadow.
            TypeError: The vertices are not real numbers, or the faces are not integers.
        """
        positions = triples("vertices", vertices, double=True)
        corners = np.asarray(faces)
        if corners.dtype.kind not in "iu":
            raise TypeError(f"faces: integers are needed, not an array of {corners.dtype}")
        if corners.ndim != 2 or corners.shape[1] != 3:
            raise ValueError(f"faces: an array of shape (M, 3) is needed, not {corners.shape}")
        if corners.size and not (corners.min() >= 0 and corners.max() < len(positions)):
            row, column = np.argwhere((corners < 0) | (corners >= len(positions)))[0]
            raise ValueError(
                f"faces[{row}, {column}] is {corners[row, column]}, which is out of range; it must be from 0 to "
                f"{len(positions) - 1}, because there are {len(positions)} vertices"
            )
        used = positions[corners.ravel()] if corners.size else positions[:0]
        if not np.isfinite(used).all():
            row = corners.ravel()[np.argwhere(~np.isfinite(used).all(axis=1))[0, 0]]
            raise ValueError(f"vertices[{row}] is {positions[row]}, but a vertex that a face uses must be finite")
        return cls(_native.Scene.from_mesh(positions, np.require(corners, np.uint32, ["C", "A"])))

    @property
    def bounds(self) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
        """The smallest and the largest coordinates, in world units."""
        low, high = self._native.bounds
        return (low[0], low[1], low[2]), (high[0], high[1], high[2])

    @property
    def triangles(self) -> int:
        """The number of triangles, counting every instance."""
        return self._native.triangles

    @property
    def sun(self) -> tuple[float, float, float]:
        """The unit vector towards the sun that a bake uses by default.

        It is that of the scene's first directional light that shines and is above the horizon, or else of (0.5, 0.8, 0.35).
        """
        x, y, z = self._native.sun
        return x, y, z

    def mesh(self) -> tuple[NDArray[np.float64], NDArray[np.uint32]]:
        """Return all triangles in world space: vertices of shape (N, 3) and faces of shape (M, 3).

        Raises:
            ValueError: The instances have more than 2**32 vertices.
        """
        return self._native.mesh()

    def __repr__(self) -> str:
        return f"<adumbra.Scene of {self.triangles} triangles from {self.bounds[0]} to {self.bounds[1]}>"


SceneLike = Union[Scene, str, "os.PathLike[str]", "tuple[ArrayLike, ArrayLike]"]
"""A scene, the path of its file, or vertices and faces."""


def scene_of(scene: Any, faces: ArrayLike | None, options: dict[str, Any]) -> Scene:
    """Return a scene: load it from its path, or make it from its triangles."""
    if isinstance(scene, (str, os.PathLike)):
        if faces is not None:
            raise TypeError("faces: they belong to vertices, but the scene is a path")
        return Scene.load(scene, **options)
    if options:
        raise TypeError(f"{sorted(options)[0]}: this is an option of loading, but the scene is not a path")
    if isinstance(scene, Scene):
        if faces is not None:
            raise TypeError("faces: they belong to vertices, but the scene has been loaded")
        return scene
    if faces is not None:
        return Scene.from_mesh(scene, faces)
    if isinstance(scene, tuple) and len(scene) == 2:
        return Scene.from_mesh(scene[0], scene[1])
    raise TypeError("scene: give a path, a Scene, or vertices and faces")


def as_baked(scene: Any, options: dict[str, Any], up: str) -> dict[str, Any]:
    """Return loading options, with a shadow file's up axis if the scene is a path of a format without one."""
    is_open = options.get("up") is None and isinstance(scene, (str, os.PathLike))
    has_none = is_open and not os.fsdecode(scene).lower().endswith((".glb", ".gltf"))
    return {**options, "up": up} if has_none else options


def loading_of(options: dict[str, Any]) -> dict[str, Any]:
    """Return the options of the loader as the native part takes them."""
    unknown = sorted(options.keys() - LoadOptions.__annotations__.keys())
    if unknown:
        raise TypeError(f"{unknown[0]!r} is not an option; the loader has {', '.join(LoadOptions.__annotations__)}")
    up = options.get("up")
    if up not in (None, "y", "z"):
        raise ValueError(f"up: {up!r} is not an axis; it must be 'y' or 'z'")
    return {
        "only": _patterns("only", options.get("only", ())),
        "exclude": _patterns("exclude", options.get("exclude", ())),
        "ignore_alpha": bool(options.get("ignore_alpha", False)),
        "include_animated": bool(options.get("include_animated", False)),
        "up": up,
        "allow_outside": bool(options.get("allow_outside", False)),
        "strict": bool(options.get("strict", False)),
    }


def _patterns(name: str, patterns: Sequence[str]) -> list[str]:
    if isinstance(patterns, str):
        raise TypeError(f"{name}: give a list of patterns, such as [{patterns!r}]")
    return list(patterns)


def threads_of(threads: int | None) -> int | None:
    """Return a number of threads within its range."""
    return None if threads is None else whole("threads", threads, 1, 1024)
