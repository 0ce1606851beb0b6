"""Saved states of navigation: they continue bit for bit, and invalid ones raise errors."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from gym_extensions.catalog.groups import group
from gym_extensions.catalog.navigation_tasks import FAMILIES
from gym_extensions.catalog.registry import task
from gym_extensions.envs import make_vec
from gym_extensions.envs.navigation.build import construct as construct_navigation
from gym_extensions.errors import BenchError

OF_A_FAMILY = {family: group(f"nav-{family}").task_ids for family in FAMILIES}


def random_actions(steps: int, num_envs: int, seed: int = 3) -> NDArray[np.float32]:
    return np.random.default_rng(seed).uniform(-5, 5, (steps, num_envs, 2)).astype(np.float32)


@pytest.mark.parametrize("family", FAMILIES)
def test_a_saved_state_continues_bit_for_bit_elsewhere(family: str) -> None:
    name = OF_A_FAMILY[family][3]
    env, elsewhere = construct_navigation(task(name)), construct_navigation(task(name))
    vector: Any = make_vec(name, 3)
    actions = random_actions(60, 1)[:, 0]
    env.reset(seed=1)
    for action in actions[:30]:
        env.step(action)
    saved = env.save_state()
    assert {key: value.shape for key, value in saved.items()} == {"position": (2,), "steps": ()}
    assert all(value.dtype == np.float64 for value in saved.values())
    assert saved["steps"] == 30
    elsewhere.reset(seed=2)
    elsewhere.restore_state(saved)
    vector.reset(seed=3)
    vector.restore_states({name: value[None] for name, value in saved.items()}, indices=[1])
    for action in actions[30:]:
        expected, got, rows = env.step(action), elsewhere.step(action), vector.step(np.tile(action, (3, 1)))
        np.testing.assert_array_equal(got[0], expected[0])
        np.testing.assert_array_equal(rows[0][1], expected[0])
        assert got[1:] == expected[1:]
        assert (rows[1][1], rows[2][1]) == expected[1:3]
    for name, value in env.save_state().items():
        assert elsewhere.save_state()[name].tolist() == value.tolist()
        assert vector.save_states()[name][1].tolist() == value.tolist()


def test_an_invalid_state_raises_an_error() -> None:
    name = OF_A_FAMILY["state"][3]
    env = construct_navigation(task(name))
    env.reset(seed=1)
    good = env.save_state()
    for bad, message in (
        ({"position": good["position"]}, "The state has no entry 'steps'."),
        (good | {"velocity": np.zeros(2)}, "The state has an unknown entry 'velocity'."),
        (good | {"position": np.zeros(3)}, "The state's 'position' has shape (3,); expected (2,)."),
        (good | {"position": np.full(2, np.nan)}, "The state's 'position' has a value that is not finite."),
        (good | {"position": np.full(2, 5.0)}, "The start (5, 5) is in an obstacle or outside the map."),
    ):
        with pytest.raises(BenchError) as caught:
            env.restore_state(bad)
        assert str(caught.value).startswith(f"{name}: {message}")
    assert env.save_state()["position"].tolist() == good["position"].tolist()
