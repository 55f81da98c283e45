"""The program's cache in a store: an S3 server on this machine."""

from __future__ import annotations

import json
import os
import subprocess
import urllib.request
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

moto_server = pytest.importorskip("moto.server", reason="moto[server] is not installed")

Run = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture(scope="module")
def run() -> Iterator[Run]:
    """Return a function that runs the program with the store's address and keys in its environment."""
    path = os.environ.get("ADUMBRA_BIN")
    if path is None:
        pytest.skip("ADUMBRA_BIN does not name the program adumbra")
    server = moto_server.ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
    server.start()
    host, port = server.get_host_and_port()
    endpoint = f"http://{host}:{port}"
    request = urllib.request.Request(f"{endpoint}/bucket", method="PUT")
    request.add_header(
        "Authorization", "AWS4-HMAC-SHA256 Credential=key/20260101/us-east-1/s3/aws4_request"
    )
    urllib.request.urlopen(request).close()
    environment = {
        **os.environ,
        "AWS_ACCESS_KEY_ID": "key",
        "AWS_SECRET_ACCESS_KEY": "secret",
        "AWS_REGION": "us-east-1",
        "AWS_ENDPOINT": endpoint,
        "AWS_ALLOW_HTTP": "true",
    }

    def run(*words: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run([path, *words], env=environment, capture_output=True, text=True, check=False)

    yield run
    server.stop()


def ran(done: subprocess.CompletedProcess[str]) -> str:
    """Return the output of a program, which must have succeeded."""
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_bakes_with_a_store_write_the_same_file(run: Run, tmp_path: Path) -> None:
    scene, plain, stored = (str(tmp_path / name) for name in ("city.glb", "plain", "stored"))
    ran(run("generate", "city", "-o", scene))
    ran(run("bake", scene, "--resolution", "2048", "-o", plain))
    for is_first in (True, False):
        cached = ("--cache", "s3://bucket/a b", "--json")
        said = json.loads(ran(run("bake", scene, "--resolution", "2048", *cached, "-o", stored)))
        assert said["reused_root_blocks"] == (0 if is_first else said["root_blocks"])
        assert Path(stored).read_bytes() == Path(plain).read_bytes()
    assert " entries" in ran(run("cache", "info", "s3://bucket/a b"))
    ran(run("cache", "prune", "s3://bucket/a b", "--keep", "0"))
    assert ran(run("cache", "info", "s3://bucket/a b")).endswith(": 0 entries, 0 B\n")


def test_two_writers_of_the_same_entries_succeed(run: Run, tmp_path: Path) -> None:
    scene, plan, plain, linked = (str(tmp_path / name) for name in ("city.glb", "plan", "plain", "linked"))
    ran(run("generate", "city", "-o", scene))
    ran(run("bake", scene, "--resolution", "4096", "-o", plain))
    ran(run("plan", scene, "--resolution", "4096", "-o", plan))
    cache = ("--plan", plan, "--cache", "s3://bucket/shared")
    missing = run("link", *cache, "-o", linked)
    assert missing.returncode == 75, missing.stderr
    with ThreadPoolExecutor(2) as pool:
        for done in pool.map(lambda _: run("tile", *cache, "--threads", "1"), range(2)):
            ran(done)
    ran(run("link", *cache, "-o", linked))
    assert Path(linked).read_bytes() == Path(plain).read_bytes()


def test_bake_warns_of_a_missing_bucket_and_continues(run: Run, tmp_path: Path) -> None:
    scene, plain, output = (str(tmp_path / name) for name in ("city.glb", "plain", "out"))
    ran(run("generate", "city", "-o", scene))
    ran(run("bake", scene, "--resolution", "256", "-o", plain))
    done = run("bake", scene, "--resolution", "256", "--cache", "s3://nobody/x", "-o", output)
    assert done.returncode == 0 and done.stderr.count("warning: --cache s3://nobody/x:") == 1, done.stderr
    assert Path(output).read_bytes() == Path(plain).read_bytes()


def test_addresses_of_no_store_are_errors(run: Run, tmp_path: Path) -> None:
    scene, output = str(tmp_path / "city.glb"), tmp_path / "out"
    ran(run("generate", "city", "-o", scene))
    output.write_bytes(b"earlier")
    done = run("bake", scene, "--resolution", "256", "--cache", "nonsense://x", "-o", str(output))
    assert done.returncode == 3 and "s3://bucket/prefix" in done.stderr, done.stderr
    assert output.read_bytes() == b"earlier"
