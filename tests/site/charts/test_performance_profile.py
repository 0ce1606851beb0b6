"""Performance profiles: drawn from the document's points, said in words, absent with a reason."""

from __future__ import annotations

import re
from typing import Any
from xml.etree import ElementTree

import pytest

from gym_extensions.site.charts import performance_profile as profiles
from gym_extensions.site.charts.performance_profile import Line
from gym_extensions.site.page import Leaderboard

from ..reading import files, typed

HALVES = ((-0.5, 1.0), (0.0, 1.0), (0.5, 0.5), (1.0, 0.25), (1.5, 0.0), (2.0, 0.0))
TAUS, SHARES = (list(side) for side in zip(*HALVES, strict=True))
HOSTILE = '"><script>alert(1)</script>'
UNSOLVED = "Every task of this group is unsolved: no reference agent has learned it."


def scores(document: dict[str, Any], entry: int = 0) -> dict[str, Any]:
    """The sequential scores of an entry on the Hopper gravity group."""
    found: dict[str, Any] = document["submissions"][entry]["groups"]["hopper-gravity-v0"]["sequential"]
    return found


def profiled(document: dict[str, Any], *entries: int) -> dict[str, str]:
    """The site, with that profile and an interquartile mean for these entries."""
    for entry in entries:
        scores(document, entry).update(profile={"tau": TAUS, "fraction": SHARES}, iqm=0.4321)
    return dict(files(document))


def said(page: str) -> str:
    """A page's text, spaces evened."""
    return re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", page))


def test_a_profile_goes_from_upper_left_to_lower_right_through_the_documents_points() -> None:
    line = Line("p1", "Agile", None, HALVES)
    drawn = ElementTree.fromstring(profiles.of_board([line])).findall("polyline")
    assert [one.get("points") for one in drawn] == [
        "40.0,24.0 106.4,24.0 172.8,94.0 239.2,129.0 305.6,164.0 372.0,164.0"
    ]


def test_points_on_a_level_between_two_others_are_left_out() -> None:
    flat = tuple((step / 20, 1.0) for step in range(-10, 41))
    drawn = ElementTree.fromstring(profiles.of_board([Line("p1", "", None, flat)])).findall("polyline")
    assert [one.get("points") for one in drawn] == ["40.0,24.0 372.0,24.0"]


def test_a_profile_is_told_in_words_at_the_floor_the_reference_and_beyond() -> None:
    words = "above 0: 100 %, above 0.5: 50 %, above 1: 25 %, above 2: 0 %"
    assert profiles.said(HALVES).replace("\u202f", " ") == words
    label = ElementTree.fromstring(profiles.of_board([Line("p1", "Agile", None, HALVES)])).get("aria-label")
    assert str(label).replace("\u202f", " ") == f"Agile: {words}"


def test_both_scales_have_numbers_and_names() -> None:
    texts = [text.text for text in ElementTree.fromstring(profiles.of_board([Line("p1", "", None, HALVES)]))]
    for text in (
        *("0\u202f%", "50\u202f%", "100\u202f%", "−0.5", "0", "0.5", "1", "1.5", "2"),
        "share of runs and tasks above the score",
        "score at the end (0 floor, 1 reference)",
    ):
        assert text in texts


def test_the_boards_first_entry_lies_uppermost_and_lines_beyond_the_sixth_share_a_grey(
    document: dict[str, Any],
) -> None:
    profiled(document, 0, 1)
    (row, *_) = next(
        one for one in Leaderboard(typed(document)).boards if one.group == "hopper-gravity-v0"
    ).rows
    lines = profiles.lines([row] * 8)
    assert [line.kind for line in lines] == ["p1", "p2", "p3", "p4", "p5", "p6", "p0", "p0"]
    drawn = ElementTree.fromstring(profiles.of_board(lines)).findall("polyline")
    assert [one.get("class") for one in drawn] == [f"line {line.kind}" for line in reversed(lines)]


def test_an_entrys_page_draws_its_profile_and_sets_the_interquartile_mean_beside_the_mean(
    document: dict[str, Any],
) -> None:
    page = profiled(document, 0)["submissions/agile.html"]
    assert page.count('<svg class="profile"') == 1
    assert "Above 0: 100 %, above 0.5: 50 %, above 1: 25 %, above 2: 0 %" in said(page)
    row = page.split("#final_performance")[-1].split("</tr>")[0]
    assert "interquartile mean 0.43" in said(row)
    assert "interquartile mean" not in said(page.split("#learning_performance")[-1].split("</tr>")[0])


def test_a_board_draws_the_entries_that_have_a_profile_and_names_each_line(document: dict[str, Any]) -> None:
    board = profiled(document, 0, 1)["index.html"].split('id="hopper-gravity-v0-sequential-100k"')[1]
    board = board.split("</section>")[0]
    drawing, key = board.split('<svg class="profile"')[1].split("</svg>", maxsplit=1)
    assert drawing.count("<polyline") == 2
    assert re.findall(r"<title>(\w+)</title>", drawing) == ["Keeper", "Agile"]
    named = re.findall(r'class="line (p\d)".*?</svg> (\w+)', key)
    assert named == [("p1", "Agile"), ("p2", "Keeper")]
    assert "0.43" in said(key)


def test_a_board_on_which_nobody_has_a_profile_draws_none(document: dict[str, Any]) -> None:
    assert "Performance profile:" not in dict(files(document))["index.html"]


@pytest.mark.parametrize("entry", ["Title & sons", HOSTILE])
def test_an_entrys_title_stays_text_in_the_drawing(document: dict[str, Any], entry: str) -> None:
    document["submissions"][0]["title"] = entry
    page = profiled(document, 0)["index.html"]
    assert "<script" not in page
    svg = '<svg class="profile"' + page.split('<svg class="profile"')[1].split("</svg>")[0] + "</svg>"
    assert ElementTree.fromstring(svg).findtext("polyline/title") == entry


def test_without_a_profile_the_page_says_why(document: dict[str, Any]) -> None:
    null: dict[str, Any] = {"mean": None, "low": None, "high": None, "runs": [], "why": UNSOLVED}
    scores(document).update(profile=None, iqm=None)
    scores(document)["metrics"]["final_performance"] = null
    page = dict(files(document))["submissions/agile.html"]
    assert '<svg class="profile"' not in page
    assert f"No performance profile. {UNSOLVED}" in said(page)
    scores(document)["metrics"] = dict.fromkeys(scores(document)["metrics"], null)
    page = dict(files(document))["submissions/agile.html"]
    assert f"No metrics. {UNSOLVED} Nor is there a performance profile." in said(page)
