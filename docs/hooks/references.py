"""The page of references, from docs/references.bib, and the links from citations in the text to its entries."""

from __future__ import annotations

import re
from dataclasses import dataclass
from importlib.metadata import version

from checkout import ROOT
from mkdocs.structure.pages import Page

PAGE = "references.md"
_BIBLIOGRAPHY = ROOT / "docs" / "references.bib"

_ENTRY = re.compile(r"^@(\w+)\{(\w+),\n(.*?)^\}", re.DOTALL | re.MULTILINE)
_FIELD = re.compile(r"^  (\w+) = \{(.*)\},?$", re.MULTILINE)

_NAME = r"(?:De )?[A-Z][^\W\d_]+"
CITATION = re.compile(
    rf"\b({_NAME})(?:(?:,? {_NAME})*,? (?:&|&amp;|and) {_NAME}| et al\.)?,?\s\(?((?:19[5-9]|20[0-4])\d)([ab]?)\b"
)
"""A surname, perhaps with those of others, and a year: groups are the first surname, the year and its letter."""

_SOFTWARE = (
    "@software{symdyn,",
    "  author = {{The symdyn authors}},",
    "  title = {symdyn: training, analysis and deployment of quadrupedal gaits},",
    f"  version = {{{version('symdyn-gaits')}}},",
    "}",
)

_PART = re.compile(r"(<[^>]*>)")
_UNTOUCHED = ("a", "code", "pre", "h1", "h2", "h3", "h4")


@dataclass(frozen=True)
class Reference:
    """An entry of the bibliography.

    Attributes:
        key: of BibTeX.
        kind: of BibTeX.
        fields: by name, in order.
        source: the entry as BibTeX.
    """

    key: str
    kind: str
    fields: dict[str, str]
    source: str

    @property
    def cited_as(self) -> tuple[str, str]:
        """First author's surname, and the year with its letter: what a citation in the text says."""
        return self.fields["author"].split(",")[0], self.fields["year"] + self.fields.get("suffix", "")


def references() -> list[Reference]:
    """The bibliography by first author and year."""
    text = _BIBLIOGRAPHY.read_text(encoding="utf-8")
    found = [Reference(m[2], m[1], dict(_FIELD.findall(m[3])), m[0]) for m in _ENTRY.finditer(text)]
    return sorted(found, key=lambda reference: reference.cited_as)


def pages() -> dict[str, str]:
    """Markdown by path."""
    lines = [
        "# References",
        "",
        "The literature that the code and these pages cite, by first author and year. All entries as BibTeX:",
        "[references.bib](references.bib).",
        "",
        "## Cite symdyn",
        "",
        "Cite the paper that it implements, and the software. `CITATION.cff` in the repository has both.",
        "",
        "```bibtex",
        _paper().source,
        "",
        *_SOFTWARE,
        "```",
        "",
        "## Literature",
        "",
    ]
    for reference in references():
        lines += [_described(reference), "", "```bibtex", reference.source, "```", ""]
    return {PAGE: "\n".join(lines)}


def _paper() -> Reference:
    return next(reference for reference in references() if reference.key == "ding2025towards")


def _described(reference: Reference) -> str:
    fields = reference.fields
    authors = "; ".join(fields["author"].split(" and "))
    where = fields.get("journal") or fields.get("booktitle") or fields.get("publisher")
    text = f'<a id="{reference.key}"></a>**{" ".join(reference.cited_as)}.** {authors}: *{fields["title"]}*.'
    text += f" {where}." if where else ""
    if "eprint" in fields:
        text += f" [arXiv:{fields['eprint']}](https://arxiv.org/abs/{fields['eprint']})."
    if "doi" in fields:
        text += f" [doi:{fields['doi']}](https://doi.org/{fields['doi']})."
    return text


def on_page_content(content: str, page: Page, **_: object) -> str:
    """Turn citations in the text of a page into links."""
    if page.file.src_uri == PAGE:
        return content
    keys = {reference.cited_as: reference.key for reference in references()}
    home = page.file.src_uri.count("/") * "../" + PAGE.replace(".md", ".html")

    def linked(match: re.Match[str]) -> str:
        key = keys.get((match[1], match[2] + match[3]))
        return match[0] if key is None else f'<a href="{home}#{key}">{match[0]}</a>'

    parts, within = [], 0
    for part in _PART.split(content):
        name = re.match(r"</?(\w+)", part)
        if name is not None and name[1] in _UNTOUCHED:
            within += -1 if part.startswith("</") else 1
        parts.append(CITATION.sub(linked, part) if within == 0 and name is None else part)
    return "".join(parts)
