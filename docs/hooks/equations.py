r"""Equations as MathML: written as LaTeX between dollar signs, drawn by the browser itself, without any script."""

from __future__ import annotations

import html
import re

from latex2mathml.converter import convert
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import Files
from mkdocs.structure.pages import Page

# what pymdownx.arithmatex makes of $...$ and $$...$$
_INLINE = re.compile(r'<span class="arithmatex">\\\((.*?)\\\)</span>', re.DOTALL)
_BLOCK = re.compile(r'<div class="arithmatex">\\\[(.*?)\\\]</div>', re.DOTALL)


def on_page_content(content: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Put MathML in the place of LaTeX.

    Raises:
        PluginError: for LaTeX that cannot be converted.
    """

    def mathml(latex: str, display: str) -> str:
        found = convert(html.unescape(latex).strip(), display=display)
        if "\\" in found:  # a macro that the converter does not know is left as it was
            raise PluginError(f"{page.file.src_uri}: cannot convert {latex.strip()!r}")
        return found

    content = _INLINE.sub(lambda match: mathml(match[1], "inline"), content)
    return _BLOCK.sub(lambda match: f'<div class="equation">{mathml(match[1], "block")}</div>', content)
