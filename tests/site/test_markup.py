"""Every page has valid markup and working links, is accessible, and loads nothing from other hosts."""

import base64
import hashlib
import re
from itertools import pairwise
from pathlib import Path
from urllib.parse import urlsplit

import pytest

from gym_extensions.catalog.tasks import TASKS
from gym_extensions.site import FOLDER
from gym_extensions.site.charts.task_pictures import pictures
from gym_extensions.site.pages.page import TASK_LIST
from gym_extensions.site.paths import task_path

from .browser import Pages, beside, files
from .conftest import everything

BOARD = "boards/hopper-gravity-v0-sequential-100k.html"
POLICY = (
    "default-src 'none'; img-src 'self' data:; style-src 'self'; script-src 'self'; base-uri 'none'; "
    "form-action 'none'"
)

ROOT = Path(__file__).resolve().parents[2]
LOADING = {"src", "srcset", "data", "poster", "action", "formaction", "background", "xlink:href"}


@pytest.fixture(scope="module")
def texts() -> dict[str, str]:
    """The text of every file of the site by path."""
    return dict(files(everything()))


@pytest.fixture(scope="module")
def pages(texts: dict[str, str]) -> Pages:
    return Pages({path: text for path, text in texts.items() if path.endswith(".html")})


def test_every_page_has_valid_markup_unique_ids_and_labels_that_exist(pages: Pages) -> None:
    for path, page in pages.items():
        assert page.errors == [], path
        assert sorted(set(page.ids)) == sorted(page.ids), path
        labels = {a["aria-labelledby"] for _, a in page.elements if "aria-labelledby" in a}
        assert labels <= {*page.ids}, path


def test_every_internal_link_leads_to_an_existing_page_and_anchor(
    pages: Pages, texts: dict[str, str]
) -> None:
    paths = {*texts, *(f"pictures/{file.name}" for file in pictures().values())}
    paths |= {TASK_LIST, *map(task_path, TASKS)}
    ids = {path: page.ids for path, page in pages.items()}
    followed = 0
    for path, page in pages.items():
        for target, anchor in page.links(path):
            assert target in paths, f"{path} links to {target}"
            if anchor and not anchor.startswith("?"):  # the state of a table
                assert anchor in ids[target], f"{path} links to {target}#{anchor}"
            followed += 1
    assert followed > 50


def test_no_page_loads_anything_from_another_host(pages: Pages, texts: dict[str, str]) -> None:
    paths = {*texts, *(f"pictures/{file.name}" for file in pictures().values())}
    for path, page in pages.items():
        if path == "404.html":  # hosts show it at any depth: its own script finds the root of the site
            script = re.search("<script>(.*)</script>", texts[path])
            assert script
            digest = base64.b64encode(hashlib.sha256(script[1].encode()).digest()).decode()
            allowed = f"script-src 'self' 'sha256-{digest}'; base-uri 'self'"
            assert page.policy == POLICY.replace("script-src 'self'; base-uri 'none'", allowed)
            continue
        assert page.policy == POLICY, path
        for tag, attributes in page.elements:
            loaded = {attributes[name] for name in LOADING & set(attributes)}
            assert all(beside(path, name) in paths for name in loaded)
            assert tag not in {"iframe", "object", "embed", "base", "form", "style"}, path
            assert tag != "script" or loaded, f"{path}: inline script"
            assert "style" not in attributes, f"{path}: <{tag}> has a style attribute"
            address = urlsplit(attributes.get("href", ""))
            if address.scheme and tag != "a":
                assert attributes["href"] == "data:,", f"{path}: <{tag}> {attributes['href']}"
            if tag == "a" and address.scheme:
                assert address.scheme in {"http", "https"}, f"{path}: {attributes['href']}"
    sheet = texts["static/style.css"]
    assert "url(" not in sheet
    assert "@import" not in sheet


@pytest.mark.parametrize(
    "path", ["index.html", "groups/hopper-gravity-v0.html", BOARD, "submissions/agile.html", "metrics.html"]
)
def test_a_page_is_accessible_to_screen_readers(pages: Pages, path: str) -> None:
    page = pages[path]
    tags = [tag for tag, _ in page.elements]
    assert dict(page.elements)["html"] == {"lang": "en"}
    viewport = {"name": "viewport", "content": "width=device-width, initial-scale=1"}
    assert ("meta", viewport) in page.elements
    assert tags.count("h1") == tags.count("main") == 1
    assert tags.index("title") < tags.index("body")
    assert all(attributes.get("scope") for tag, attributes in page.elements if tag == "th")
    for attributes in (attributes for tag, attributes in page.elements if tag == "svg"):
        assert attributes.get("aria-hidden") or (attributes["role"] == "img" and attributes["aria-label"])


def test_headings_skip_no_level(pages: Pages) -> None:
    for path, page in pages.items():
        levels = [int(tag[1]) for tag, _ in page.elements if re.fullmatch("h[1-6]", tag)]
        assert levels[:1] == [1], f"{path} begins with an h1"
        assert all(after <= before + 1 for before, after in pairwise(levels)), path


def test_no_line_of_a_template_is_longer_than_160_characters() -> None:
    for path in (*(FOLDER / "templates").iterdir(), *(ROOT / "tools" / "findings").glob("*.jinja")):
        assert max(map(len, path.read_text(encoding="utf-8").splitlines())) <= 160, path.name
