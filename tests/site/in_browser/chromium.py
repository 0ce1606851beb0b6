"""Starts the Chromium of the system through playwright."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from playwright.sync_api import Browser

ARGUMENTS = ("--disable-gpu", "--in-process-gpu", "--renderer-process-limit=1")
"""Few processes: starting one costs more than most tests."""
NAMES = ("chromium", "chromium-browser", "google-chrome")


def start() -> Iterator[Browser]:
    """The browser; skips the test where playwright or Chromium is not installed."""
    api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed (extra `dev`)")
    path = next(filter(None, map(shutil.which, NAMES)), None)
    if path is None:
        pytest.skip("Chromium is not installed (on Debian: apt-get install chromium)")
    with api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, timeout=120_000, args=list(ARGUMENTS))
        yield browser
        browser.close()
