"""Every notebook runs from its first cell to its last, with what it imports from the packages."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.hardware.lcm_urls import multicast_url

nbformat = pytest.importorskip("nbformat")
nbclient = pytest.importorskip("nbclient")

FOLDER = Path(__file__).parents[2] / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))
LONGEST_CELL_S = 600
BY_THE_CLOCK = "robot_log"
"""Runs robot and deployer in real time, and so not beside other tests."""

SHORTER = {
    "train_and_evaluate": {"time_limit_s=50.0": "time_limit_s=3.0"},
    "robot_log": {'"--scenario", "paper"': '"--scenario", "run", "--duration", "16"'},  # the paper's: tests/e2e
}
"""By notebook, what is replaced in its cells: how long is trained or run does not matter to whether they run."""

EACH = [
    pytest.param(path, id=path.stem, marks=[pytest.mark.realtime] if path.stem == BY_THE_CLOCK else [])
    for path in NOTEBOOKS
]


def test_there_are_some():
    assert NOTEBOOKS


def test_what_is_shortened_stands_in_the_notebook():
    for name, replaced in SHORTER.items():
        sources = "".join(cell.source for cell in nbformat.read(FOLDER / f"{name}.ipynb", as_version=4).cells)
        assert all(sources.count(given) == 1 for given in replaced)


@pytest.mark.parametrize("path", EACH)
def test_runs(path, slip_cache, tmp_path):
    if path.stem == BY_THE_CLOCK:
        multicast_url()  # skips where there is no multicast
    notebook = nbformat.read(path, as_version=4)
    for cell in notebook.cells:
        for given, shorter in SHORTER.get(path.stem, {}).items():
            cell.source = cell.source.replace(given, shorter)
    client = nbclient.NotebookClient(
        notebook, timeout=LONGEST_CELL_S, kernel_name="python3", resources={"metadata": {"path": str(tmp_path)}}
    )
    client.execute()
    pictures = [
        output
        for cell in notebook.cells
        for output in cell.get("outputs", [])
        if {"image/png", "image/gif"} & set(output.get("data", {}))
    ]
    assert len(pictures) >= 4
    assert not list(tmp_path.iterdir())  # nothing is left where the notebook runs


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_defines_no_physics(path):
    """Cells are short and hold neither functions nor classes: what they use is in the packages, and tested there."""
    for cell in nbformat.read(path, as_version=4).cells:
        if cell.cell_type == "code":
            lines = cell.source.splitlines()
            assert len(lines) <= 16, cell.source
            assert not any(line.lstrip().startswith(("def ", "class ", "lambda ")) for line in lines), cell.source
