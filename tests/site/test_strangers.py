"""What strangers write in a submission is text on its pages, and never more."""

from __future__ import annotations

import re
from typing import Any
from urllib.parse import urlsplit

import pytest

from gym_extensions.site.page import addresses

from .reading import read

HOSTILE = '<script>alert("1")</script><img src=x onerror=alert(1)>{{ 7*7 }}'


def test_the_only_way_out_is_the_code_that_a_submitter_names(document: dict[str, Any]) -> None:
    out = {
        attributes["href"]
        for page in read(document).values()
        for tag, attributes in page.elements
        if tag == "a" and urlsplit(attributes["href"]).scheme
    }
    assert out == {"https://example.org/agent"}


@pytest.mark.parametrize(
    "url",
    [
        "javascript:alert(1)",
        " javascript:alert(1)",
        "data:text/html,x",
        "//example.org",
        "https:",
        "file:///etc",
    ],
)
def test_a_code_address_that_is_not_of_the_web_is_text_and_no_link(
    document: dict[str, Any], url: str
) -> None:
    document["submissions"][0]["manifest"]["code"]["url"] = url
    page = read(document)["submissions/agile.html"]
    assert url.strip() in page.said
    assert url not in {attributes.get("href") for _, attributes in page.elements}


def test_a_strangers_words_are_only_ever_text(document: dict[str, Any]) -> None:
    first, broken = document["submissions"][0], document["submissions"][-1]
    first["title"] = broken["title"] = HOSTILE
    first["manifest"].update(
        description=HOSTILE,
        authors=[HOSTILE],
        code={"url": f"https://x/{HOSTILE}", "commit": HOSTILE},
        protocol={"budget": "100k", "algorithm": HOSTILE, "evaluation": "sampled"},
        hyperparameters={HOSTILE: [HOSTILE]},
        versions={HOSTILE: HOSTILE},
    )
    first["notes"] = [HOSTILE]
    broken["problems"] = [{"rule": HOSTILE, "where": HOSTILE, "message": HOSTILE, "hint": HOSTILE}]
    scores = first["groups"]["hopper-gravity-v0"]["sequential"]
    scores["metrics"]["asymptotic_transfer"]["why"] = scores["metrics"]["forgetting"]["why"] = HOSTILE
    scores["metrics"]["forgetting"]["mean"] = None
    for path, page in read(document).items():
        assert page.faults == [], path
        tags = {tag for tag, _ in page.elements}
        assert not tags & {"script", "img"}, path
        assert not [
            name for _, attributes in page.elements for name in attributes if name.startswith("on")
        ], path
    said = read(document)["submissions/agile.html"].said
    assert said.count(re.sub(r"\s+", " ", HOSTILE)) >= 8
    assert "49" not in read(document)["index.html"].said.split("leads")[0]


def test_a_hostile_name_stays_inside_the_folder() -> None:
    found = addresses(["../../etc/passwd", "..", "a/b", "Random", "random", "é", "x" * 300, "plain-1"])
    assert found["plain-1"] == "submissions/plain-1.html"
    assert found["random"] == "submissions/random.html"
    assert len({path.lower() for path in found.values()}) == len(found)
    for path in found.values():
        assert re.fullmatch(r"submissions/[a-z0-9-]{1,100}\.html", path), path
