"""Navigation: many agents in one compiled world, compared with single environments in a loop."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from gymnasium.vector import SyncVectorEnv

from gym_extensions.envs import make, make_vec

pytestmark = pytest.mark.bench

AGENTS = 64
PEER = f"SyncVectorEnv({AGENTS})"
TASKS = {
    "Limited-Range-Based-Navigation-2d-Map0-Goal0": (2000, 20, 8.0),
    "State-Based-Navigation-2d-Map0-Goal0": (2000, 20, 12.0),
    "Image-Based-Navigation-2d-Map0-Goal0": (40, 10, 5.0),
}
"""Vector steps per turn, ours and Gymnasium's, and the bar of the ratio of our speed to Gymnasium's."""


@pytest.mark.parametrize("name", TASKS)
def test_navigation_is_faster_than_gymnasiums_sync_vector_env(
    side_by_side: Any, timed: Any, name: str
) -> None:
    steps_per_turn, peer_steps, bar = TASKS[name]
    vector = make_vec(name, AGENTS)
    peer: Any = SyncVectorEnv([lambda: make(name)] * AGENTS)
    actions = (
        np.random.default_rng(0)
        .uniform(-5, 5, (max(steps_per_turn, peer_steps), AGENTS, 2))
        .astype(np.float32)
    )

    def steps(env: Any, count: int) -> None:
        for row in actions[:count]:
            env.step(row)

    for env in (vector, peer):
        env.reset(seed=0)
    contestants = {
        "make_vec": timed(steps_per_turn * AGENTS, lambda: steps(vector, steps_per_turn)),
        PEER: timed(peer_steps * AGENTS, lambda: steps(peer, peer_steps)),
    }
    about = {"task": name.partition("-Nav")[0], "lanes": AGENTS, "threads": 1}
    ratios = side_by_side("navigation", contestants, bars={PEER: bar}, **about)
    assert ratios[PEER] > 1.0
