"""Every citation in code and docs has an entry in the bibliography, every entry is cited, and symdyn can be cited."""

from __future__ import annotations

import re
import subprocess
import tomllib
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture
def hook(monkeypatch) -> ModuleType:
    """The site's hook that reads the bibliography."""
    pytest.importorskip("mkdocs")
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "hooks"))
    import references

    return references


def tracked(*endings: str) -> list[Path]:
    """Files of the repository with these endings."""
    command = ["git", "ls-files", "--", *(f"*.{ending}" for ending in endings)]
    names = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.splitlines()
    return [ROOT / name for name in names]


def citations(hook: ModuleType, text: str) -> set[tuple[str, str]]:
    """First author and year of every citation; one may go on in the next line, behind a comment sign."""
    joined = re.sub(r"\s*\n\s*(?:# )?", " ", text)
    return {(match[1], match[2] + match[3]) for match in hook.CITATION.finditer(joined)}


def test_every_citation_has_an_entry_and_every_entry_is_cited(hook):
    entries = {reference.cited_as for reference in hook.references()}
    assert len(entries) == len(hook.references()) > 15
    paper = ("Ding", "2025")
    cited: dict[tuple[str, str], list[str]] = {}
    for path in tracked("py", "md", "toml"):
        if path.exists() and "tests" not in path.relative_to(ROOT).parts:
            for citation in citations(hook, path.read_text(encoding="utf-8")):
                cited.setdefault(citation, []).append(str(path.relative_to(ROOT)))
    assert {citation: where for citation, where in cited.items() if citation not in entries} == {}
    assert entries - set(cited) - {paper} == set()


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("as in Gan et al. (2016), and", ("Gan", "2016")),
        ("(Golubitsky, Stewart, Buono & Collins 1999)", ("Golubitsky", "1999")),
        ("(Izmailov et al.\n            2018)", ("Izmailov", "2018")),
        ("(De Luca et al. 2006; more", ("De Luca", "2006")),
        ("Bledt et al. 2018b", ("Bledt", "2018b")),
        ("Flash and Hogan 1985", ("Flash", "1985")),
        ("# (Hildebrand 1965: a", ("Hildebrand", "1965")),
    ],
)
def test_citations_are_found_in_every_form_that_the_docs_use(hook, text, found):
    assert citations(hook, text) == {found}


def test_a_citation_in_the_text_of_a_page_links_to_its_entry_and_one_in_code_does_not(hook):
    from mkdocs.structure.files import File
    from mkdocs.structure.pages import Page

    file = File("theory/slip.md", "docs", "site", use_directory_urls=False)
    html = "<p>by Gan et al. (2016) <code>Gan et al. (2016)</code></p>"
    page = Page.__new__(Page)
    page.file = file
    linked = hook.on_page_content(html, page)
    assert linked.count("<a ") == 1
    assert '<a href="../references.html#gan2016passive">Gan et al. (2016</a>)' in linked
    assert "<code>Gan et al. (2016)</code>" in linked


def test_the_entries_are_complete_bibtex(hook):
    for reference in hook.references():
        assert {"author", "title", "year"} <= set(reference.fields), reference.key
        assert reference.source.count("{") == reference.source.count("}")
        if reference.kind in ("article", "inproceedings", "book"):
            assert {"journal", "booktitle", "publisher"} & set(reference.fields), reference.key
        if "eprint" in reference.fields:
            assert re.fullmatch(r"\d{4}\.\d{5}", reference.fields["eprint"])


def test_the_citation_file_names_the_paper_and_the_version_of_the_package(hook):
    yaml = pytest.importorskip("yaml")
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    # what version 1.2.0 of the format requires
    assert citation["cff-version"] == "1.2.0"
    assert citation["message"]
    assert citation["authors"]
    assert citation["version"] == project["version"]
    assert citation["license"] == project["license"]
    (paper,) = citation["references"]
    (entry,) = [reference for reference in hook.references() if reference.cited_as == ("Ding", "2025")]
    assert paper["title"] == entry.fields["title"]
    assert paper["identifiers"][0]["value"] == f"arXiv:{entry.fields['eprint']}" == "arXiv:2510.10455"
    names = [f"{author['family-names']}, {author['given-names']}" for author in paper["authors"]]
    assert " and ".join(names) == entry.fields["author"]
