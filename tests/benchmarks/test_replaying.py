"""Replay: recorded segments as lanes of one batch, against the same episodes through Gymnasium's loop."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from gym_extensions.baselines.training.evaluation import evaluate
from gym_extensions.catalog.registry import task as published
from gym_extensions.envs import make_vec
from gym_extensions.rollouts.trace_reader import RecordedEpisode
from gym_extensions.scoring.replay.segments import replay

pytestmark = pytest.mark.bench

EPISODES = {"Hopper": 120, "Walker2d": 120, "HalfCheetah": 12, "Humanoid": 60, "Pusher": 60}
"""Episodes a turn: some thousand steps for each body."""
CALM = 0.3
"""Part of the action box that the recorded agent uses, so that falling bodies stand a while."""


class Calm:
    """Small uniformly random actions."""

    def __init__(self, space: gym.spaces.Box) -> None:
        self._generator = np.random.default_rng(0)
        self._high = CALM * space.high

    def act(self, observations: Any) -> Any:
        """One draw a lane."""
        shape = (len(observations), *self._high.shape)
        return self._generator.uniform(-self._high, self._high, shape).astype(np.float32)

    def learn(self, env: Any, steps: int) -> None:
        """Nothing."""


def episodes(body: str) -> list[RecordedEpisode]:
    """Episodes recorded as evaluation records them."""
    task, count = published(body), EPISODES[body]
    env: Any = make_vec(task, count)
    found = []
    for seed, one in enumerate(
        evaluate(Calm(env.single_action_space), env, range(count), task.body.segments.steps)
    ):
        assert one.trace is not None
        facts = ("", task, seed, one.length, one.terminated, one.success)
        found.append(
            RecordedEpisode(*facts, one.trace.actions, one.trace.segment_returns, dict(one.trace.states))
        )
    return found


@pytest.mark.parametrize("body", EPISODES)
def test_replay_against_gymnasiums_loop(side_by_side: Any, timed: Any, body: str) -> None:
    recorded = episodes(body)
    steps = sum(one.length for one in recorded)

    def loop() -> None:
        env = gym.make(f"{body}-v5")
        for one in recorded:
            env.reset(seed=one.seed)
            for action in one.actions:
                env.step(action)

    contestants = {
        "replay": timed(steps, lambda: replay(recorded[0].task, recorded)),
        "Gymnasium's loop": timed(steps, loop),
    }
    assert replay(recorded[0].task, recorded) == []
    side_by_side(
        "replay", contestants, bars={"Gymnasium's loop": 2.0}, rounds=5, task=body, episodes=len(recorded)
    )
