"""Bodies without variations are Gymnasium's v5 environments, bit for bit."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from gym_extensions.envs import make


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize(
    "body", ["Hopper", "Walker2d", "HalfCheetah", "Humanoid", "HumanoidStandup", "Pusher"]
)
def test_a_body_without_variations_equals_gymnasiums_bit_for_bit(
    body: str, dtype: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)  # Gymnasium's HalfCheetah has MuJoCo write a log of its deprecation here.
    ours: Any = make(body)
    theirs: Any = gym.make(f"{body}-v5")
    assert ours.action_space == theirs.action_space
    assert ours.observation_space == theirs.observation_space
    assert ours.unwrapped.metadata == theirs.unwrapped.metadata
    generator, ended = np.random.default_rng(5), True
    seed: int | None = 11
    for step in range(400):
        if ended:
            (seen, infos), (expected, other_infos) = ours.reset(seed=seed), theirs.reset(seed=seed)
            ended, seed = False, None
        else:
            action = generator.uniform(1.2 * ours.action_space.low, ours.action_space.high).astype(dtype)
            seen, reward, terminated, truncated, infos = ours.step(action)
            expected, *others, other_infos = theirs.step(action)
            assert [reward, terminated, truncated] == others
            ended = terminated or truncated
        np.testing.assert_array_equal(seen, expected, err_msg=f"step {step}")
        infos.pop("is_success", None)
        assert infos.keys() == other_infos.keys()
        for name, value in infos.items():
            np.testing.assert_array_equal(value, other_infos[name], err_msg=f"{name}, step {step}")
