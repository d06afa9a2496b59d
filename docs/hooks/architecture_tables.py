"""Packages, folders and import contracts, from the docstrings and from what import-linter checks."""

from __future__ import annotations

import ast
import tomllib
from pathlib import Path
from typing import Any

from checkout import ROOT

from symdyn.io.markdown import table


def packages_table() -> list[str]:
    """The packages in the order of their layers, with their first sentences."""
    rows = []
    for layer in _layers_of(None):
        rows += [[f"`{package}`", _sentence(ROOT / package)] for package in layer]
    return table(["package", "what it is"], rows)


def folders_table(package: str) -> list[str]:
    """The folders of a package, layer by layer from the top, with their first sentences."""
    rows = []
    for number, layer in enumerate(_layers_of(package), 1):
        for name in layer:
            path = _place(package, name)
            shown = f"`{path.relative_to(ROOT)}{'/' if path.is_dir() else ''}`"
            rows.append([str(number), shown, _sentence(path)])
    return table(["layer", "folder", "what it holds"], rows)


def contracts_table() -> list[str]:
    """Every import contract: its name, and what it allows or forbids."""
    rows = []
    for contract in _contracts():
        if contract["type"] == "layers":
            what = " over ".join(f"`{layer.replace(' | ', '`, `')}`" for layer in contract["layers"])
        else:
            what = f"{_names(contract['source_modules'])} must not import {_names(contract['forbidden_modules'])}"
        rows.append([contract["name"], what])
    return table(["contract", "layers, or what is forbidden"], rows)


def _contracts() -> list[dict[str, Any]]:
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"]["contracts"]


def _layers_of(package: str | None) -> list[list[str]]:
    """Names in each layer of a package, or of the packages themselves for None."""
    containers = None if package is None else [package]
    (contract,) = [c for c in _contracts() if c["type"] == "layers" and c.get("containers") == containers]
    return [layer.split(" | ") for layer in contract["layers"]]


def _place(package: str, name: str) -> Path:
    folder = ROOT.joinpath(*package.split("."), name)
    return folder if folder.is_dir() else folder.with_suffix(".py")


def _sentence(path: Path) -> str:
    source = path / "__init__.py" if path.is_dir() else path
    docstring = ast.get_docstring(ast.parse(source.read_text(encoding="utf-8"))) or ""
    text = " ".join(docstring.split("\n\n")[0].split()).replace("``", "`").replace("|", "\\|")
    return text.removeprefix(f"{path.name}: ")


def _names(modules: list[str]) -> str:
    return ", ".join(f"`{module}`" for module in modules)


TABLES = {
    "<!-- packages -->": packages_table,
    "<!-- import contracts -->": contracts_table,
    **{
        f"<!-- folders of {package} -->": lambda package=package: folders_table(package)
        for package in ("symdyn", "slip", "rl", "rl.viewer", "hardware")
    },
}
"""Comments in pages in whose place a table is put."""
