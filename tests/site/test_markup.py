"""Every page: well formed, linked, readable aloud, without a request to anywhere."""

from __future__ import annotations

import posixpath
import re
from itertools import pairwise
from typing import Any
from urllib.parse import urlsplit

import pytest

from .reading import Reader, files, read

LOADING = {"src", "srcset", "data", "poster", "action", "formaction", "background", "xlink:href"}


def test_every_page_is_well_formed(document: dict[str, Any]) -> None:
    found = {path: page.faults for path, page in read(document).items() if page.faults}
    assert found == {}


def test_the_reader_of_these_tests_finds_what_is_wrong() -> None:
    assert Reader("<p><b>x</p>").faults == [
        "</p> where ['b'] is open",
        "<p> is never closed",
        "<b> is never closed",
    ]
    assert Reader('<a id="x" id="y"></a>').faults == ["id twice in <a>"]


def test_every_id_of_a_page_is_its_only_one(document: dict[str, Any]) -> None:
    for path, page in read(document).items():
        assert sorted(set(page.ids)) == sorted(page.ids), path


def test_every_link_inside_the_site_leads_to_a_page_and_a_place_on_it(document: dict[str, Any]) -> None:
    everything = dict(files(document))
    ids = {path: page.ids for path, page in read(document).items()}
    followed = 0
    for path, page in read(document).items():
        for _, attributes in page.elements:
            address = urlsplit(attributes.get("href", ""))
            if not attributes.get("href") or address.scheme:
                continue
            target = (
                posixpath.normpath(posixpath.join(posixpath.dirname(path), address.path))
                if address.path
                else path
            )
            assert target in everything, f"{path} links to {attributes['href']}"
            if address.fragment:
                assert address.fragment in ids[target], f"{path} links to {attributes['href']}"
            followed += 1
    assert followed > 50


def test_every_label_by_id_names_something_on_the_page(document: dict[str, Any]) -> None:
    for path, page in read(document).items():
        for tag, attributes in page.elements:
            label = attributes.get("aria-labelledby")
            assert label is None or label in page.ids, f"{path}: <{tag}> is labelled by {label}"


def test_no_page_asks_another_host_for_anything(document: dict[str, Any]) -> None:
    for path, page in read(document).items():
        for tag, attributes in page.elements:
            assert not LOADING & set(attributes), f"{path}: <{tag}> loads something"
            assert tag not in {"script", "iframe", "object", "embed", "base", "form"}, path
            address = urlsplit(attributes.get("href", ""))
            if address.scheme and tag != "a":
                assert attributes["href"] == "data:,", f"{path}: <{tag}> {attributes['href']}"
            if tag == "a" and address.scheme:
                assert address.scheme in {"http", "https"}, f"{path}: {attributes['href']}"
    sheet = dict(files(document))["static/style.css"]
    assert "url(" not in sheet
    assert "@import" not in sheet


@pytest.mark.parametrize("path", ["index.html", "submissions/agile.html", "metrics.html"])
def test_a_page_can_be_read_by_a_machine_that_reads_aloud(document: dict[str, Any], path: str) -> None:
    page = read(document)[path]
    tags = [tag for tag, _ in page.elements]
    assert dict(page.elements)["html"] == {"lang": "en"}
    assert {"name": "viewport", "content": "width=device-width, initial-scale=1"} in [
        a for _, a in page.elements
    ]
    assert tags.count("h1") == tags.count("main") == 1
    assert tags.index("title") < tags.index("body")
    assert tags.count("caption") == tags.count("table")
    assert all(attributes.get("scope") for tag, attributes in page.elements if tag == "th")
    for tag, attributes in page.elements:
        if tag == "svg":
            assert attributes.get("aria-hidden") or (attributes["role"], bool(attributes["aria-label"])) == (
                "img",
                True,
            )


def test_headings_go_down_one_step_at_a_time(document: dict[str, Any]) -> None:
    for path, page in read(document).items():
        levels = [int(tag[1]) for tag, _ in page.elements if re.fullmatch("h[1-6]", tag)]
        assert levels[0] == 1
        assert all(after <= before + 1 for before, after in pairwise(levels)), path


@pytest.mark.parametrize("place", [".lines li", ".glance td.leader", ".glance .sure"])
def test_a_title_without_spaces_may_break_where_a_box_grows_with_its_words(
    document: dict[str, Any], place: str
) -> None:
    sheet = dict(files(document))["static/style.css"]
    (rule,) = re.findall(rf"^{re.escape(place)} {{(.*)}}$", sheet, re.MULTILINE)
    assert "overflow-wrap: anywhere" in rule
