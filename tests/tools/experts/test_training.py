"""Training runs: starting from a policy, shaped rewards, and resuming."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gym_extensions.catalog.tasks import customize, task
from gym_extensions.catalog.variations import Wall
from gym_extensions.envs import make_vec
from gym_extensions.errors import BenchError
from gym_extensions.submissions.policies.mlp import Policy
from tools.experts import training
from tools.experts.candidates import Workplace
from tools.experts.recipes import Recipe, recipe, training_task

SHORT = Recipe("short", ("Pusher",), steps=400, batch_steps=200, num_envs=4, checkpoint=200, value_batches=1)


@pytest.fixture
def work(tmp_path: Path) -> Workplace:
    return Workplace(tmp_path)


def run(work: Workplace, row: Recipe, parent: str | None = None) -> list[str]:
    return list(training.train(work, row, 0, parent, "train"))


def test_a_run_keeps_and_screens_its_checkpoints(work: Workplace) -> None:
    assert len(run(work, SHORT)) == 2
    steps = [row["steps"] for row in work.run("short-seed0")["checkpoints"]]
    assert list(work.candidates(task("Pusher"))) == [f"short-seed0@{step}" for step in steps]
    assert work.steps_tried(task("Pusher")) == steps[-1]


@pytest.mark.parametrize("squash", ["linear", "tanh"])
def test_training_further_starts_with_the_actions_of_the_policy(squash: str) -> None:
    env = make_vec("Hopper", 2)
    rng = np.random.default_rng(0)
    start = Policy(
        action_offset=np.zeros(3, np.float32),
        action_scale=np.ones(3, np.float32),
        weights=(rng.normal(size=(11, 8)).astype(np.float32), rng.normal(size=(8, 3)).astype(np.float32)),
        biases=(np.zeros(8, np.float32), np.zeros(3, np.float32)),
        activation="relu",
        squash=squash,
    )
    spaces: Any = (env.single_observation_space, env.single_action_space)
    agent = training.FurtherTrpo(spaces[0], spaces[1], 0, training.trpo_settings(start))
    agent.start_from(start)
    seen = rng.normal(size=(5, 11)).astype(np.float32)
    np.testing.assert_allclose(agent.policy().act(seen), start.act(seen), rtol=1e-5, atol=1e-6)


def test_in_the_first_batches_only_the_value_function_learns(work: Workplace) -> None:
    run(work, SHORT)
    start = f"short-seed0@{work.run('short-seed0')['checkpoints'][-1]['steps']}"
    run(work, replace(SHORT, name="further", steps=200), start)
    last = f"further-seed0@{work.run('further-seed0')['checkpoints'][-1]['steps']}"
    first, second = (work.policy(name, task("Pusher")).weights[0] for name in (last, start))
    np.testing.assert_array_equal(first, second)
    assert work.run("further-seed0")["parent"] == start


def test_a_bonus_adds_terms_of_the_reward() -> None:
    rewards = []
    for bonus in ({}, {"reward_survive": -0.5}):
        env = training.SeededEnv(make_vec("Humanoid", 2), [1, 2], bonus)
        env.reset()
        rewards.append(env.step(np.zeros((2, 17)))[1])
    np.testing.assert_allclose(rewards[0] - rewards[1], 2.5)


def test_a_bonus_is_not_added_while_every_environment_is_reset() -> None:
    env = training.SeededEnv(make_vec(customize("Humanoid", max_steps=1), 2), [1, 2], {"reward_survive": 1.0})
    env.reset()
    env.step(np.zeros((2, 17)))
    assert env.step(np.zeros((2, 17)))[1].tolist() == [0.0, 0.0]


def test_a_lower_wall_has_the_named_top() -> None:
    wall = next(each for each in training_task("HopperWall:0.1").variations if isinstance(each, Wall))
    assert wall.centre_height + wall.height / 2 == pytest.approx(0.1)
    assert training_task("HopperWall") is task("HopperWall")


def test_a_run_without_row_continues_from_the_best_candidate_of_its_task() -> None:
    assert recipe("trpo-HopperBigLeg").parent == "best:HopperBigLeg"
    with pytest.raises(BenchError):
        recipe("trpo-HopperBigNose")
