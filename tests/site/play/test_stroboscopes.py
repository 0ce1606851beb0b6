"""Drawings of the episodes of the Watch panel."""

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from gym_extensions.catalog.descriptions import descriptions
from gym_extensions.site.play.watch import Episode, stroboscopes
from gym_extensions.submissions.poses import motion_of

from .test_watch import panel_of, poses_of


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
