"""Scenes, and rays through them."""

from __future__ import annotations

import os
import warnings
from inspect import signature
from typing import TYPE_CHECKING, Any, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._arrays import numbers, origins_of, plain, threads_of, triples
from ._axes import Up, Vector, axis_of
from ._errors import SceneWarning, warn
from ._loading import LoadOptions, loading_of
from ._show import table
from ._sun import SunPath

if TYPE_CHECKING:
    from typing_extensions import Unpack

class Scene:
    """A scene: triangles, loaded once for any number of bakes and rays.

    All coordinates are those of its file or arrays, in which :attr:`up` points up. Where Y points up, north is -Z; where Z points
    up, north is +Y; east is +X. The unit of length is the scene's own; where a unit is needed, it is called a metre.

    A scene never changes, may be used from any number of threads, and can be pickled. One of a file is loaded again when it is
    unpickled.

        >>> import numpy as np
        >>> import adumbra
        >>> roof = np.array([[0, 0, 3], [4, 0, 3], [4, 4, 3], [0, 4, 3]])
        >>> scene = adumbra.Scene.from_arrays(roof, [[0, 1, 2], [0, 2, 3]], up="z")
        >>> scene.sunlit([[2, 2, 0], [9, 2, 0]], None, [0, 0, 1])
        array([False,  True])
    """

    def __init__(self, path: str | os.PathLike[str], **options: Unpack[LoadOptions]) -> None:
        """Load a scene from a ``.glb``, ``.gltf``, ``.obj`` or ``.ply`` file.

        Args:
            path: The file.
            **options: See :class:`LoadOptions`.

        Warns:
            SceneWarning: Parts of the file were left out or changed; :attr:`warnings` has the texts.

        Raises:
            OSError: A file cannot be read; ``FileNotFoundError`` if there is none.
            FormatError: The scene is broken, or holds nothing that casts a shadow.
            ValueError: The ending is unknown, or a pattern is wrong.
            AdumbraError: The scene names files outside its folder, needs an extension that is not read, or takes too much memory.
        """
        self._native = _native.Scene.load(os.fspath(path), loading_of(dict(options)))
        self._source: tuple[Any, ...] = (_loaded, os.path.abspath(path), dict(options))
        for note in self._native.notes:
            warn(f"{os.fspath(path)}: {note}")

    @classmethod
    def from_arrays(
        cls,
        vertices: ArrayLike,
        faces: ArrayLike,
        *,
        up: Up,
        alpha: ArrayLike | None = None,
        transmissivity: ArrayLike | None = None,
        crs: Any = None,
    ) -> Scene:
        """Make a scene of triangles.

        Args:
            vertices: Positions, shape (N, 3), of any real type. They are kept in single precision, relative to an origin near
                them if they are far from 0.
            faces: The vertices of each triangle, shape (M, 3), of any integer type, or PyVista's list of faces, shape (4 M,), with
                a 3 before each triangle. Triangles without area are skipped.
            up: The axis that points up: ``"y"`` or ``"z"``.
            alpha: Opacity of each triangle, shape (M,), 0 to 1. Those below 0.5 cast no shadow.
            transmissivity: Share of the sun's light that passes through each triangle, shape (M,), 0 to 1; about 0.03 for the
                crown of a tree in leaf and 0.5 for a bare one. Where the sun's rays pass through several triangles, the smallest
                counts, once. Only :meth:`visibility` weighs it: :meth:`sunlit`, hours of sun and bakes take all triangles as opaque.
            crs: The coordinate reference system of the vertices, of ``rasterio`` or ``pyproj``, to check that it is projected.

        Raises:
            ValueError: A shape is wrong, an index is out of range, a vertex is not finite, nothing casts a shadow, or the
                coordinate reference system is in degrees.
            TypeError: The vertices are not real numbers, or the faces are not integers.

        Warns:
            SceneWarning: The coordinates look like degrees of longitude and latitude with heights in metres.
        """
        positions = triples("vertices", vertices, double=True)
        corners = _corners_of(faces)
        if corners.size and not (corners.min() >= 0 and corners.max() < len(positions)):
            row, column = np.argwhere((corners < 0) | (corners >= len(positions)))[0]
            raise ValueError(
                f"faces[{row}, {column}] is {corners[row, column]}, which is out of range; it must be from 0 to "
                f"{len(positions) - 1}, because there are {len(positions)} vertices"
            )
        shares = np.zeros(0, np.float32)
        if transmissivity is not None:
            shares = _shares_of("transmissivity", transmissivity, len(corners)).astype(np.float32)
        if alpha is not None:
            is_kept = _shares_of("alpha", alpha, len(corners)) >= 0.5
            corners, shares = corners[is_kept], shares[is_kept] if shares.size else shares
        if not np.isfinite(positions).all():
            is_used = np.zeros(len(positions), bool)
            is_used[corners.ravel()] = True
            wrong = is_used & ~np.isfinite(positions).all(axis=1)
            if wrong.any():
                row = int(np.argmax(wrong))
                raise ValueError(f"vertices[{row}] is {positions[row]}, but a vertex that a face uses must be finite")
        _check_projected(crs)
        corners = np.require(corners, np.uint32, ["C", "A"])
        return cls._of(_native.Scene.from_arrays(positions, corners, shares, axis_of(up)))

    @classmethod
    def from_heights(
        cls,
        heights: ArrayLike,
        cell: float,
        *,
        walls: bool,
        corner: ArrayLike = (0.0, 0.0),
        nodata: float | None = None,
        up: Up = "z",
        crs: Any = None,
    ) -> Scene:
        """Make a scene of a raster of heights, such as a digital surface model.

        Args:
            heights: The heights, shape (rows, columns), of any real type. The first row is the northernmost, the first column the
                westernmost. Cells that are NaN or masked have no data: in them there is nothing. A cell takes about 500 bytes while
                the scene is made.
            cell: Side of a cell, which is square, in the unit of the heights, above 0.
            walls: ``True``: each cell is level, with upright walls on the borders between cells, as buildings have. ``False``: a
                surface through the centres of the cells, as for terrain.
            corner: The northwest corner of the first cell: x and y where Z points up, x and z where Y points up. For a raster of
                ``rasterio``, ``(transform.c, transform.f)`` where Z points up, and ``(transform.c, -transform.f)`` where Y does.
            nodata: The number that marks cells without data, such as -9999.
            up: The axis that points up: ``"y"`` or ``"z"``.
            crs: The coordinate reference system of the raster, of ``rasterio`` or ``pyproj``, to check that it is projected.

        Raises:
            ValueError: A shape is wrong, the cell is not above 0, there are no data, a number is infinite, or the coordinate
                reference system is in degrees.
            TypeError: The heights are not real numbers.

        Warns:
            SceneWarning: See :meth:`from_arrays`.

        Example:
            >>> import adumbra
            >>> tower = adumbra.Scene.from_heights([[0, 0, 0], [0, 5, 0], [0, 0, 0]], cell=2, walls=True)
            >>> tower.bounds
            ((0.0, -6.0, 0.0), (6.0, 0.0, 5.0))
            >>> tower.sunlit([[5, -3, 0], [1, -3, 0]], None, [1, 0, 1])
            array([ True, False])
        """
        marked: Any = heights if isinstance(heights, np.ma.MaskedArray) else np.asarray(heights)
        given = np.ma.getdata(marked)
        if given.dtype.kind not in "iuf":
            raise TypeError(f"heights: real numbers are needed, not an array of {given.dtype}")
        if given.ndim != 2:
            raise ValueError(f"heights: an array of shape (rows, columns) is needed, not {given.shape}")
        values = np.ma.filled(marked.astype(np.float64), np.nan)
        if nodata is not None:
            mark: Any = float(nodata)
            if given.dtype.kind == "f":
                # It is rounded as the heights are.
                with np.errstate(over="ignore"):
                    mark = given.dtype.type(mark)
            values[given == mark] = np.nan
        place = numbers("corner", corner, 2)
        _check_projected(crs)
        raster = np.require(values, np.float64, ["C", "A"])
        return cls._of(_native.Scene.from_heights(raster, float(cell), place, bool(walls), axis_of(up)))

    @classmethod
    def _of(cls, native: _native.Scene) -> Scene:
        """Return a scene that is not of a file."""
        scene = cls.__new__(cls)
        scene._native = native
        scene._source = (_from_arrays,)
        scene._warn_of_degrees()
        return scene

    @classmethod
    def from_trimesh(cls, mesh: Any, *, up: Up) -> Scene:
        """Make a scene of a mesh or a scene of ``trimesh``, or of anything else with ``vertices`` and ``faces``.

        Args:
            mesh: The mesh. A ``trimesh.Scene`` is taken with all its instances.
            up: The axis that points up: ``"y"`` or ``"z"``.

        Raises:
            TypeError: It has no vertices and faces.
            ValueError: See :meth:`from_arrays`.
        """
        if hasattr(mesh, "to_mesh"):
            mesh = mesh.to_mesh()
        if not (hasattr(mesh, "vertices") and hasattr(mesh, "faces")):
            raise TypeError(f"mesh: a {type(mesh).__name__} has no vertices and faces; give a mesh of trimesh")
        return cls.from_arrays(mesh.vertices, mesh.faces, up=up)

    @classmethod
    def from_pyvista(cls, mesh: Any, *, up: Up) -> Scene:
        """Make a scene of a mesh of ``pyvista``.

        Args:
            mesh: A ``PolyData``, or another data set, whose surface is taken. Its faces are triangulated.
            up: The axis that points up: ``"y"`` or ``"z"``.

        Raises:
            TypeError: It is not a data set of PyVista.
            ValueError: See :meth:`from_arrays`.
        """
        if not hasattr(mesh, "extract_surface"):
            raise TypeError(f"mesh: a {type(mesh).__name__} is no data set of pyvista; for arrays, call Scene.from_arrays")
        surface = (mesh if hasattr(mesh, "is_all_triangles") else _surface_of(mesh)).triangulate()
        return cls.from_arrays(surface.points, surface.faces, up=up)

    @property
    def bounds(self) -> tuple[Vector, Vector]:
        """The smallest and the largest coordinates."""
        low, high = self._native.bounds
        return (low[0], low[1], low[2]), (high[0], high[1], high[2])

    @property
    def triangles(self) -> int:
        """The number of triangles, counting every instance."""
        return self._native.triangles

    @property
    def up(self) -> Up:
        """The axis that points up: ``"y"`` or ``"z"``."""
        return self._native.up

    @property
    def to_sun(self) -> Vector:
        """The unit vector towards the sun that a bake uses by default.

        It is that of the scene's first directional light that shines and is above the horizon, or else a sun in the southeast, at
        an elevation of 53 degrees.
        """
        x, y, z = self._native.to_sun
        return x, y, z

    @property
    def warnings(self) -> tuple[str, ...]:
        """Sentences about what the loader left out or changed."""
        return tuple(self._native.notes)

    def mesh(self) -> tuple[NDArray[np.float64], NDArray[np.uint32]]:
        """Return all triangles: vertices of shape (N, 3) and faces of shape (M, 3).

        Raises:
            ValueError: The instances have more than 2**32 vertices.
        """
        return self._native.mesh()

    def sunlit(
        self,
        points: ArrayLike,
        normals: ArrayLike | None,
        to_sun: ArrayLike | SunPath,
        *,
        lift: float = 1e-3,
        threads: int | None = None,
    ) -> NDArray[np.bool_]:
        """Return which points see the centre of the sun, by one ray each.

        Runs on all cores; other Python threads run meanwhile. Ctrl-C stops it.

        Args:
            points: Positions, shape (N, 3), of any real type. A point that is not finite is lit.
            normals: Unit normals of the surfaces that the points are on, shape (N, 3), or ``None`` for points in the air or on
                any side of a surface. A point with a normal is dark if the sun is behind its surface.
            to_sun: The direction towards a sun, shape (3,), or towards each of T suns, shape (T, 3), of any length; or a
                :class:`SunPath`, at whose nights all points are dark.
            lift: Distance at which rays start, along the normal or else towards the sun, in the scene's unit, finite. Surfaces
                that are nearer to a point do not shadow it, so that its own does not.
            threads: Number of threads, 1 to 1024. All cores unless it is given.

        Returns:
            Whether each point is lit, bool, shape (N,) for one direction, and (N, T) for several or a path.

        Raises:
            ValueError: A shape is wrong; a direction is not finite, has no length or points below the horizon; a normal is not a unit
                vector; or the lift is not finite.
            TypeError: An array does not hold real numbers.

        Example:
            >>> import adumbra
            >>> scene = adumbra.Scene.from_arrays([[0, 0, 3], [4, 0, 3], [0, 4, 3]], [[0, 1, 2]], up="z")
            >>> scene.sunlit([[1, 1, 0]], None, [[0, 0, 1], [1, 0, 0]])
            array([[False,  True]])
        """
        origins, (suns, is_one) = origins_of(points, normals, lift), self._suns(to_sun)
        found = self._native.sunlit(origins, suns, threads_of(threads))
        return found[:, 0] if is_one else found

    def visibility(
        self,
        points: ArrayLike,
        normals: ArrayLike | None,
        to_sun: ArrayLike | SunPath,
        *,
        sun_degrees: float = 0.53,
        lift: float = 1e-3,
        threads: int | None = None,
    ) -> NDArray[np.float32]:
        """Return the share of the sun's light that arrives at points: that of its disc that they see, by 256 rays each.

        A surface lets its transmissivity through, see :meth:`from_arrays`; in glTF, it is that of
        ``KHR_materials_transmission``.

        Args:
            points: See :meth:`sunlit`.
            normals: See :meth:`sunlit`. A point is dark if the centre of the disc is behind its surface.
            to_sun: See :meth:`sunlit`: the centres of the discs.
            sun_degrees: Width of the disc in degrees, 0 to 180. The sun has 0.53.
            lift: See :meth:`sunlit`.
            threads: See :meth:`sunlit`.

        Returns:
            Shares, 0 to 1, float32, shape (N,) for one direction, and (N, T) for several or a path.

        Raises:
            ValueError: See :meth:`sunlit`, or the width is out of range.
            TypeError: An array does not hold real numbers.
        """
        if not 0.0 <= sun_degrees <= 180.0:
            raise ValueError(f"sun_degrees: {sun_degrees} is out of range; it must be from 0 to 180")
        origins, (suns, is_one) = origins_of(points, normals, lift), self._suns(to_sun)
        found = self._native.visibility(origins, suns, float(sun_degrees), threads_of(threads))
        return found[:, 0] if is_one else found

    def nearest(
        self, points: ArrayLike, direction: ArrayLike, *, threads: int | None = None
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Find the nearest surface from each point in one direction.

        Rays straight down from above the scene find the points of a map and their normals.

        Args:
            points: Positions, shape (N, 3), of any real type.
            direction: The direction, three numbers, of any length.
            threads: See :meth:`sunlit`.

        Returns:
            The distances, shape (N,), in lengths of the direction, and infinite where there is no surface. The unit normals
            on the side that the ray comes from, shape (N, 3), and 0 where there is no surface.

        Raises:
            ValueError: A shape is wrong, or the direction is not finite or has no length.
            TypeError: An array does not hold real numbers.
        """
        along = numbers("direction", direction, 3)
        if not np.isfinite(along).all() or not any(along):
            raise ValueError(f"direction: {along} is not a direction; give finite numbers, not all 0")
        return self._native.nearest(triples("points", points), along, threads_of(threads))

    def _suns(self, to_sun: ArrayLike | SunPath) -> tuple[NDArray[np.float64], bool]:
        """Return directions towards suns, and whether the result has one column that must be dropped."""
        if isinstance(to_sun, SunPath):
            # The native part takes a sun without length as one at night.
            return to_sun.to_sun(self.up) * to_sun.is_up[:, np.newaxis], False
        directions = plain("to_sun", to_sun)
        if directions.ndim not in (1, 2) or directions.shape[-1] != 3:
            raise ValueError(f"to_sun: an array of shape (3,) or (T, 3) is needed, not {directions.shape}")
        is_one = directions.ndim == 1
        suns = triples("to_sun", directions[np.newaxis] if is_one else directions, double=True)
        wrong = ~(np.isfinite(suns).all(axis=1) & (suns != 0).any(axis=1))
        if wrong.any():
            row = int(np.argmax(wrong))
            raise ValueError(f"to_sun[{row}] is {suns[row]}, which is not a direction; give finite numbers, not all 0")
        # A turn of a horizontal sun may leave it below the horizon by a rounding error.
        down = suns[:, "xyz".index(self.up)] < -1e-9 * np.abs(suns).max(axis=1, initial=0.0)
        if down.any():
            row = int(np.argmax(down))
            raise ValueError(
                f"to_sun[{row}] is {suns[row]}, which points below the horizon, as {self.up} points up; leave nights out, and negate "
                "vectors that point away from the sun"
            )
        return suns, is_one

    def _warn_of_degrees(self) -> None:
        """Warn if the triangles are in the globe's degrees, not about their own origin, and much higher than they are wide."""
        low, high = np.array(self.bounds)
        upward = "xyz".index(self.up)
        height = (high - low)[upward]
        low, high = np.delete(low, upward), np.delete(high, upward)
        widest = (high - low).max()
        is_on_globe = (np.maximum(-low, high) <= (180.0, 90.0)).all() and widest < 1.0
        is_about_origin = (np.maximum(low, -high) < 3.0 * widest).all()
        if is_on_globe and not is_about_origin and height > 100.0 * widest:
            warn(
                f"from {self.bounds[0]} to {self.bounds[1]}: these look like degrees with heights in metres, in which shadows are "
                "wrong; project them to metres first"
            )

    def __reduce__(self) -> tuple[Any, ...]:
        rebuild, *arguments = self._source
        if rebuild is _from_arrays:
            arguments = [*self.mesh(), self._native.transmissivities(), self.up]
        return rebuild, tuple(arguments)

    def __repr__(self) -> str:
        low, high = self.bounds
        return f"<adumbra.Scene of {self.triangles} triangles from {low} to {high}, {self.up} up>"

    def _repr_html_(self) -> str:
        low, high = self.bounds
        size = " × ".join(f"{b - a:.4g}" for a, b in zip(low, high, strict=True))
        rows = [
            ("triangles", f"{self.triangles:,}"),
            ("size", size),
            ("from", _text(low)),
            ("to", _text(high)),
            ("up", self.up),
        ]
        return table("adumbra.Scene", rows + [("warning", text) for text in self.warnings])


def _text(vector: Vector) -> str:
    return ", ".join(f"{c:.6g}" for c in vector)


def _loaded(path: str, options: dict[str, Any]) -> Scene:
    """Load a scene again when it is unpickled. Its warnings have been shown."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SceneWarning)
        return Scene(path, **options)


def _from_arrays(vertices: NDArray[np.float64], faces: NDArray[np.uint32], shares: NDArray[np.float32], up: Up) -> Scene:
    """Make a scene again when it is unpickled. Its warnings have been shown."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SceneWarning)
        return Scene.from_arrays(vertices, faces, up=up, transmissivity=shares)


def _corners_of(faces: ArrayLike) -> NDArray[Any]:
    corners = plain("faces", faces)
    if corners.dtype.kind not in "iu":
        raise TypeError(f"faces: integers are needed, not an array of {corners.dtype}")
    if corners.ndim == 1 and corners.size % 4 == 0 and (corners[::4] == 3).all():
        corners = corners.reshape(-1, 4)[:, 1:]
    if corners.ndim != 2 or corners.shape[1] != 3:
        raise ValueError(f"faces: an array of shape (M, 3) is needed, not {corners.shape}; triangulate other polygons first")
    return corners


def _surface_of(mesh: Any) -> Any:
    # PyVista warns where its newer option is not given.
    has_option = "algorithm" in signature(mesh.extract_surface).parameters
    return mesh.extract_surface(algorithm=None) if has_option else mesh.extract_surface()


def _shares_of(name: str, values: ArrayLike, count: int) -> NDArray[Any]:
    """Return numbers from 0 to 1, one for each face."""
    shares = plain(name, values)
    if shares.dtype.kind not in "iufb":
        raise TypeError(f"{name}: real numbers are needed, not an array of {shares.dtype}")
    if shares.shape != (count,):
        raise ValueError(f"{name}: an array of shape ({count},) is needed, one number for each face, not {shares.shape}")
    if not ((shares >= 0) & (shares <= 1)).all():
        raise ValueError(f"{name}: a number is out of range; they must be from 0 to 1")
    return shares


def _check_projected(crs: Any) -> None:
    """Refuse a coordinate reference system in degrees."""
    if crs is None:
        return
    if not hasattr(crs, "is_geographic"):
        raise TypeError(f"crs: give one of rasterio or pyproj, such as pyproj.CRS({crs!r}), not a {type(crs).__name__}")
    if crs.is_geographic:
        raise ValueError(f"crs: {crs} is in degrees; project the coordinates to a system in metres first, such as UTM")


SceneLike = Union[Scene, str, "os.PathLike[str]"]
"""A scene, or the path of its file."""


def scene_of(scene: Any, options: dict[str, Any]) -> Scene:
    """Return a scene. Load it if a path is given."""
    if isinstance(scene, (str, os.PathLike)):
        return Scene(scene, **options)
    if options:
        loading_of(options)
        raise TypeError(f"{sorted(options)[0]}: this is an option of loading, but the scene is not a path")
    if isinstance(scene, Scene):
        return scene
    raise TypeError(
        f"scene: give a path or an adumbra.Scene, not a {type(scene).__name__}; Scene.from_arrays(vertices, faces, up=…) makes "
        "one from arrays"
    )
