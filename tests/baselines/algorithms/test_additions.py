"""Additions to the actors of Stable-Baselines3 models: what each holds, and that it is its base otherwise."""

import pickle
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import gymnasium as gym
import numpy as np
import pytest

torch = pytest.importorskip("torch")
pytest.importorskip("stable_baselines3")

from stable_baselines3 import DQN, PPO, SAC, TD3  # noqa: E402

from gym_extensions.baselines import algorithms, sb3  # noqa: E402
from gym_extensions.baselines.agent_spec import checked_card  # noqa: E402
from gym_extensions.baselines.algorithms import continual  # noqa: E402
from gym_extensions.baselines.algorithms.additions import ADDITIONS, Actor, flat, with_addition  # noqa: E402
from gym_extensions.baselines.trust_region.policy import Architecture  # noqa: E402
from gym_extensions.errors import BenchError  # noqa: E402

from ...conftest import refused  # noqa: E402
from .continual.goals import ACTIONS, OBSERVATIONS, Goals, in_task  # noqa: E402

STEPS = 400
SMALL: dict[str, Any] = {"policy_kwargs": {"net_arch": [8, 8]}, "learning_rate": 3e-3}
BASES = {
    "ppo": replace(
        sb3(PPO, n_steps=10, batch_size=50, n_epochs=4, normalize_observations=True, **SMALL),
        continue_counting=True,
    ),
    "sac": replace(
        sb3(SAC, buffer_size=1000, learning_starts=40, batch_size=32, train_freq=4, **SMALL),
        fresh_buffer=True,
    ),
}
PENALTIES, TASK_AWARE = ("cloning", "online-ewc"), ("snapshots", "packnet")
SEEN = np.random.default_rng(9).standard_normal((50, 3)).astype(np.float32)
each_base = pytest.mark.parametrize("base", BASES)


def create(base: str, addition: str = "", seed: int = 3, **settings: Any) -> Any:
    stored = {"states_per_task": 40} if addition in PENALTIES else {}
    make = with_addition(BASES[base], addition, **stored, **settings) if addition else BASES[base]
    return make(OBSERVATIONS, ACTIONS, seed)


def learned(agent: Any, *tasks: int) -> Any:
    for task in tasks:
        agent.learn(Goals(task), STEPS)
    return agent


def contents(agent: Any) -> list[bytes]:
    """The bytes of all networks of the model."""
    return [each.detach().numpy().tobytes() for each in agent._model.policy.state_dict().values()]


@each_base
@pytest.mark.parametrize("addition", PENALTIES)
def test_a_coefficient_of_zero_is_the_base_bit_by_bit(base: str, addition: str) -> None:
    plain, method = create(base), create(base, addition, coefficient=0.0)
    assert contents(learned(method, 0, 1)) == contents(learned(plain, 0, 1))


@each_base
@pytest.mark.parametrize("addition", ADDITIONS)
def test_the_first_task_is_learned_as_by_the_base_if_it_is_the_cards_parent(base: str, addition: str) -> None:
    method = learned(create(base, addition), 0)
    is_equal = contents(method) == contents(learned(create(base), 0))
    assert is_equal == (method.card().parent == BASES[base].card.algorithm)
    assert is_equal == (addition != "packnet")


@each_base
@pytest.mark.parametrize("addition", PENALTIES)
def test_a_strong_penalty_holds_the_policy_of_the_first_task(base: str, addition: str) -> None:
    moved = {}
    for coefficient in (0.0, 1e6):
        agent = learned(create(base, addition, coefficient=coefficient), 0)
        before = agent.act(SEEN)
        moved[coefficient] = np.abs(learned(agent, 1).act(SEEN) - before).mean()
    assert moved[1e6] < 0.4 * moved[0.0]


@each_base
def test_reset_starts_from_fresh_parameters_statistics_and_an_empty_buffer(base: str) -> None:
    agent = learned(create(base, "reset"), 0)
    first = Actor(create(base)).theta
    agent.learn(Goals(1), 200 if base == "ppo" else 20)  # one rollout; too few steps for an update of SAC
    fresh = Actor(agent).theta
    assert not np.array_equal(fresh, first)
    assert np.linalg.norm(fresh) == pytest.approx(np.linalg.norm(first), rel=0.2)
    if base == "ppo":
        assert agent._normalizer.obs_rms.count < STEPS
    else:
        assert agent._model.replay_buffer.size() < STEPS / 20


@each_base
@pytest.mark.parametrize("addition", TASK_AWARE)
def test_the_policy_of_a_finished_task_never_changes(base: str, addition: str) -> None:
    agent, plain, finished = create(base, addition), create(base), []
    for task in range(3):
        learned(agent, task)
        learned(plain, task)
        finished.append(agent.policy().act(SEEN, task=task))
        if addition == "snapshots":
            assert contents(agent) == contents(plain)
            assert np.array_equal(finished[-1], plain.policy().act(SEEN))
    assert agent.policy().num_tasks == 3
    for task, before in enumerate(finished):
        assert np.array_equal(agent.policy().act(SEEN, task=task), before)
        assert np.array_equal(agent.act(SEEN, in_task(task)), before)
    assert not np.array_equal(finished[0], finished[1])


@each_base
def test_packnet_acts_with_its_network_in_the_present_task_and_shares_the_hidden_layers(base: str) -> None:
    agent = learned(create(base, "packnet"), 0, 1, 2)
    np.testing.assert_allclose(agent.act(SEEN, in_task(2)), agent.act(SEEN), rtol=1e-4, atol=1e-5)
    policy = agent.policy()
    assert [each.ndim for each in policy.weights] == [2, 2, 3]
    hidden = 3 * 8 + 8 * 8
    shares = [np.count_nonzero(agent._owners == number) / hidden for number in (1, 2, 3)]
    np.testing.assert_allclose(shares, 1 / 3, atol=0.02)


@each_base
def test_packnet_without_hidden_layers_has_a_linear_policy_per_task(base: str) -> None:
    settings = {**BASES[base].settings, "policy_kwargs": {"net_arch": []}}
    make = with_addition(replace(BASES[base], settings=settings), "packnet")
    agent = learned(make(OBSERVATIONS, ACTIONS, 3), 0, 1)
    assert [each.shape for each in agent.policy().weights] == [(2, 3, 2)]
    np.testing.assert_allclose(agent.act(SEEN, in_task(0)), agent.policy().act(SEEN, task=0))


@each_base
def test_packnet_retrains_what_it_kept_after_it_pruned(base: str) -> None:
    agents = [learned(create(base, "packnet", retrain_share=share), 0) for share in (0.0, 0.5)]
    weights = [Actor(agent).theta for agent in agents]
    assert not np.array_equal(weights[0], weights[1])
    for agent, theta in zip(agents, weights, strict=True):
        assert (theta[: len(agent._owners)][agent._owners == 0] == 0).all()


@each_base
@pytest.mark.parametrize("addition", ADDITIONS)
def test_a_loaded_agent_learns_and_acts_as_the_saved_one(base: str, addition: str, tmp_path: Path) -> None:
    agent, loaded = learned(create(base, addition), 0, 1), create(base, addition, seed=8)
    agent.save(tmp_path / "agent.npz")
    loaded.load(tmp_path / "agent.npz")
    arrays = []
    for each in (agent, loaded):
        policy = learned(each, 2).policy()
        arrays.append({name: array.tobytes() for name, array in policy.arrays().items()})
        acted = each.act(SEEN, in_task(0)) if each.observes.task_in_evaluation else each.act(SEEN)
        np.testing.assert_allclose(np.clip(policy.act(SEEN), -1, 1), np.clip(acted, -1, 1), 1e-4, 1e-5)
    assert arrays[0] == arrays[1]
    assert agent.card() == loaded.card()


@each_base
@pytest.mark.parametrize("addition", TASK_AWARE)
def test_a_policy_that_samples_samples_in_earlier_tasks_and_continues_when_loaded(
    base: str, addition: str, tmp_path: Path
) -> None:
    make = with_addition(replace(BASES[base], deterministic=False), addition)
    agent, loaded = learned(make(OBSERVATIONS, ACTIONS, 3), 0, 1), make(OBSERVATIONS, ACTIONS, 8)
    first = agent.act(SEEN, in_task(0))
    agent.save(tmp_path / "agent.npz")
    loaded.load(tmp_path / "agent.npz")
    second = agent.act(SEEN, in_task(0))
    assert not np.array_equal(first, second)
    assert np.array_equal(loaded.act(SEEN, in_task(0)), second)


def test_the_card_states_settings_stored_states_and_copies() -> None:
    plain = learned(create("ppo"), 0, 1).card()
    cards = {name: learned(create("ppo", name), 0, 1).card() for name in ADDITIONS}
    stored = {name: card.stored_steps - plain.stored_steps for name, card in cards.items()}
    assert stored == dict.fromkeys(ADDITIONS, 0) | {"online-ewc": 40, "cloning": 80}
    more = {name: card.parameters - plain.parameters for name, card in cards.items()}
    head = 8 * 2 + 2 + 2
    whole = 3 * 8 + 8 + 8 * 8 + 8 + head
    assert more == dict.fromkeys(ADDITIONS, 0) | {"snapshots": whole, "packnet": head}
    assert cards["online-ewc"].hyperparameters["decay"] == 0.95
    assert cards["packnet"].hyperparameters["retrain_share"] == 0.2


def test_fisher_matrix_and_penalty_of_ppo_s_actor_are_those_of_trpo() -> None:
    agent = learned(create("ppo", "cloning", coefficient=3.0), 0)
    actor, inputs = Actor(agent), agent._normalizer.normalize_obs(SEEN).astype(np.float32)
    exact = continual.diagonal_fisher(Architecture(actor.sizes), actor.theta, inputs)
    np.testing.assert_allclose(actor.fisher(SEEN), exact, rtol=1e-4, atol=1e-6)
    learned(agent, 1)
    agent._draws = Mock(integers=lambda number, size: np.arange(number))
    inputs = agent._normalizer.normalize_obs(agent._stored["observations"]).astype(np.float32)
    targets = agent._stored["means"], np.log(agent._stored["sigmas"])
    penalty = continual.Divergence(3.0, Architecture(actor.sizes), inputs, *targets)
    found = agent._penalty_gradient(actor)
    np.testing.assert_allclose(found, penalty.gradient(actor.theta), rtol=1e-3, atol=1e-5)


def test_the_fisher_matrix_of_sac_s_actor_is_the_mean_squared_score() -> None:
    actor, state = Actor(learned(create("sac"), 0)), SEEN[:1]
    with torch.no_grad():
        policy = actor.gaussian(state)
    total = np.zeros(len(actor.theta))
    # Gauss–Hermite nodes in both actions: three are exact for the squared score, of degree four.
    nodes, weights = np.polynomial.hermite_e.hermegauss(3)
    for (i, p), (j, q) in product(enumerate(weights), repeat=2):
        action = policy.mean + policy.stddev * torch.tensor([[nodes[i], nodes[j]]], dtype=torch.float32)
        present: Any = actor.gaussian(state)
        density = present.log_prob(action).sum()
        total += p * q / (2 * np.pi) * flat(torch.autograd.grad(density, actor.parameters)) ** 2
    np.testing.assert_allclose(actor.fisher(state), total, rtol=1e-3, atol=1e-5)


@pytest.mark.parametrize("algorithm", [DQN, TD3])
@pytest.mark.parametrize("addition", ADDITIONS)
def test_an_algorithm_without_a_gaussian_actor_is_refused_by_name(algorithm: Any, addition: str) -> None:
    make = with_addition(sb3(algorithm, buffer_size=100), addition)
    space = gym.spaces.Discrete(3) if algorithm is DQN else ACTIONS
    with refused("no-actor", algorithm.__name__, where=make.card.algorithm):
        make(OBSERVATIONS, space, 0)


@each_base
def test_what_is_unknown_or_does_not_fit_is_refused(base: str) -> None:
    with pytest.raises(BenchError, match="no addition 'clonning'"):
        with_addition(BASES[base], "clonning")
    with pytest.raises(BenchError, match="no setting 'coefficient'"):
        with_addition(BASES[base], "reset", coefficient=1.0)
    with pytest.raises(BenchError, match="already has an addition"):
        with_addition(with_addition(BASES[base], "cloning"), "packnet")
    with pytest.raises(BenchError, match="single task at a time, but the environments run 2 tasks"):
        create(base, "snapshots").learn(Goals(0, 1), STEPS)


ADDED = [name for name in algorithms.names() if name.partition("-")[2] in ADDITIONS]


@pytest.mark.parametrize("name", ["sac64", *ADDED])
def test_each_has_a_name_pickles_and_describes_itself(name: str) -> None:
    assert len(ADDED) == 2 * len(ADDITIONS)
    make = pickle.loads(pickle.dumps(algorithms.factory(name)))  # noqa: S301  (as for a worker process)
    agent = make(OBSERVATIONS, ACTIONS, 0)
    card = checked_card(agent, "another name")
    assert card.algorithm == name == algorithms.name_of(name)
    assert card.parent == ("" if name.endswith(("64", "packnet")) else name.partition("-")[0])
    assert agent.observes.task_in_evaluation == name.endswith(TASK_AWARE)
