"""The notebooks as pages, with the outputs they were committed with."""

from __future__ import annotations

import base64
from functools import cache
from pathlib import Path

import nbformat
from checkout import ROOT

_FOLDER = "notebooks"
_IMAGES = {"image/png": "png", "image/gif": "gif"}
_ORDER = ("gait_symmetry", "gait_families", "train_and_evaluate", "robot_log")
"""Reading order; any other notebook comes after."""


def nav() -> list[object]:
    """The notebooks by short titles."""
    return [{path.stem.replace("_", " ").capitalize(): f"{_FOLDER}/{path.stem}.md"} for path in _notebooks()]


def pages() -> dict[str, str | bytes]:
    """Markdown and pictures by path."""
    found: dict[str, str | bytes] = {}
    for path in _notebooks():
        text, pictures = _page(path)
        found[f"{_FOLDER}/{path.stem}.md"] = text
        found |= {f"{_FOLDER}/{name}": content for name, content in pictures.items()}
    return found


def _notebooks() -> list[Path]:
    rank = {name: place for place, name in enumerate(_ORDER)}
    return sorted((ROOT / "notebooks").glob("*.ipynb"), key=lambda path: (rank.get(path.stem, len(rank)), path.stem))


@cache
def _read(path: Path) -> nbformat.NotebookNode:
    return nbformat.read(path, as_version=4)


def _page(path: Path) -> tuple[str, dict[str, bytes]]:
    title, *rest = _read(path).cells[0].source.splitlines()
    note = f"*This page is `notebooks/{path.name}` with its outputs: open it in Jupyter to run it.*"
    parts, pictures = [title, note, "\n".join(rest)], {}
    for cell in _read(path).cells[1:]:
        if cell.cell_type == "markdown":
            parts.append(cell.source)
            continue
        parts.append(_fenced(cell.source, "python"))
        for output in cell.outputs:
            kind = next((kind for kind in _IMAGES if kind in output.get("data", {})), None)
            if kind is not None:
                name = f"{path.stem}-{len(pictures) + 1}.{_IMAGES[kind]}"
                pictures[name] = base64.b64decode(output["data"][kind])
                parts.append(f"![Output of the cell above]({name})")
            elif text := output.get("text") or output.get("data", {}).get("text/plain"):
                parts.append(_fenced(text.rstrip(), "text { .output }"))
    return "\n\n".join(parts) + "\n", pictures


def _fenced(text: str, language: str) -> str:
    return f"````{language}\n{text}\n````"
