"""The reference agents that train models of Stable-Baselines3 and SBX."""

import pickle
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")

from gym_extensions.baselines import Resumable, algorithms
from gym_extensions.baselines.agent import Described
from gym_extensions.baselines.agent_spec import checked_card
from gym_extensions.baselines.training.environment import TrainingEnv
from gym_extensions.catalog.protocol import BUDGETS
from gym_extensions.envs import make_vec

STEPS = 80


@pytest.fixture(scope="module")
def env() -> Any:
    return make_vec("Hopper", 2)


def small(name: str, warm_up: int) -> Any:
    """The factory of the agent ``sac`` or ``sac-fresh-buffer``, with another warm-up.

    The first update takes seconds, because JAX compiles it.
    """
    pytest.importorskip("sbx")
    make: Any = algorithms.factory(name)
    settings = {**make.settings, "learning_starts": warm_up, "buffer_size": 1000}
    return replace(make, settings=settings)


def create(make: Any, env: Any, seed: int = 3) -> Any:
    return make(env.single_observation_space, env.single_action_space, seed)


def learn(agent: Any, env: Any, seed: int) -> None:
    agent.learn(TrainingEnv(env, ["Hopper"], steps=STEPS, batch_steps=STEPS, seed=seed), STEPS)


def test_a_stage_of_ppo_has_one_rollout_per_batch_of_the_budget() -> None:
    options: Any = algorithms.factory("ppo")
    for budget in filter(lambda budget: budget.on_boards, BUDGETS.values()):
        for num_envs in (1, 3, 9, budget.num_envs):
            rollout = options.batch_settings(num_envs, budget.batch_steps)["n_steps"] * num_envs
            assert budget.batch_steps <= rollout <= 1.02 * budget.batch_steps


def test_keyword_arguments_of_the_factory_change_settings_of_the_model(env: Any) -> None:
    make: Any = algorithms.factory("ppo")
    spaces = (env.single_observation_space, env.single_action_space)
    plain = make(*spaces, 3).card().hyperparameters
    agent = make(*spaces, 3, batch_size=40, learning_rate=0.01, normalize_rewards=True)
    learn(agent, env, 1)
    changes = {"batch_size": 40, "learning_rate": 0.01, "normalize_rewards": True}
    assert agent.card().hyperparameters == {**plain, **changes}
    assert (agent._model.batch_size, agent._model.learning_rate) == (40, 0.01)
    assert agent._normalizer.norm_reward
    assert make(*spaces, 3).card().hyperparameters == plain


def test_ppo_starts_with_the_standard_deviation_of_its_settings_and_learns(env: Any) -> None:
    agent = create(algorithms.factory("ppo"), env)
    before = agent._model.policy.log_std.detach().numpy().copy()
    learn(agent, env, 1)
    assert (before == -1.0).all()
    assert not np.array_equal(agent._model.policy.log_std.detach().numpy(), before)


@pytest.mark.parametrize(("name", "stored"), [("sac", 2 * STEPS), ("sac-fresh-buffer", STEPS)])
def test_sac_keeps_its_buffer_and_sac_fresh_buffer_empties_it(name: str, stored: int, env: Any) -> None:
    agent = create(small(name, warm_up=1000), env)
    for stage in (1, 2):
        learn(agent, env, stage)
    assert agent.card().stored_steps == stored
    assert agent._model.num_timesteps == stored, "the warm-up starts again with an empty buffer only"
    assert agent.observes.boundaries == (name == "sac-fresh-buffer")


@pytest.mark.parametrize("name", ["ppo", "sac", "sac-fresh-buffer"])
def test_each_describes_itself_and_repeats_itself_with_the_same_seed(name: str, env: Any) -> None:
    make = algorithms.factory("ppo") if name == "ppo" else small(name, warm_up=1000)
    agent, twin, other = (create(make, env, seed) for seed in (3, 3, 4))
    assert checked_card(agent, "another name").algorithm == name
    assert all(isinstance(agent, kind) for kind in (Described, Resumable))
    observations = np.random.default_rng(0).normal(size=(5, 11))
    actions = agent.act(observations)
    assert np.array_equal(twin.act(observations), actions)
    assert not np.array_equal(other.act(observations), actions)
    published = np.clip(agent.policy().act(observations), -1, 1)
    np.testing.assert_allclose(published, actions, rtol=1e-4, atol=1e-5)


@pytest.mark.slow
def test_a_resumed_sac_learns_the_same_with_a_quarter_of_an_update_per_step(env: Any, tmp_path: Path) -> None:
    make, warm_up = small("sac", warm_up=40), 40
    make = pickle.loads(pickle.dumps(make))  # noqa: S301  (as for a worker process)
    agent, resumed = create(make, env), create(make, env, seed=9)
    learn(agent, env, 1)
    agent.save(tmp_path / "stage1.npz")
    resumed.load(tmp_path / "stage1.npz")
    for each in (agent, resumed):
        learn(each, env, 2)
    # 4 steps of both environments that end above the warm-up are followed by 2 updates.
    assert agent._model._n_updates == (2 * STEPS - warm_up) / 4
    first, second = (each.policy().arrays() for each in (agent, resumed))
    assert all(first[name].tobytes() == second[name].tobytes() for name in first)
