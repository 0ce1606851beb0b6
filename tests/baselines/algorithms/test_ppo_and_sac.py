"""The reference agents that train models of Stable-Baselines3 and SBX."""

from __future__ import annotations

import pickle
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")

from gym_extensions.baselines import algorithms
from gym_extensions.baselines.adapters.sb3 import Sb3Factory
from gym_extensions.baselines.training.recorder import Recorder
from gym_extensions.catalog.budgets import BUDGETS
from gym_extensions.envs import make_vec

WARM_UP = 40


@pytest.fixture(scope="module")
def env() -> Any:
    return make_vec("Hopper", 2)


def small(name: str) -> Any:
    """The factory of the agent ``sac`` or ``sac-fresh-buffer``, with a shorter warm-up."""
    pytest.importorskip("sbx")
    options = algorithms.factory(name)._options  # type: ignore[attr-defined]
    settings = {**options.settings, "learning_starts": WARM_UP, "buffer_size": 1000}
    return Sb3Factory(replace(options, settings=settings))


def create(make: Any, env: Any, seed: int = 3) -> Any:
    return make(env.single_observation_space, env.single_action_space, seed)


def learn(agent: Any, env: Any, seed: int, steps: int = 80) -> None:
    agent.learn(Recorder(env, ["Hopper"], steps=steps, batch_steps=steps, seed=seed), steps)


@pytest.fixture(scope="module")
def sac(env: Any) -> Any:
    """sac after two stages."""
    agent = create(small("sac"), env)
    for stage in (1, 2):
        learn(agent, env, stage)
    return agent


def test_a_stage_of_ppo_has_one_rollout_per_batch_of_the_budget() -> None:
    options = algorithms.factory("ppo")._options  # type: ignore[attr-defined]
    for budget in BUDGETS.values():
        for num_envs in (1, 3, 8, budget.num_envs):
            rollout = options.batch_settings(num_envs, budget.batch_steps)["n_steps"] * num_envs
            assert budget.batch_steps <= rollout <= 1.02 * budget.batch_steps


def test_ppo_learns_and_its_policy_acts_as_it_does(env: Any) -> None:
    agent = create(algorithms.factory("ppo"), env)
    before = agent._model.policy.log_std.detach().numpy().copy()
    learn(agent, env, 1)
    assert (before == -1.0).all()
    assert not np.array_equal(agent._model.policy.log_std.detach().numpy(), before)
    observations = np.random.default_rng(0).normal(size=(5, 11))
    actions = np.clip(agent.policy().act(observations), -1, 1)
    np.testing.assert_allclose(actions, agent.act(observations), rtol=1e-5, atol=1e-5)


def test_sac_has_a_quarter_of_an_update_per_step_after_one_warm_up(sac: Any) -> None:
    # A group of 4 steps of both environments that ends above the warm-up is followed by 2 updates.
    assert sac._model._n_updates == (2 * 80 - WARM_UP) / 4


def test_sac_keeps_its_replay_buffer_and_sac_fresh_buffer_empties_it(sac: Any, env: Any) -> None:
    fresh = create(small("sac-fresh-buffer"), env)
    for stage in (1, 2):
        learn(fresh, env, stage)
    assert sac._model.replay_buffer.pos * env.num_envs == 160
    assert fresh._model.replay_buffer.pos * env.num_envs == 80
    assert (sac.observes.boundaries, fresh.observes.boundaries) == (False, True)


def test_sac_s_policy_acts_as_it_does(sac: Any) -> None:
    observations = np.random.default_rng(0).normal(size=(5, 11))
    np.testing.assert_allclose(sac.policy().act(observations), sac.act(observations), rtol=1e-4, atol=1e-5)


def test_sac_in_another_process_or_resumed_has_the_same_bytes(sac: Any, env: Any, tmp_path: Path) -> None:
    make = pickle.loads(pickle.dumps(small("sac")))  # noqa: S301  (as for a worker process)
    agent = create(make, env)
    learn(agent, env, 1)
    agent.save(tmp_path / "stage1.npz")
    resumed = create(make, env, seed=9)
    resumed.load(tmp_path / "stage1.npz")
    learn(resumed, env, 2)
    files = []
    for each in (sac, resumed):
        each.save(tmp_path / "agent.npz")
        files.append((tmp_path / "agent.npz").read_bytes())
    assert files[0] == files[1]
