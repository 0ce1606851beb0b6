"""Every kind of page is read by a strict HTML parser without an error."""

from typing import Any

import pytest

from .browser import site_files

html5lib = pytest.importorskip("html5lib", reason="html5lib is not installed (extra `dev`)")


def errors(text: str) -> list[str]:
    """What the parser of the HTML standard reports, with the position."""
    parser = html5lib.HTMLParser(strict=False)
    parser.parse(text)
    return [f"{position}: {code} {data}" for position, code, data in parser.errors]


def test_pages_are_parsed_without_an_error(document: dict[str, Any]) -> None:
    document["submissions"] = document["submissions"][:3]
    seen = set[str]()
    for path, text in site_files(document):
        kind = path.partition("/")[0]
        if path.endswith(".html") and kind not in seen:
            seen.add(kind)
            assert errors(text) == [], path
    assert {"boards", "groups", "submissions", "tasks", "index.html", "metrics.html"} <= seen
