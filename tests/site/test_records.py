"""The page of a task shows and plays its expert and its records."""

from __future__ import annotations

from pathlib import Path

import pytest

from gym_extensions.catalog.tasks import task
from gym_extensions.experts import Measurement, RecordCard, Step
from gym_extensions.experts.cards import DATA
from gym_extensions.scoring.poses import PolicyPoses
from gym_extensions.scoring.records import Record, RecordReview
from gym_extensions.site.api import task_path
from gym_extensions.site.build import files as site_files
from gym_extensions.site.pages import TASK_PAGES
from gym_extensions.site.records import TaskPolicies, origin

from .browser import Reader, typed
from .conftest import everything

HOPPER = task("Hopper").id
NAME = '<b title="'


def made_record(name: str, mean: float) -> Record:
    """A verified record on Hopper that moves as the expert does."""
    poses = PolicyPoses.load(DATA / "poses" / "Hopper.json", "", "")
    assert poses is not None
    record = Record(Path("records/Hopper") / f"{name}.json")
    claim = Measurement(100, 4000.0, 10.0)
    # The cached properties are what the files would give.
    record.__dict__["card"] = RecordCard(HOPPER, "", "", (Step("a", "sac", 2_000_000),), claim, (NAME, "B"))
    record.__dict__["review"] = RecordReview(
        card="0" * 64,
        date="2026-12-01",
        version="1",
        value="3f" * 20,
        episodes=100,
        mean=mean,
        deviation=25.0,
        least=3900.0,
        problem="",
        poses=poses.poses,
    )
    return record


@pytest.fixture(scope="module")
def pages() -> dict[str, str]:
    """The pages of tasks, with two records on Hopper."""
    records = {HOPPER: (made_record("best", 4001.5), made_record("second", 3990.0))}
    return dict(site_files(typed(everything()), (TASK_PAGES,), records=records))


def test_a_page_shows_the_records_with_authors_and_returns(pages: dict[str, str]) -> None:
    reader = Reader(pages[task_path(HOPPER)])
    assert reader.errors == []
    assert "best" in reader.text
    assert f"{NAME}, B" in reader.text, "the name of an author is text"
    assert "4001.5 ± 2.5" in reader.text
    assert reader.text.index("4001.5") < reader.text.index("3990.0")


def test_the_expert_and_the_best_record_play_side_by_side(pages: dict[str, str]) -> None:
    text, script = pages[task_path(HOPPER)], pages[task_path(HOPPER).replace(".html", "-poses.js")]
    assert text.count('<div class="stage">') == 2
    assert script.startswith('watchPoses("watch-policies",')
    assert script.count("ACMM") == 2, "two clips"


def test_a_page_without_records_says_so_and_maps_have_none(pages: dict[str, str]) -> None:
    assert "Nobody holds a record yet." in Reader(pages[task_path(task("Walker2d").id)]).text
    assert (
        "Nobody holds a record"
        not in pages[task_path("gym_extensions/Image-Based-Navigation-2d-Map1-Goal2-v0")]
    )


def test_poses_of_another_policy_are_not_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    assert TaskPolicies(task("Hopper")).watch is not None
    monkeypatch.setattr("gym_extensions.experts.DATA", Path("nowhere"))
    assert TaskPolicies(task("Hopper")).watch is None


def test_an_origin_names_agents_and_steps() -> None:
    assert origin((Step("a", "trpo", 300_000), Step("b", "trpo", 1_000_000))) == "trpo, 1.3 million steps"
    assert origin((Step("a", "sac"),)) == "sac"
