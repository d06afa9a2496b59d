"""A page for every public module, from its docstrings, and one for each package that lists its modules."""

from __future__ import annotations

import ast
from pathlib import Path

from checkout import ROOT

_FOLDER = "reference/python"
_PACKAGES = ("symdyn", "slip", "rl", "hardware")
_LEFT_OUT = ("cli", "messages", "__main__")
"""Commands have pages of their own; messages are lcm-gen's."""


def nav() -> list[object]:
    """Packages, and the modules of each."""
    entries: list[object] = [f"{_FOLDER}/index.md"]
    for package in _PACKAGES:
        modules = [{name.removeprefix(f"{package}."): _path(name)} for name in _modules(package)]
        entries.append({package: [f"{_FOLDER}/{package}/index.md", *modules]})
    return entries


def pages() -> dict[str, str]:
    """Markdown by path."""
    found = {f"{_FOLDER}/index.md": _index()}
    for package in _PACKAGES:
        modules = _modules(package)
        rows = [f"| [`{name}`]({_path(name).rsplit('/', 1)[1]}) | {first} |" for name, first in modules.items()]
        sentence = _first_sentence(ROOT / package / "__init__.py")
        head = [f"# {package}", "", sentence, "", "| module | what it is |", "|---|---|"]
        found[f"{_FOLDER}/{package}/index.md"] = "\n".join([*head, *rows]) + "\n"
        for name in modules:
            found[_path(name)] = f"::: {name}\n"
    return found


def _index() -> str:
    sentences = {package: _first_sentence(ROOT / package / "__init__.py") for package in _PACKAGES}
    rows = [f"| [`{package}`]({package}/index.md) | {sentence} |" for package, sentence in sentences.items()]
    head = [
        "# Python",
        "",
        "Every array over legs has the order LH, LF, RF, RH, every array over joints the order of",
        "[JOINTS][symdyn.robot.legs.JOINTS]. Units are SI and radians; phases and offsets are fractions of a stride. A",
        "name that ends in `_w`, `_b` or `_h` is in the world, body or heading frame.",
        "",
        "| package | what it is |",
        "|---|---|",
    ]
    return "\n".join([*head, *rows]) + "\n"


def _modules(package: str) -> dict[str, str]:
    """First sentences of the docstrings by module, packages without a docstring left out."""
    found = {}
    for path in sorted((ROOT / package).rglob("*.py")):
        parts = path.relative_to(ROOT).with_suffix("").parts
        if set(parts) & set(_LEFT_OUT):
            continue
        name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
        sentence = _first_sentence(path)
        if name != package and sentence:
            found[name] = sentence
    return dict(sorted(found.items()))


def _first_sentence(path: Path) -> str:
    docstring = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
    first = " ".join(docstring.split("\n\n")[0].split()).replace("``", "`").replace("|", "\\|")
    return first.split(". ")[0].rstrip(".") + "." if first else ""


def _path(module: str) -> str:
    package, *rest = module.split(".")
    return str(Path(_FOLDER) / package / f"{'.'.join(rest)}.md")
