"""Baked sun shadows of static scenes: bakes, look-ups, checks and rays over NumPy arrays.

A bake stores which points of a scene see the sun in one file of a few megabytes. A look-up then answers any point::

    import adumbra

    shadows = adumbra.bake("city.glb", azimuth=140, elevation=35)
    shadows.save("city.adumbra")
    lit = shadows.visibility(points, normals)

Rays answer the same question exactly, for any number of suns::

    lit = adumbra.rays("city.glb").visibility(points, suns, normals)

*Visibility* is 1 where a point sees the sun, and 0 where it does not. World space is right-handed with Y up, in the scene's
unit; where a unit is needed, that unit is called a metre.
"""

from ._bake import BakeOptions, bake
from ._errors import AdumbraError, FormatError, MemoryLimitError, MissingPartsError, SceneWarning
from ._file import ShadowFile
from ._path import SunPath, bake_path
from ._plan import BakedPart, Part, Plan
from ._rays import Rays, rays
from ._scene import LoadOptions, Scene, SceneLike
from ._sun import sun_direction
from ._sunlight import Skies, SunHours, SunPositions, sky, sun_hours, sun_positions
from ._verify import ClassResult, Verification

__all__ = [
    "AdumbraError",
    "BakeOptions",
    "BakedPart",
    "ClassResult",
    "FormatError",
    "LoadOptions",
    "MemoryLimitError",
    "MissingPartsError",
    "Part",
    "Plan",
    "Rays",
    "Scene",
    "SceneLike",
    "SceneWarning",
    "ShadowFile",
    "Skies",
    "SunHours",
    "SunPath",
    "SunPositions",
    "Verification",
    "bake",
    "bake_path",
    "rays",
    "sky",
    "sun_direction",
    "sun_hours",
    "sun_positions",
]
