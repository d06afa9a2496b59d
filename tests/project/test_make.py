"""``make test`` runs every test: also those by the clock, which it looks for in a few folders only."""

from __future__ import annotations

import re
from pathlib import Path

from tests.conftest import ALONE, REAL_TIME

ROOT = Path(__file__).parents[2]


def test_every_test_by_the_clock_is_where_make_looks_for_it() -> None:
    (line,) = re.findall(r"^BY_THE_CLOCK := (.+)$", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    folders = [ROOT / folder for folder in line.split()]
    named = REAL_TIME | {name.partition("::")[0] for name in ALONE}
    tests = set((ROOT / "tests").rglob("test_*.py")) - {Path(__file__)}
    files = {path for path in tests if path.name in named or "mark.realtime" in path.read_text(encoding="utf-8")}
    assert len(files) > len(named)
    assert [file for file in files if not any(file.is_relative_to(folder) for folder in folders)] == []
