"""Text from a submission is only ever text on its pages."""

import re
from typing import Any
from urllib.parse import urlsplit

from gym_extensions.site.paths import submission_path

from .browser import read
from .conftest import scores_of

HOSTILE = '<script>alert("1")</script><img src=x onerror=alert(1)>{{ 7*7 }}'


def test_the_only_external_link_is_the_code_of_a_submission(document: dict[str, Any]) -> None:
    document["submissions"][0]["readme"] = (
        "[Code](https://example.org/b) https://example.org/c <a href='https://x'>"
    )
    links = {
        attributes["href"]
        for page in read(document).values()
        for tag, attributes in page.elements
        if tag == "a" and urlsplit(attributes["href"]).scheme
    }
    assert links == {"https://example.org/agent"}


def test_markup_in_a_submission_is_escaped(document: dict[str, Any]) -> None:
    first, broken = document["submissions"][0], document["submissions"][-1]
    first["title"] = broken["title"] = HOSTILE
    first["manifest"].update(
        description=HOSTILE,
        authors=[HOSTILE],
        code={"url": "", "commit": HOSTILE},
        protocol={"budget": "100k", "algorithm": HOSTILE, "evaluation": "sampled"},
        hyperparameters={HOSTILE: [HOSTILE]},
    )
    first["notes"] = [HOSTILE]
    decision = {"action": "challenged", "by": HOSTILE, "date": "2026-11-22", "reason": HOSTILE}
    first["decisions"] = [decision]
    first["readme"] = broken["readme"] = f"</pre>{HOSTILE}"
    broken["problems"] = [{"rule": HOSTILE, "where": HOSTILE, "message": HOSTILE, "hint": HOSTILE}]
    scores = scores_of(document)
    scores.update(profile={"tau": [0.0, 1.0], "fraction": [1.0, 0.5]}, iqm=0.4)  # whose lines have the title
    scores["metrics"]["asymptotic_transfer"]["why"] = scores["metrics"]["forgetting"]["why"] = HOSTILE
    scores["metrics"]["forgetting"]["mean"] = None
    pages = read(document)
    for path, page in pages.items():
        assert page.errors == [], path
        images = [attributes["src"] for tag, attributes in page.elements if tag == "img"]
        assert all("pictures/" in source for source in images), path
        scripts = [a["src"] for tag, a in page.elements if tag == "script" and path != "404.html"]
        assert all("static/" in source or source == "api/compare.js" for source in scripts)
        assert not [
            name for _, attributes in page.elements for name in attributes if name.startswith("on")
        ], path
    text = pages["submissions/agile.html"].text
    assert text.count(re.sub(r"\s+", " ", HOSTILE)) >= 9
    assert "49" not in pages["submissions.html"].text


def test_a_hostile_name_stays_inside_the_folder_of_submissions() -> None:
    names = ["../../etc/passwd", "..", "a/b", "Random", "random", "é", "x" * 300, "plain-1", "a\ud800"]
    paths = {name: submission_path(name) for name in names}
    assert paths["plain-1"] == "submissions/plain-1.html"
    assert paths["random"] == "submissions/random.html"
    assert len({path.lower() for path in paths.values()}) == len(paths)
    for path in paths.values():
        assert re.fullmatch(r"submissions/[a-z0-9_-]{1,100}\.html", path), path
