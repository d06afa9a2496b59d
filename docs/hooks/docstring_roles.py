"""Docstrings name other code as :func:`symdyn.gait.phase.advance`; on the site that becomes a link."""

from __future__ import annotations

import re
from typing import Any

import griffe

_ROLE = re.compile(r":(?:class|func|meth|attr|data|mod):`~?([^`]+)`")
_OURS = ("symdyn", "slip", "rl", "hardware")


class DocstringRoles(griffe.Extension):
    """Rewrites roles as cross-references of mkdocstrings, or as code where they lead elsewhere."""

    def on_package(self, *, pkg: griffe.Module, **kwargs: Any) -> None:
        """Called once a package is loaded, so that names can be resolved."""
        self._visit(pkg)

    def _visit(self, obj: griffe.Object) -> None:
        if obj.docstring is not None:
            scope = obj
            obj.docstring.value = _ROLE.sub(lambda match: _reference(match[1], scope), obj.docstring.value)
        for member in obj.members.values():
            if not member.is_alias:
                self._visit(member)  # type: ignore[arg-type]


def _reference(name: str, scope: griffe.Object) -> str:
    try:
        path = scope.resolve(name)
    except griffe.NameResolutionError:
        path = name
    if path.split(".")[0] not in _OURS or any(part.startswith("_") for part in path.split(".")):
        return f"`{name}`"
    return f"[`{name.rsplit('.', 1)[-1]}`][{path}]" if _is_shown(path, scope) else f"`{name}`"


def _is_shown(path: str, scope: griffe.Object) -> bool:
    """Whether something has a place on a page: mkdocstrings leaves out what has no docstring."""
    try:
        return scope.modules_collection.get_member(path).has_docstring
    except KeyError:  # of a package that is read later; mkdocstrings warns should it not be there
        return True
