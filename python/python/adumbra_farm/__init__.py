"""Bakes on many processes or machines, with Dask.

Dask distributes the tasks, repeats lost ones, and tracks the workers. This package plans a bake, groups its
parts into tasks, and links the file at the end::

    import adumbra_farm

    shadows = adumbra_farm.bake("city.glb", "city.adumbra", workers=4)

With ``client=distributed.Client("tcp://…")`` the tasks run on that cluster. All its machines need this package, and see the scene
and the cache folder under the same paths.
"""

try:
    import distributed  # noqa: F401
except ImportError:
    raise ImportError("adumbra_farm needs Dask, which is not installed; pip install adumbra[farm]") from None

from ._farm import Farmed, bake, bake_plan

__all__ = ["Farmed", "bake", "bake_plan"]
