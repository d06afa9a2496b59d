"""The page that says what is checked names tests that exist."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_every_test_on_the_page_is_there():
    named = re.findall(r"`(tests/[^`]+)`", (ROOT / "docs" / "checks.md").read_text(encoding="utf-8"))
    assert len(named) > 15
    assert [name for name in named if not list(ROOT.glob(name))] == []
