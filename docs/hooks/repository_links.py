"""Links that leave docs/ in the repository and have a page on the site: they work in both places."""

from __future__ import annotations

import posixpath
import re

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import Files
from mkdocs.structure.pages import Page

_HOME = {"changelog.md": "CHANGELOG.md", "model-card.md": "rl/pretrained/README.md"}
"""Where pages that are made from a file of the repository have their links from."""

_LINK = re.compile(r"(?<=\]\()([^)#\s:]+)(?=[)#])")


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Point links at a page's repository path to the page."""
    here = posixpath.dirname(_home(page.file.src_uri))

    def moved(match: re.Match[str]) -> str:
        target = _page_of(posixpath.normpath(posixpath.join(here, match[1])))
        if files.get_file_from_path(target) is None:
            return match[0]  # MkDocs itself says that there is no such page
        return posixpath.relpath(target, posixpath.dirname(page.file.src_uri) or ".")

    return _LINK.sub(moved, markdown)


def _home(page: str) -> str:
    """The file of the repository that a page is made from."""
    return page if page.startswith("notebooks/") else _HOME.get(page, f"docs/{page}")


def _page_of(path: str) -> str:
    """The site's page for a file of the repository."""
    for name, source in _HOME.items():
        if path == source:
            return name
    if path == "docs/results":
        return "results/files.md"
    if path.startswith("notebooks/") and path.endswith(".ipynb"):
        return path.removesuffix(".ipynb") + ".md"
    return path.removeprefix("docs/")
