"""The task on the first page: where the reference agent loses and another method keeps most."""

from dataclasses import replace
from pathlib import Path

import pytest

from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.site.pages.overview import BEGINNING, forgetting
from gym_extensions.site.play.assets import play_group_link

from ..browser import typed
from ..conftest import everything
from ..play.test_watch import GROUP, poses_of
from .test_core import method


@pytest.fixture
def cards(tmp_path: Path) -> list[Scorecard]:
    """The reference agent, which forgets half, and one that keeps all, with drawings on one group."""
    made = [method("trpo", 0.8, 0.5), method("keeper", 0.8, 1.0)]
    for card in made:
        poses = poses_of({"submissions": [card]})
        shown = replace(poses, submission=card["name"])
        shown.write(tmp_path / card["name"] / "poses" / "hopper-gravity.json")
    return list(typed({**everything(), "submissions": made}).submissions)


def test_both_methods_are_shown_on_the_task_where_they_differ_most(
    cards: list[Scorecard], tmp_path: Path
) -> None:
    folders = {card.name: tmp_path / card.name for card in cards}
    loser, keeper = forgetting(cards, folders, "keeper")
    assert (loser.name, keeper.name, loser.result.group) == ("trpo", "keeper", GROUP)
    assert max(loser.changes) < -0.3 < min(keeper.changes)
    assert loser.means[-1] < loser.means[loser.task + 1]
    assert loser.line((loser, keeper)).count('class="thin"') == len(loser.scores) == 5
    assert len(keeper.pictures) == 2
    assert loser.frames == BEGINNING * 61
    link = play_group_link(GROUP, "keeper", 0, 1)
    assert link.endswith("task=HopperGravityThreeQuarters&submission=keeper&run=0&stage=2")


def test_nothing_is_shown_without_drawings_or_without_another_method(
    cards: list[Scorecard], tmp_path: Path
) -> None:
    folders = {card.name: tmp_path / card.name for card in cards}
    assert forgetting(cards, folders, "trpo") == forgetting(cards, {}, "keeper") == ()
    empty = dict.fromkeys(folders, tmp_path / "none")
    assert forgetting(cards, empty, "keeper") == ()
