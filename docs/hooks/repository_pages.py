"""Files of the repository outside docs/ that the site shows, too."""

from __future__ import annotations

from checkout import ROOT

_RESULTS = "results/files.md"


def pages() -> dict[str, str]:
    """Markdown by path."""
    return {
        "changelog.md": (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"),
        "model-card.md": (ROOT / "rl" / "pretrained" / "README.md").read_text(encoding="utf-8"),
        _RESULTS: _result_files(),
    }


def result_files_page() -> str:
    """Where the list of the results' files is."""
    return _RESULTS


def _result_files() -> str:
    files = sorted((ROOT / "docs" / "results").glob("*.json"))
    rows = [f"| [`{file.name}`]({file.name}) | {file.stat().st_size / 1e3:.0f} kB |" for file in files]
    head = [
        "# Files of the results",
        "",
        "Every number behind [the results](../results.md), an experiment a file, as `symdyn experiment` wrote it.",
        "",
        "| file | size |",
        "|---|---|",
    ]
    return "\n".join([*head, *rows]) + "\n"
