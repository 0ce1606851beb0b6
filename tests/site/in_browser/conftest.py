"""A built site with every kind of page, and Debian's Chromium to read it.

Without Chromium or playwright the tests are skipped with the reason; CI runs them with ``--no-skips``.
"""

import shutil
import threading
from collections.abc import Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest

from .made_site import Browser, BrowserContext, Page, Visit, write_site

PATIENCE = 120_000
"""Milliseconds until an action fails: a busy machine is slow, and a test that waits costs nothing."""


ARGUMENTS = ("--disable-gpu", "--in-process-gpu", "--renderer-process-limit=1")
"""Few processes: starting one costs more than most tests."""
NAMES = ("chromium", "chromium-browser", "google-chrome")


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """One Chromium of the system for all tests of this process."""
    api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed (extra `dev`)")
    path = next(filter(None, map(shutil.which, NAMES)), None)
    if path is None:
        pytest.skip("Chromium is not installed (on Debian: apt-get install chromium)")
    with api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, timeout=PATIENCE, args=list(ARGUMENTS))
        yield browser
        browser.close()


@pytest.fixture(scope="session")
def site(tmp_path_factory: pytest.TempPathFactory, browser: Browser) -> Path:
    """The folder of the site, built once; ``browser`` comes first, so that nothing is built without one."""
    return write_site(tmp_path_factory.mktemp("web") / "some" / "path")


@pytest.fixture(scope="session")
def address(site: Path) -> str:
    """The address of the site's folder as ``file://…/``."""
    return f"{site.as_uri()}/"


class Quiet(SimpleHTTPRequestHandler):
    """Serves files and logs nothing."""

    def log_message(self, format: str, *args: object) -> None:
        pass


@pytest.fixture(scope="session")
def http_address(site: Path) -> Iterator[str]:
    """The site below a sub-path of an HTTP server on this machine."""
    handler = partial(Quiet, directory=str(site.parents[1]))
    with ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.05})
        thread.start()
        yield f"http://127.0.0.1:{server.server_port}/some/path/"
        server.shutdown()
        thread.join()


@pytest.fixture(scope="module")
def profile(browser: Browser) -> Iterator[BrowserContext]:
    """A profile that the tests of a module share: the pages store nothing in it."""
    context = browser.new_context(viewport={"width": 1300, "height": 900}, accept_downloads=True)
    context.set_default_timeout(PATIENCE)
    yield context
    context.close()


@pytest.fixture
def page(profile: BrowserContext) -> Iterator[Page]:
    """An empty page of 1300 × 900 pixels."""
    page = profile.new_page()
    yield page
    page.close()


@pytest.fixture
def visit(page: Page, address: str) -> Visit:
    """Opens a page of the site from its file."""

    def opened(path: str) -> Page:
        page.goto(address + path)
        return page

    return opened
