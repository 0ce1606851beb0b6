"""Kinematics, pictures and players of the Watch panel."""

from __future__ import annotations

import gzip
import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from gym_extensions.catalog.protocol import EVALUATION_EPISODES
from gym_extensions.catalog.sheets import sheet
from gym_extensions.catalog.tasks import task
from gym_extensions.envs.effects.wall_and_sensor import FANS
from gym_extensions.envs.make import construct_mujoco
from gym_extensions.envs.mujoco.model import compile_model
from gym_extensions.scoring.poses import Clip, Poses, TaskPoses, motion_of, write
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.site.motion import (
    Episode,
    Watch,
    WatchedTask,
    placed,
    stroboscopes,
    watches,
)
from gym_extensions.site.text import fixed

from .browser import Reader, files, typed

SIDE = (90.0, 0.0)


@pytest.mark.parametrize(
    "name",
    ["HopperWall", "Walker2dBigFoot", "HalfCheetah", "HumanoidSmallHand", "PusherMovingGoal", "Striker"],
)
def test_the_center_of_every_shape_is_that_of_its_geom(name: str) -> None:
    row = task(name)
    model, facts = compile_model(row), sheet(row.id)
    data = mujoco.MjData(model)
    assert facts is not None and facts.skeleton is not None
    random = np.random.default_rng(0)
    coordinates = random.normal(0, 1, (2, model.nq + 2))
    shapes = [
        shape for shape in placed(facts.skeleton._replace(view=SIDE), coordinates) if shape.role != "beam"
    ]
    geoms = [
        geom
        for geom in range(model.ngeom)
        if model.geom_bodyid[geom] > 0 and not model.geom(geom).name.startswith("plate")
    ]
    assert len(shapes) == len(geoms)
    for frame in range(2):
        data.qpos[:] = coordinates[frame, : model.nq]
        if model.nmocap:
            data.mocap_pos[0, :2] = coordinates[frame, model.nq :]
        mujoco.mj_kinematics(model, data)
        centers = [(shape.start[frame] + shape.end[frame]) / 2 for shape in shapes]
        np.testing.assert_allclose(centers, data.geom_xpos[geoms][:, [0, 2]], atol=1e-4)


@pytest.mark.parametrize("name", ["HopperWithSensor", "HumanoidWall", "HumanoidStandupWithSensor"])
def test_beams_are_those_of_the_sensor(name: str) -> None:
    env: Any = construct_mujoco(name)
    env.reset(seed=0)
    facts = sheet(task(name).id)
    assert facts is not None and facts.skeleton is not None
    coordinates = np.append(env.data.qpos, [2.0, 0.0])[None]
    shapes = placed(facts.skeleton._replace(view=SIDE), coordinates)
    beams = [shape for shape in shapes if shape.role.endswith("beam")]
    origin, directions = FANS[task(name).body.beams](env.data.qpos, env._root_lift())
    np.testing.assert_allclose([beam.start[0] for beam in beams], [origin[[0, 2]]] * 10, atol=2e-3)
    ends = origin + 10 * directions
    np.testing.assert_allclose([beam.end[0] for beam in beams], ends[:, [0, 2]], atol=2e-3)


ROOT = Path(__file__).parents[2]
PLAYER = ROOT / "site/gym_extensions/site/static/watch.js"
GROUP = "hopper-gravity-v0"


def poses_of(document: dict[str, Any], speed: float = 0.02) -> Poses:
    """Poses of the first entry: a Hopper that slides forward at a constant height."""
    scores = document["submissions"][0]["groups"][GROUP]["sequential"]
    matrix, tasks = scores["return_matrix"][0], scores["tasks"]
    track = np.zeros((61, 6))
    track[:, 0], track[:, 1] = speed * np.arange(61), 1.25

    def clip(stage: int, index: int) -> Clip:
        return Clip(
            stage=stage,
            episode=2,
            steps=500,
            success=None,
            returns=(matrix[stage][index],) * EVALUATION_EPISODES,
            frames=61,
            motion=motion_of(track, 0.01),
        )

    rows = [
        TaskPoses(
            task=task,
            after=clip(index + 1, index),
            end=clip(len(tasks), index) if index + 1 < len(tasks) else None,
            unit=0.01,
            steps_per_second=125.0,
            steps_per_frame=125 / 15,
        )
        for index, task in enumerate(tasks)
    ]
    return Poses(submission="agile", group=GROUP, run=0, tasks=tuple(rows))


def panel_of(document: dict[str, Any], poses: Poses) -> Watch:
    card = typed(document).submissions[0]
    return watches(card, {GROUP: poses})[GROUP]


def compressed(text: str) -> int:
    return len(gzip.compress(text.encode(), 9, mtime=0))


@pytest.fixture
def card(document: dict[str, Any]) -> Scorecard:
    return typed(document).submissions[0]


def test_an_episode_is_described_in_words(document: dict[str, Any]) -> None:
    episode = panel_of(document, poses_of(document)).tasks[0].episodes[0]
    returned = fixed(document["submissions"][0]["groups"][GROUP]["sequential"]["return_matrix"][0][1][0], 1)
    assert episode.facts == f"return {returned}, 500 steps (4.0 s), 1.2 m forward"


def test_poses_of_an_earlier_log_are_not_shown(document: dict[str, Any], card: Scorecard) -> None:
    poses = poses_of(document)
    document["submissions"][0]["groups"][GROUP]["sequential"]["return_matrix"][0][5][0] += 1.0
    assert watches(typed(document).submissions[0], {GROUP: poses}) == {}
    assert watches(card, {}) == {}


def test_the_panel_and_its_script_are_on_the_page_of_the_entry(
    document: dict[str, Any], tmp_path: Path
) -> None:
    write(tmp_path, "hopper-gravity", poses_of(document))
    texts = dict(files(document, agile=tmp_path))
    page = Reader(texts["submissions/agile.html"])
    assert page.errors == []
    assert "Watch run 0" in page.text
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


def test_a_picture_has_twelve_poses_the_last_one_opaque(document: dict[str, Any]) -> None:
    [drawing, _] = stroboscopes(panel_of(document, poses_of(document)).tasks[0])
    opacities = re.findall(r'<path( opacity="\.\d")? d="', drawing)
    assert len(opacities) == 12
    assert opacities[-1] == ""


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
    facts = sheet(name)
    assert facts is not None
    poses = poses_of(document)
    row = poses.tasks[4]
    clip = row.after
    track = np.array([[100.0, 80.0], [103.0, 84.0]])
    walk = replace(clip, frames=2, motion=motion_of(track, 0.1))
    mapped = replace(row, task=name, after=walk, unit=0.1, steps_per_second=0.0, steps_per_frame=4.0)
    episode = Episode(walk, "At the end", mapped, facts, False)
    [drawing] = stroboscopes(WatchedTask(name, (episode,)), "../")
    assert 'd="M100 400l3-4"' in drawing
    assert 'href="../pictures/map0-goal0.svg"' in drawing
    assert episode.facts.endswith("500 steps")
