"""Files of a moving sun: the bytes and the answers of the program."""

from __future__ import annotations

import pickle
from datetime import datetime, timezone
from pathlib import Path

import numpy as np
import pytest
from conftest import Program

import adumbra


def test_path_and_its_answers_match_the_program(solids: Path, program: Program, tmp_path: Path) -> None:
    output, saved = tmp_path / "day.adumbra", tmp_path / "saved.adumbra"
    words = "lat=48,lon=11,date=2026-03-20,from=12,to=12:30"
    program("bake", solids, "--sun-path", words, "--resolution", 512, "-o", output)
    path = adumbra.bake_path(solids, lat=48, lon=11, date="2026-03-20", from_=12, to="12:30", resolution=512)
    assert path.save(saved) == output.stat().st_size and saved.read_bytes() == output.read_bytes()
    again = adumbra.SunPathFile.open(output)
    assert np.array_equal(again.keys, path.keys) and len(path.keys) >= 2
    points = np.random.default_rng(1).uniform((-12, 0, -12), (12, 4, 12), (20_000, 3))
    points.tofile(tmp_path / "points")
    time = datetime(2026, 3, 20, 11, 13, tzinfo=timezone.utc)
    for width in (1, 5):
        given = ["--points-f64", tmp_path / "points", "--filter", width, "-o", tmp_path / "answers"]
        program("query", output, "--time", "12:13", *given)
        found = again.visibility(points, time, filter=width)
        assert np.array_equal(found, np.fromfile(tmp_path / "answers", np.float32)) and 0 < found.mean() < 1
    sun = path.sun_at(time)
    assert sun is not None and sun[1] > 0.5
    assert path.sun_at(datetime(2026, 3, 20, 20, 0, tzinfo=timezone.utc)) is None
    assert path.sun_at(np.datetime64("2026-03-20T11:13"), tz="UTC") == sun
    assert np.array_equal(path.visibility(points, datetime(2026, 3, 20, 12, 13), tz="Europe/Berlin"), path.visibility(points, time))
    assert (path.visibility(points, time, filter=1, quick=True) == path.visibility(points, time, filter=1)).mean() > 0.99
    with pytest.raises(ValueError, match="not on the path"):
        path.visibility(points, datetime(2026, 3, 21, tzinfo=timezone.utc))
    naive = datetime(2026, 3, 20, 11, 13)
    for moment in (naive, np.datetime64(naive)):
        with pytest.raises(ValueError, match='no time zone, .* such as tz="Europe/Berlin"'):
            path.visibility(points, moment)
        with pytest.raises(ValueError, match="no time zone"):
            path.sun_at(moment)
    for read in (pickle.loads(pickle.dumps(path)), adumbra.SunPathFile.open(path.to_bytes())):
        assert read.up == "y" and read.sun_at(time) == sun
        assert np.array_equal(read.visibility(points, time, threads=1), path.visibility(points, time))
    with pytest.raises(adumbra.FormatError, match="the data"):
        adumbra.SunPathFile.open(path.to_bytes()[:200])
    with pytest.raises(ValueError, match="path_error"):
        adumbra.bake_path(solids, lat=48, lon=11, date="2026-03-20", from_=12, to=13, path_error=0)
