"""Navigation: many agents in one compiled world, against one environment after the other."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from gymnasium.vector import SyncVectorEnv

from gym_extensions.envs import make, make_vec

pytestmark = pytest.mark.bench

AGENTS = 64
TASKS = {
    "Limited-Range-Based-Navigation-2d-Map0-Goal0": (2000, 20),
    "State-Based-Navigation-2d-Map0-Goal0": (2000, 20),
    "Image-Based-Navigation-2d-Map0-Goal0": (40, 10),
}
"""Vector steps a turn, of the batch and of its peer."""


@pytest.mark.parametrize("name", TASKS)
def test_agent_steps_a_second_on_one_core(side_by_side: Any, timed: Any, name: str) -> None:
    """The bars of range (10⁶) and image (2·10⁴) agent-steps a second are absolute; here is what came out."""
    own, short = TASKS[name]
    batch = make_vec(name, AGENTS)
    peer: Any = SyncVectorEnv([lambda: make(name)] * AGENTS)
    actions = np.random.default_rng(0).uniform(-5, 5, (max(own, short), AGENTS, 2)).astype(np.float32)

    def steps(env: Any, count: int) -> None:
        for row in actions[:count]:
            env.step(row)

    for env in (batch, peer):
        env.reset(seed=0)
    contestants = {
        "make_vec": timed(own * AGENTS, lambda: steps(batch, own)),
        f"SyncVectorEnv({AGENTS})": timed(short * AGENTS, lambda: steps(peer, short)),
    }
    side_by_side("navigation", contestants, task=name.partition("-Nav")[0], lanes=AGENTS, threads=1)
