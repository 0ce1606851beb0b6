"""Errors of make_vec and its vector environments."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from gym_extensions.envs import make
from gym_extensions.envs import make_vec as typed_make_vec
from gym_extensions.errors import BenchError


def make_vec(*args: Any, **kwargs: Any) -> Any:
    """``make_vec`` without its type: Gymnasium's VectorEnv declares neither ``call`` nor lists of seeds."""
    return typed_make_vec(*args, **kwargs)


def restore_edited(edit: Callable[[dict[str, Any]], object]) -> None:
    """Restores a saved state after an edit."""
    env: Any = make_vec("Hopper", 2)
    env.reset(seed=0)
    states = env.save_states()
    edit(states)
    env.restore_states(states)


def reset(name: str = "Hopper", num_envs: int = 2) -> Any:
    """A vector environment after its reset."""
    env = make_vec(name, num_envs)
    env.reset(seed=0)
    return env


COUNT = "Give a whole number from 1 to 100000."
MISTAKES: list[tuple[Callable[[], object], str]] = [
    (
        lambda: make_vec("Hoper", 2),
        "There is no task 'Hoper'. Did you mean 'Hopper'?",
    ),
    (lambda: make_vec([], 2), "make_vec: There is no task. Give at least 1."),
    (lambda: make_vec("Hopper", 0), f"make_vec: num_envs is 0. {COUNT}"),
    (lambda: make_vec("Hopper", "3"), f"make_vec: num_envs is '3'. {COUNT}"),
    (lambda: make_vec("Hopper", 2.0), f"make_vec: num_envs is 2.0. {COUNT}"),
    (lambda: make_vec("Hopper", True), f"make_vec: num_envs is True. {COUNT}"),
    (lambda: make_vec("Hopper", 10**12), f"make_vec: num_envs is 1000000000000. {COUNT}"),
    (
        lambda: make_vec("Hopper", 1, num_threads=-1),
        "make_vec: num_threads is -1. Give a whole number from 1 to 1024.",
    ),
    (
        lambda: make_vec(["Hopper", "Walker2d"], 2),
        "make_vec: gym_extensions/Hopper-v0 has the observation_space Box(-inf, inf, (11,), float64), "
        "gym_extensions/Walker2d-v0 has Box(-inf, inf, (17,), float64). Give tasks with equal spaces.",
    ),
    (
        lambda: make_vec(["Pusher", "State-Based-Navigation-2d-Map0-Goal0"], 2),
        "make_vec: gym_extensions/Pusher-v0 has the observation_space Box(-inf, inf, (23,), float64), "
        "gym_extensions/State-Based-Navigation-2d-Map0-Goal0-v0 has "
        f"{make('State-Based-Navigation-2d-Map0-Goal0').observation_space}. "
        "Give tasks with equal spaces.",
    ),
    (
        lambda: make_vec("Hopper", 2).reset(seed=[1, 2, 3]),
        "make_vec: There are 3 seeds for 2 environments. Give one seed per environment, or one int.",
    ),
    (
        lambda: make_vec("Hopper", 2).reset(options={"reset_mask": np.array([False, False])}),
        "make_vec: reset_mask is array([False, False]). Give 2 booleans, at least one of them true.",
    ),
    (
        lambda: make_vec("Hopper", 2).call("fly"),
        "make_vec: The environments have no 'fly'. Call one of save_state, task, np_random, "
        "np_random_seed, without arguments.",
    ),
    (lambda: restore_edited(lambda states: states.pop("qvel")), "make_vec: The states have no entry 'qvel'."),
    (
        lambda: restore_edited(lambda states: states.update(wind=np.zeros(2))),
        "make_vec: The states have an unknown entry 'wind'.",
    ),
    (
        lambda: restore_edited(lambda states: states.update(qpos=np.zeros((2, 7)))),
        "make_vec: The states' 'qpos' has shape (2, 7); expected (num_envs, 6).",
    ),
    (
        lambda: restore_edited(lambda states: states.update(qpos=np.full((2, 6), np.inf))),
        "make_vec: The states' 'qpos' has a value that is not finite.",
    ),
    (
        lambda: make_vec("Hopper", 2).reset(seed=1.5),
        "make_vec: seed is 1.5. Give an int or one seed per environment.",
    ),
    (
        lambda: make_vec("Hopper", 2).reset(seed=[0, -1]),
        "make_vec: A seed is -1. Give whole numbers of at least 0.",
    ),
    *(
        (
            lambda indices=indices: reset().restore_states(reset().save_states(), indices),
            f"make_vec: indices is {indices!r}. Give different whole numbers from 0 to 1.",
        )
        for indices in ([0, 2], [-1, 0], [1, 1], [0.0, 1.0], [True, False], [])
    ),
    (
        lambda: reset(num_envs=4).restore_states(reset(num_envs=4).save_states(), [2]),
        "make_vec: The states' 'qpos' has 4 rows; expected 1. Give one row per restored environment.",
    ),
    (
        lambda: reset().step(np.zeros((2, 4), np.float32)),
        "make_vec: The action has shape (2, 4); expected (2, 3). Give one number per actuator.",
    ),
    (
        lambda: reset().step(np.array([[0, 0, 0], [0, np.nan, 0]], np.float32)),
        "make_vec: action[1, 1] is nan. Give finite numbers.",
    ),
]


@pytest.mark.parametrize(("mistake", "message"), MISTAKES, ids=[message for _, message in MISTAKES])
def test_the_error_says_what_is_wrong_and_what_to_do(mistake: Callable[[], object], message: str) -> None:
    with pytest.raises(BenchError) as caught:
        mistake()
    assert str(caught.value) == message
