"""The package's own exceptions and warnings."""


class AdumbraError(Exception):
    """Any error without a suitable built-in exception, such as a bake that does not fit its memory limit."""


class FormatError(AdumbraError, ValueError):
    """A shadow file or a scene is broken, or is of another kind. The message says where, and what to do."""


class MemoryLimitError(AdumbraError):
    """A scene or a bake does not fit its memory limit, or has more than a file can hold."""


class MissingPartsError(AdumbraError):
    """Parts of a plan have not been baked yet, or their entries are damaged. Bake them, then link again."""


class SceneWarning(UserWarning):
    """A scene was loaded, but parts of its file were left out or changed."""


for _class in (AdumbraError, FormatError, MemoryLimitError, MissingPartsError, SceneWarning):
    _class.__module__ = "adumbra"
