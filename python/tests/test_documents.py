"""The notebook, the guides and the examples of docstrings run without errors."""

from __future__ import annotations

import doctest
import importlib
import os
import pkgutil
import re
import shlex
from pathlib import Path
from typing import Any

import pytest
from conftest import Program

import adumbra
from adumbra_farm.__main__ import parser

ROOT = Path(__file__).parent.parent
GUIDES = ROOT.parent / "docs" / "guides"


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_the_notebook_runs() -> None:
    scene = Path(os.environ.get("ADUMBRA_SHARED", "shared")) / "scenes" / "delft.glb"
    if not scene.is_file():
        pytest.skip(f"{scene.absolute()} is not there; let ADUMBRA_SHARED name the folder that has scenes/delft.glb")
    nbclient, nbformat = pytest.importorskip("nbclient"), pytest.importorskip("nbformat")
    notebook = nbformat.read(ROOT / "notebooks" / "shade_on_delft.ipynb", as_version=4)
    client = nbclient.NotebookClient(notebook, timeout=60)
    done: Any = client.execute(cwd=str(scene.parent))
    outputs = [output for cell in done.cells for output in cell.get("outputs", [])]
    assert sum("image/png" in output.get("data", {}) for output in outputs) == 2
    agreements = [float(a) for o in outputs for a in re.findall(r"([\d.]+) % of the points that face", o.get("text", ""))]
    assert len(agreements) == 3 and min(agreements) > 99


@pytest.mark.parametrize(("name", "least", "prints"), [("python.md", 6, 3), ("farms.md", 2, 0)])
def test_the_guides_run(
    name: str,
    least: int,
    prints: int,
    program: Program,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    program("generate", "city", "-o", tmp_path / "city.glb")
    monkeypatch.chdir(tmp_path)
    guide = GUIDES / name
    blocks = re.findall(r"^```python\n(.*?)^```$", guide.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
    assert len(blocks) >= least
    names: dict[str, Any] = {}
    printed = []
    for block in blocks:
        exec(compile(block, str(guide), "exec"), names)
        printed.append(capsys.readouterr().out)
    promised = re.findall(r"^This prints `(.*?)`", guide.read_text(encoding="utf-8"), re.MULTILINE)
    assert len(promised) == prints and {said + "\n" for said in promised} <= set(printed)
    output = "city.adumbra" if name == "python.md" else "steps.adumbra"
    assert names["shadows"].bytes == (tmp_path / output).stat().st_size


def test_the_guide_to_sun_hours_runs(city: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("pandas")
    monkeypatch.chdir(city.parent)
    (block,) = re.findall(r"^```python\n(.*?)^```$", (GUIDES / "sun-on-my-street.md").read_text("utf-8"), re.DOTALL | re.MULTILINE)
    names: dict[str, Any] = {}
    exec(compile(block, "sun-on-my-street.md", "exec"), names)
    assert names["day"].hours.shape == (2,) and names["skies"].patches.shape == (2, 577)


def test_the_examples_of_docstrings_run() -> None:
    names = [found.name for found in pkgutil.iter_modules(adumbra.__path__, "adumbra.") if found.name != "adumbra._native"]
    results = [doctest.testmod(importlib.import_module(name)) for name in ["adumbra", *names]]
    assert sum(result.attempted for result in results) >= 15
    assert sum(result.failed for result in results) == 0


def test_the_guides_adumbra_farm_commands_parse() -> None:
    guide = (GUIDES / "farms.md").read_text(encoding="utf-8")
    commands = re.findall(r"^adumbra-farm (.*)$", guide, re.MULTILINE)
    assert len(commands) >= 2
    for command in commands:
        given = parser().parse_args(shlex.split(command))
        assert given.output.endswith("city.adumbra")
