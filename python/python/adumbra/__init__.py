"""Baked sun shadows of static scenes: bakes, look-ups, checks and rays over NumPy arrays.

A bake stores which points of a scene see the sun in one file of a few megabytes. A look-up then answers any point::

    import adumbra

    scene = adumbra.Scene("city.glb")
    shadows = adumbra.bake(scene, azimuth=140, elevation=35)
    shadows.save("city.adumbra")
    share = shadows.visibility(points, normals)

Rays answer the same question exactly, for any number of suns::

    sun = adumbra.SunPath(lat=48.14, lon=11.58, times=times)
    lit = scene.sunlit(points, normals, sun)

*Visibility* is 1 where a point sees the sun, and 0 where it does not. Coordinates are those of the scene's own file or arrays,
right-handed, with Y or Z up, in the scene's unit; where a unit is needed, that unit is called a metre.
"""

from ._bake import BakeOptions, bake
from ._errors import AdumbraError, FormatError, MemoryLimitError, MissingPartsError, SceneWarning
from ._file import ShadowFile
from ._path import SunPathFile, bake_path
from ._plan import BakedPart, Part, Plan
from ._loading import LoadOptions
from ._scene import Scene, SceneLike
from ._sun import SunPath, sun_direction
from ._sunlight import Skies, SunHours, sky, sun_hours
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
    "Scene",
    "SceneLike",
    "SceneWarning",
    "ShadowFile",
    "Skies",
    "SunHours",
    "SunPath",
    "SunPathFile",
    "Verification",
    "bake",
    "bake_path",
    "sky",
    "sun_direction",
    "sun_hours",
]
