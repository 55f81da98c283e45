"""Files: reading, writing, addresses, levels, pickles, and broken bytes."""

from __future__ import annotations

import pickle
import threading
import urllib.error
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path

import numpy as np
import pytest
from conftest import Mesh, points_of

import adumbra


def test_saved_files_read_back_unchanged(shadows: adumbra.ShadowFile, tmp_path: Path) -> None:
    path = tmp_path / "town.adumbra"
    for stored in ("coded", "raw"):
        length = shadows.save(path, encoding=stored)
        again = adumbra.ShadowFile.open(path)
        assert (again, again.encoding, again.bytes, length) == (shadows, stored, length, path.stat().st_size)
        assert again.to_bytes() == path.read_bytes()
        assert again.to_bytes("coded") == shadows.to_bytes()
        data = path.read_bytes()
        forms: list[bytes | bytearray | memoryview] = [data, bytearray(data), memoryview(data)]
        for form in forms:
            assert (adumbra.ShadowFile.open(form), adumbra.ShadowFile.open(form).encoding) == (shadows, stored)
    assert len(shadows.to_bytes("raw")) > shadows.bytes
    assert adumbra.ShadowFile.open(str(path)).save(path) == length
    assert shadows != adumbra.ShadowFile.open(path).level(1)
    assert shadows != 3
    with pytest.raises(ValueError, match='encoding: "zip" must be'):
        shadows.save(path, encoding="zip")  # type: ignore[arg-type]
    with pytest.raises(FileNotFoundError):
        shadows.save(tmp_path / "none" / "town.adumbra")
    assert path.read_bytes() == again.to_bytes()


def test_levels_are_files(mesh: Mesh, shadows: adumbra.ShadowFile, tmp_path: Path) -> None:
    assert shadows.levels == 2
    coarse = shadows.level(1)
    assert (coarse.levels, coarse.resolution) == (1, 256)
    assert coarse.voxel_size == 4 * shadows.voxel_size
    assert coarse.save(tmp_path / "coarse.adumbra") == coarse.bytes == (tmp_path / "coarse.adumbra").stat().st_size
    assert shadows.level(0) == shadows and shadows.level(0).bytes == shadows.bytes
    points, normals = points_of(mesh, 20_000)
    assert (coarse.visibility(points, normals, 1) == shadows.visibility(points, normals, 1)).mean() > 0.9
    for level in (2, -1, 2**40):
        with pytest.raises(IndexError, match=f"level {level} is out of range; it must be from 0 to 1"):
            shadows.level(level)


def test_files_can_be_pickled(shadows: adumbra.ShadowFile) -> None:
    again = pickle.loads(pickle.dumps(shadows))
    assert (again, again.encoding, again.info) == (shadows, shadows.encoding, shadows.info)


def test_notebooks_show_what_the_file_says(shadows: adumbra.ShadowFile) -> None:
    shown = shadows._repr_html_()
    for figure in ("adumbra.ShadowFile", "1024", f"{shadows.voxel_size:.6g}", str(shadows.bytes), "voxel size", "assume ground"):
        assert figure in shown


def test_files_are_read_from_addresses(shadows: adumbra.ShadowFile) -> None:
    data = shadows.to_bytes()

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            found = {"/town.adumbra": data, "/cut.adumbra": data[:-1]}.get(self.path)
            self.send_response(200 if found else 404)
            self.end_headers()
            self.wfile.write(found or b"")

        def log_message(self, *_: object) -> None:
            """Print nothing."""

    with HTTPServer(("127.0.0.1", 0), Handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        address = f"http://127.0.0.1:{server.server_port}"
        assert adumbra.ShadowFile.open(f"{address}/town.adumbra") == shadows
        with pytest.raises(adumbra.FormatError, match="cut off"):
            adumbra.ShadowFile.open(f"{address}/cut.adumbra")
        with pytest.raises(urllib.error.HTTPError) as missing:
            adumbra.ShadowFile.open(f"{address}/none.adumbra")
        missing.value.close()
        server.shutdown()
    with pytest.raises(OSError):
        adumbra.ShadowFile.open(f"{address}/town.adumbra", timeout=1)


def test_broken_files_are_refused(shadows: adumbra.ShadowFile, tmp_path: Path) -> None:
    data = shadows.to_bytes()
    path = tmp_path / "broken.adumbra"
    for broken, message in [
        (b"", "cut off"),
        (b"nonsense" * 100, "not a shadow file"),
        (data[:100], "cut off in its header"),
        (data[:-1], "cut off"),
        (data + b"\0", "continues past its end"),
        (data[:40] + bytes([data[40] ^ 1]) + data[41:], "damaged"),
        (data[:-9] + bytes([data[-9] ^ 1]) + data[-8:], "level 0"),
    ]:
        with pytest.raises(adumbra.FormatError, match=message):
            adumbra.ShadowFile.open(broken)
        path.write_bytes(broken)
        with pytest.raises(adumbra.FormatError, match="broken.adumbra"):
            adumbra.ShadowFile.open(path)
    assert issubclass(adumbra.FormatError, ValueError) and issubclass(adumbra.FormatError, adumbra.AdumbraError)


def test_any_flipped_bit_is_an_error_or_harmless(shadows: adumbra.ShadowFile) -> None:
    data = np.frombuffer(shadows.to_bytes(), np.uint8)
    random = np.random.default_rng(5)
    refused = 0
    for _ in range(300):
        broken = data.copy()
        broken[random.integers(len(data))] ^= 1 << random.integers(8)
        try:
            adumbra.ShadowFile.open(broken.tobytes())
        except adumbra.FormatError:
            refused += 1
    assert refused == 300


def test_errors_name_files_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError) as missing:
        adumbra.ShadowFile.open(tmp_path / "none.adumbra")
    assert (missing.value.errno, missing.value.filename) == (2, str(tmp_path / "none.adumbra"))
    with pytest.raises(IsADirectoryError):
        adumbra.ShadowFile.open(tmp_path)
    with pytest.raises(TypeError):
        adumbra.ShadowFile.open(3)  # type: ignore[arg-type]
