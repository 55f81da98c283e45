"""Progress bars."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Union

Report = Callable[[int, int], object]
"""Called with the number of finished root blocks (with Dask, of parts) and the total."""

Progress = Union[bool, Report, None]
"""Whether to show progress, or a function to call with it."""


@contextmanager
def reporting(progress: Progress, unit: str = "root block") -> Iterator[Report | None]:
    """Provide the function that reports progress: that of a ``tqdm`` bar, the caller's, or ``None``."""
    if callable(progress):
        yield progress
        return
    if progress is None:
        progress = sys.stderr is not None and sys.stderr.isatty()
        wanted = False
    else:
        wanted = progress
    if not progress:
        yield None
        return
    try:
        from tqdm.auto import tqdm
    except ImportError:
        if wanted:
            raise ImportError("progress=True shows a bar of tqdm, which is not installed; pip install tqdm") from None
        yield None
        return
    with tqdm(desc="bake", unit=unit, leave=False) as bar:

        def report(done: int, total: int) -> None:
            bar.total = total
            bar.update(done - bar.n)

        yield report
