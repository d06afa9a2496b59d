"""Pages that are made from the code while the site is built, so that none can go stale."""

from __future__ import annotations

import command_pages
import gait_figures
import module_pages
import notebook_pages
import references
import repository_pages
import settings_page
import table_pages
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

_SECTIONS = {
    "<notebooks>": notebook_pages.nav,
    "<commands>": command_pages.nav,
    "<api>": module_pages.nav,
    "<results>": repository_pages.result_files_page,
}
"""Placeholders of the navigation in mkdocs.yml, and what makes the entry that takes their place."""

_SOURCES = (
    command_pages,
    gait_figures,
    module_pages,
    notebook_pages,
    references,
    repository_pages,
    settings_page,
    table_pages,
)
"""Modules that make pages."""


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Fill the placeholders of the navigation."""
    config.nav = _filled(config.nav)
    return config


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages."""
    for source in _SOURCES:
        for path, content in source.pages().items():
            files.append(File.generated(config, path, content=content))
    return files


def _filled(entry: object) -> object:
    if isinstance(entry, list):
        return [_filled(item) for item in entry]
    if isinstance(entry, dict):
        return {title: _filled(item) for title, item in entry.items()}
    return _SECTIONS[entry]() if entry in _SECTIONS else entry
