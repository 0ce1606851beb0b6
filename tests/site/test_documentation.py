"""With the documentation, pages link to it and search in it; without it, they name its files."""

import posixpath
import re
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from gym_extensions.site.pages import PAGES, docs_masthead
from gym_extensions.site.pages.page import TASK_LIST

from ..test_project_files import anchors
from .browser import Reader, site_files

ROOT = Path(__file__).parents[2]
KINDS = tuple(page for page in PAGES if page.path != TASK_LIST)
ROOT_PAGES = {
    "docs/index.html": "README.md",
    "docs/changelog.html": "CHANGELOG.md",
    "docs/adr/index.html": "docs/adr/README.md",
}


def pages(document: dict[str, Any], docs: bool) -> dict[str, Reader]:
    """The pages of the root and of a group and a submission, by path."""
    shown = re.compile(r"[\w-]+\.html|groups/hopper-gravity-v0\.html|submissions/agile\.html")
    files = site_files(document, KINDS, docs=docs)
    return {path: Reader(text) for path, text in files if shown.fullmatch(path)}


def test_links_lead_to_files_and_headings_of_the_documentation(document: dict[str, Any]) -> None:
    found = set()
    for path, page in pages(document, docs=True).items():
        for _, attributes in page.elements:
            address = urlsplit(attributes.get("href", ""))
            target = posixpath.normpath(posixpath.join(posixpath.dirname(path), address.path))
            if target.startswith("docs/"):
                found.add(target)
                file = ROOT / ROOT_PAGES.get(target, target.replace(".html", ".md"))
                assert file.is_file(), f"{path} links to {target}"
                known = {"", *anchors(file.read_text("utf-8"))}
                assert address.fragment in known, f"{path}: {attributes['href']}"
    assert {f"docs/{name}.html" for name in ("index", "submit", "metrics", "experts", "speed")} <= found


def test_without_the_documentation_files_are_named_after_their_titles_and_nothing_links_to_them(
    document: dict[str, Any],
) -> None:
    for path, page in pages(document, docs=False).items():
        links = [attributes.get("href", "") for _, attributes in page.elements]
        assert not [link for link in links if "docs/" in link], path
        assert "form-action 'none'" in page.policy
        if path == "index.html":
            assert "how to submit ( docs/submit.md )" in page.text
            assert "submit" in page.ids
        for file in re.findall(r"docs/[\w/-]+\.md", page.text):
            assert (ROOT / file).is_file(), f"{path} names {file}"


def test_the_search_field_of_every_page_opens_the_search(document: dict[str, Any]) -> None:
    for path, page in pages(document, docs=True).items():
        (form,) = [attributes for tag, attributes in page.elements if tag == "form"]
        root = "../" if "/" in path else ""
        assert form == {"role": "search", "action": f"{root}search.html"}
        (field,) = [attributes for _, attributes in page.elements if attributes.get("name") == "q"]
        assert field["type"] == "search"
        assert page.policy.endswith("form-action 'self'")
        assert page.errors == []


def test_pages_of_the_documentation_have_the_same_menu(document: dict[str, Any]) -> None:
    def menu(page: Reader) -> list[str]:
        inside = [attributes["href"] for tag, attributes in page.elements if tag == "a"]
        links = [link.removeprefix("../../") for link in inside]
        return [link for link in links if link != TASK_LIST]  # the pages of tasks are not part of this site

    header = Reader(docs_masthead("api/envs.html"))
    overview = pages(document, docs=True)["index.html"]
    assert header.errors == []
    links = menu(header)
    assert links == menu(overview)[1 : 1 + len(links)], "after the link to the content"
    assert len(links) > 8
    current = [a["href"] for _, a in Reader(docs_masthead("submit.html")).elements if a.get("aria-current")]
    assert current == ["../docs/submit.html", "../docs/index.html"]
