"""Landscapes on the pages: maps, their numbers in words, and the table of a board."""

import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from xml.etree import ElementTree

import pytest

from gym_extensions.catalog.groups import group
from gym_extensions.catalog.worlds import axes
from gym_extensions.site.pages.landscapes import small
from gym_extensions.submissions import landscapes as scored
from gym_extensions.submissions.landscapes import Landscape, MeasuredAxis
from gym_extensions.submissions.review import Decision, Review, write_review

from ..browser import Reader, files
from ..conftest import MADE, scores_of

GROUP = group("hopper-gravity")
(AXIS,) = axes(GROUP)
POINTS = len(AXIS.points)
PAGE, BOARD = "submissions/agile.html", "groups/hopper-gravity-v0.html"


def landscape(last: float) -> Landscape:
    """Two runs whose returns rise from stage to stage, the same at every value."""
    run = tuple((last * stage / 5,) * POINTS for stage in range(6))
    returns = (run, tuple(tuple(value + 100 for value in row) for row in run))
    axis = MeasuredAxis(name="gravity", points=AXIS.points, returns=returns, deviations=returns)
    return Landscape(group=GROUP.id, episodes=10, policies={"0": "a", "1": "b"}, versions={}, axes=(axis,))


@pytest.fixture
def folders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, Path]:
    """The folders of two submissions with landscapes that belong to their runs."""
    runs = {run: SimpleNamespace(policies=SimpleNamespace(sha256=name)) for run, name in enumerate("ab")}
    monkeypatch.setattr(scored, "measured_runs", lambda submission, members: runs)
    found = {name: tmp_path / name for name in ("agile", "keeper")}
    for last, folder in zip((900.0, 1900.0), found.values(), strict=True):
        folder.mkdir()
        landscape(last).write(scored.path_of(folder, GROUP))
    return found


def test_the_page_of_a_submission_shows_its_landscape_and_publishes_it(
    document: dict[str, Any], folders: dict[str, Path]
) -> None:
    texts = dict(files(document, **folders))
    page = Reader(texts[PAGE])
    assert page.errors == []
    # over two runs agile ends at 900 and 1000 where the best mean is 1950
    for part in ("interpolation 0.49", "Run 1", "at 1.25 g"):
        assert part in page.text
    assert "Interpolation and extrapolation to gravities" in Reader(texts["groups.html"]).text
    published = Landscape.from_json(texts[f"submissions/agile/landscape-{GROUP.id}.json"])
    assert published == landscape(900.0)


def test_a_board_shows_both_numbers_as_never_trained_on(
    document: dict[str, Any], folders: dict[str, Path]
) -> None:
    page = Reader(dict(files(document, **folders))[BOARD])
    assert page.errors == []
    assert "Nothing was trained on these values, and no rank depends on them." in page.text
    assert sum(a.get("class") == "landscape small" for _, a in page.elements) == 2, "a map per submission"
    table = page.text[page.text.index("Share of the best return: mean over the runs") :]
    assert table.index("keeper") < table.index("agile")


def test_a_withdrawn_submission_is_compared_on_its_own_page_alone(
    document: dict[str, Any], folders: dict[str, Path]
) -> None:
    decision = Decision(action="withdrawn", by="M.", date="2026-01-02", reason="An error.")
    write_review(folders["keeper"], Review(decisions=[decision]))
    texts = dict(files(document, **folders))
    assert "interpolation 1.00" in Reader(texts[PAGE]).text
    assert "No other submission is measured" in Reader(texts[PAGE]).text
    keeper = Reader(texts["submissions/keeper.html"]).text
    assert "hopper-gravity -v0 1.00" in keeper
    assert "the only submission: its own best" not in keeper


def test_a_landscape_of_other_policies_is_not_drawn(document: dict[str, Any], tmp_path: Path) -> None:
    landscape(900.0).write(scored.path_of(tmp_path, GROUP))
    texts = dict(files(document, agile=tmp_path))
    assert "The policies of its runs have changed" in Reader(texts[PAGE]).text
    assert f"submissions/agile/landscape-{GROUP.id}.json" not in texts


@pytest.mark.parametrize("policies", [True, False])
def test_a_submission_without_a_landscape_says_why(
    document: dict[str, Any], tmp_path: Path, policies: bool
) -> None:
    scores = scores_of(document)
    scores["provenance"] = [{**MADE, "policies": policies}]
    text = Reader(dict(files(document, agile=tmp_path))[PAGE]).text
    assert ("Not measured yet." in text) == policies
    assert ("they are not published" in text) != policies


def test_a_map_has_cells_where_the_tint_changes_and_a_dot_per_trained_value() -> None:
    shares = [[stage / 5, *[0.1, stage / 5] * 7] for stage in range(6)]
    parts = {
        part.get("class"): part.get("d", "")
        for part in ElementTree.fromstring(small(AXIS, shares, "")).iter()
    }
    assert [parts[f"t{2 * stage}"].count("M") for stage in range(6)] == [8] * 6
    assert parts["t1"] == "M0 30H150", "the most frequent tint is the ground"
    assert parts["t10"].startswith("M0 55H5M")
    drawing = str(small(AXIS, shares, "Run 0"))
    dots = re.findall(r'class="seen" stroke-width="(\S+)" d="(\S[^"]*)"', drawing)
    lengths = [re.findall(r"v(\d+)", way) for _, way in dots]
    assert lengths == [["31", "21", "11", "1"], ["1"] * 5], "4, 3, 2 and 1 small dots, and a large one each"


def test_a_world_without_a_share_is_hatched_and_shares_are_cut_at_zero_and_one() -> None:
    drawing = str(small(AXIS, [[None, -0.5, 1.5, *[0.5] * (POINTS - 3)]], ""))
    assert [drawing.count(f'class="{kind}"') for kind in ("unknown", "t0", "t10", "t5")] == [1, 1, 1, 1]
