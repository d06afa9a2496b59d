"""Chromium without a screen, driven by Playwright; where there is none, tests are skipped, with the reason."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

REQUIRED = "SYMDYN_TEST_BROWSER"
"""Set to ``required`` where Chromium is installed: then a test that finds none fails."""

CHROMIUM = Path("/usr/bin/chromium")

PATIENCE_MS = 240_000
"""How long a page may take: drawn without a graphics card, a picture takes a second where others work as well."""

_FLAGS = ("--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")


@contextmanager
def open_page(url: str, width: int = 1100, height: int = 700) -> Iterator:
    """A page of Chromium at an address; the errors of its scripts are in its ``errors``."""
    if not CHROMIUM.exists():
        problem = f"{CHROMIUM} is not there: apt-get install chromium"
        if os.environ.get(REQUIRED) == "required":
            pytest.fail(problem)
        pytest.skip(problem)
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=list(_FLAGS), timeout=PATIENCE_MS)
        try:
            page = browser.new_page(viewport={"width": width, "height": height})
            page.set_default_timeout(PATIENCE_MS)
            page.errors = []
            page.on("pageerror", lambda error: page.errors.append(str(error)))
            page.goto(url)
            yield page
        finally:
            browser.close()
