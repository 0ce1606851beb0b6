"""Pusher: resets and rewards."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from ..resets import assert_uniform, states_after_reset


def test_the_moving_goal_is_drawn_uniformly_and_the_object_away_from_it() -> None:
    rows = states_after_reset("PusherMovingGoal", lambda env: np.concatenate([env.data.qpos, env.data.qvel]))
    objects, goals = rows[:, 7:9], rows[:, 9:11]
    assert_uniform(goals[:, 0], -0.2, 0.0)
    assert_uniform(goals[:, 1], -0.1, 0.3)
    assert (objects >= [-0.3, -0.2]).all()
    assert (objects <= [0, 0.2]).all()
    apart = np.linalg.norm(objects - goals, axis=1)
    assert 0.17 < apart.min() < 0.18
    for joint in range(7):
        assert_uniform(rows[:, 11 + joint], -0.005, 0.005)
    assert not rows[:, 18:].any()
    assert not rows[:, :7].any()


def test_the_object_is_drawn_uniformly_where_the_goal_leaves_room() -> None:
    # Given the goal, what is kept of uniform draws is uniform: compare with rejection done here.
    rows = states_after_reset("PusherMovingGoal", lambda env: env.data.qpos[7:11].copy())
    generator = np.random.default_rng(4)
    expected: list[NDArray[np.float64]] = []
    while len(expected) < 4000:
        goal = generator.uniform([-0.2, -0.1], [0, 0.3])
        start = generator.uniform([-0.3, -0.2], [0, 0.2])
        while np.linalg.norm(start - goal) <= 0.17:
            start = generator.uniform([-0.3, -0.2], [0, 0.2])
        expected.append(start)
    for axis in (0, 1):
        assert stats.ks_2samp(rows[:, axis], np.array(expected)[:, axis]).pvalue > 1e-3
