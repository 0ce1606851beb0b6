"""The Watch panel: which episodes it has, what it says of them, their drawings, and the player's script."""

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gym_extensions.catalog.descriptions import descriptions
from gym_extensions.catalog.protocol import EVALUATION_EPISODES
from gym_extensions.site.pages import PAGES, submissions
from gym_extensions.site.play.watch import Episode, Watch, stroboscopes, watches
from gym_extensions.site.text import fixed
from gym_extensions.submissions.poses import Clip, Poses, TaskPoses, motion_of

from ..browser import Reader, site_files, typed
from ..conftest import scores_of
from .test_assets import SIMULATOR

GROUP = "hopper-gravity-v0"


def poses_of(document: dict[str, Any], speed: float = 0.02) -> Poses:
    """Poses of the first submission: a Hopper that slides forward at a constant height."""
    scores = scores_of(document)
    matrix, tasks = scores["return_matrix"][0], scores["tasks"]
    track = np.zeros((61, 6))
    track[:, 0], track[:, 1] = speed * np.arange(61), 1.25

    facts: dict[str, Any] = {"episode": 2, "steps": 500, "success": None, "frames": 61}
    timing = {"unit": 0.01, "steps_per_second": 125.0, "steps_per_frame": 125 / 15}

    def clip(stage: int, index: int) -> Clip:
        returns = (matrix[stage][index],) * EVALUATION_EPISODES
        return Clip(stage=stage, returns=returns, motion=motion_of(track, 0.01), **facts)

    rows = []
    for index, task in enumerate(tasks):
        end = clip(len(tasks), index) if index + 1 < len(tasks) else None
        rows.append(TaskPoses(task=task, after=clip(index + 1, index), end=end, **timing))
    return Poses(submission="agile", group=GROUP, run=0, tasks=tuple(rows))


def panel_of(document: dict[str, Any], poses: Poses) -> Watch:
    card = typed(document).submissions[0]
    return watches(card, {GROUP: poses})[GROUP]


def test_an_episode_is_described_in_words(document: dict[str, Any]) -> None:
    episode = panel_of(document, poses_of(document)).tasks[0][0]
    returned = fixed(scores_of(document)["return_matrix"][0][1][0], 1)
    assert episode.facts == f"return {returned}, 500 steps (4.0 s), 1.2 m forward"


def test_poses_of_an_earlier_log_are_not_shown(document: dict[str, Any]) -> None:
    poses = poses_of(document)
    assert watches(typed(document).submissions[0], {}) == {}
    scores_of(document)["return_matrix"][0][5][0] += 1.0
    assert watches(typed(document).submissions[0], {GROUP: poses}) == {}


def test_the_panel_and_its_script_are_on_the_page_of_the_submission(
    document: dict[str, Any], tmp_path: Path
) -> None:
    poses_of(document).write(tmp_path / "poses" / "hopper-gravity.json")
    kinds = tuple(each for each in PAGES if each.path == "submissions.html")
    texts = dict(site_files(document, kinds, {"agile": tmp_path}, simulator=SIMULATOR))
    page = Reader(texts["submissions/agile.html"])
    assert page.errors == []
    assert "Watch run 0" in page.text
    link = f"../play.html#?group={GROUP}&task=HopperGravityHalf&submission=agile&run=0&stage=1"
    assert link in [attributes.get("href") for _, attributes in page.elements]
    without = dict(site_files(document, kinds, {"agile": tmp_path}))["submissions/agile.html"]
    assert "play.html#" not in without, "a site without the simulator"
    assert page.text.count("Right after its training") == 4
    sections = [attributes for tag, attributes in page.elements if attributes.get("class") == "watch"]
    assert [section["data-task"] for section in sections] == ["0", "1", "2", "3", "4"]
    assert sections[0]["data-script"] == f"../submissions/agile/poses-{GROUP}.js"
    script = texts[f"submissions/agile/poses-{GROUP}.js"]
    arguments = re.fullmatch(r"watchPoses\((.*)\);\n", script)
    assert arguments
    name, data = json.loads(f"[{arguments[1]}]")
    assert name == sections[0]["data-poses"]
    assert [len(row["clips"]) for row in data["tasks"]] == [2, 2, 2, 2, 1]
    assert "static/watch.js" not in texts["submissions/keeper.html"]


def test_the_panel_of_a_group_of_many_tasks_is_folded(
    document: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kinds = tuple(each for each in PAGES if each.path == "submissions.html")
    panel = panel_of(document, poses_of(document))

    def is_folded(panel: Watch) -> bool:
        monkeypatch.setattr(submissions, "watches", lambda *_: {GROUP: panel})
        page = dict(site_files(document, kinds))["submissions/agile.html"]
        before = page.partition('class="watch"')[0]
        return before.count("<details") > before.count("</details>")

    assert not is_folded(panel)
    assert is_folded(replace(panel, tasks=panel.tasks * 3))


@pytest.mark.parametrize(
    ("speed", "ticks"), [(0.1, 7), (0.02, 0)], ids=["6 m along the track", "1.2 m moved apart"]
)
def test_the_floor_has_a_tick_per_metre_where_distances_are_true(
    document: dict[str, Any], speed: float, ticks: int
) -> None:
    [drawing, _] = stroboscopes(panel_of(document, poses_of(document, speed)).tasks[0])
    [floor] = re.findall(r'class="floor" d="([^"]*)"', drawing)
    assert floor.count("v5") == ticks


def test_a_path_is_drawn_over_its_map_with_the_goal(document: dict[str, Any]) -> None:
    name = "gym_extensions/State-Based-Navigation-2d-Map0-Goal0-v0"
    facts = descriptions().get(name)
    assert facts is not None and facts.goal
    poses = poses_of(document)
    row = poses.tasks[4]
    clip = row.after
    track = np.array([[100.0, 80.0], [103.0, 84.0], [103.0, 84.0]])
    walk = replace(clip, frames=3, motion=motion_of(track, 0.1))
    mapped = replace(row, task=name, after=walk, unit=0.1, steps_per_second=0.0, steps_per_frame=4.0)
    episode = Episode(walk, "At the end", mapped, facts)
    [drawing] = stroboscopes((episode,))
    assert 'd="M100 400l3-4"' in drawing
    assert f'<circle class="goal" cx="{facts.goal[0]:g}"' in drawing
    assert re.findall(r'class="wall" d="([^"]*)"', drawing)[0].count("M") == len(facts.obstacles)
    assert "href" not in drawing, "a drawing that is saved needs no other file"
    assert episode.facts.endswith("500 steps")
