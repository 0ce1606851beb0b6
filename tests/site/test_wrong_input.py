"""Unusual submissions give readable pages: none, one with one run, long names, every kind of character."""

from typing import Any

import pytest

from gym_extensions.catalog.groups import group

from .browser import Pages, read
from .conftest import everything, learner, make_submission, scored

BOARD = "boards/hopper-gravity-v0-sequential-100k.html"
GROUP = "groups/hopper-gravity-v0.html"
TITLES = {
    "200 characters": "W" * 200,
    "joined emoji": "\N{MAN}\N{ZERO WIDTH JOINER}\N{WOMAN}" * 60,
    "right to left": "\N{HEBREW LETTER ALEF}\N{HEBREW LETTER BET} 0.99 " * 20,
}


def only(*submissions: dict[str, Any]) -> dict[str, Any]:
    """A document of these submissions."""
    return {**everything(), "submissions": list(submissions)}


def one_run() -> dict[str, Any]:
    """A submission with one run on one group."""
    scores = scored("hopper-gravity", learner(0.9, 0.75, 1))
    return make_submission("single", {"hopper-gravity-v0": {"sequential": scores}}, "Single")


def valid(pages: Pages) -> None:
    """Every page has valid markup."""
    assert {path: pages[path].errors for path in pages if pages[path].errors} == {}


def test_without_any_submission_every_page_says_so() -> None:
    pages = read(only())
    valid(pages)
    for path, said in {
        "index": "no submissions",
        "submissions": "no submissions",
        "core": "No submission",
    }.items():
        assert said in pages[f"{path}.html"].text
    assert "nothing yet" in pages["groups.html"].text
    assert not [path for path in pages if path.startswith("boards/")]


def test_one_submission_with_one_run_has_values_without_intervals() -> None:
    pages = read(only(one_run()))
    valid(pages)
    for said in ("one run", "No submission is ranked yet.", "Not ranked: Fewer than 5 runs."):
        assert said in pages[GROUP].text
    assert "hopper-gravity 1 submission, none ranked" in pages["groups.html"].text
    assert "No method has runs on the core suite yet." in pages["index.html"].text


def test_a_group_that_nobody_entered_has_its_tasks_and_says_how_to_enter() -> None:
    page = read(only(one_run()))["groups/striker-v0.html"].text
    assert "Nobody has entered this group yet." in page
    assert "train AGENT --groups striker --out submissions/NAME" in page
    for task in group("striker").task_ids:
        assert task.rsplit("/")[-1].removesuffix("-v0")[:7] in page


def test_a_submission_without_optional_parts_renders() -> None:
    submission = one_run()
    submission["manifest"] |= {"tuning": None, "memory": None}
    scores = submission["groups"]["hopper-gravity-v0"]["sequential"]
    scores.update(paper_table=[], paper_total=None, profile=None, iqm=None)
    pages = read(only(submission))
    valid(pages)
    assert "not stated" in pages[BOARD].text


@pytest.mark.parametrize("title", TITLES.values(), ids=list(TITLES))
def test_any_title_stays_in_its_place_and_is_shortened_in_tables(title: str) -> None:
    document = everything()
    for each in document["submissions"]:
        each["title"] = title
    pages = read(document)
    valid(pages)
    for path in (GROUP, BOARD, "submissions.html", "submissions/agile.html"):
        assert "agile" in pages[path].text, f"{path} has no folder name"
    assert title[:100] not in pages["index.html"].text
