"""The continual-learning agents on small tasks: what they keep, what they forget, and that they are trpo."""

from pathlib import Path

import numpy as np
import pytest

from gym_extensions.baselines.agent import Array
from gym_extensions.baselines.training.environment import TrainingEnv
from gym_extensions.errors import BenchError

from .goals import GOALS, Goals, in_task, learned, make

PENALTIES = ("l2", "l2-init", "online-ewc", "cloning")
TASK_AWARE = ("multi-head", "packnet")
METHODS = (*PENALTIES, "reset", *TASK_AWARE, "snapshots")
SEEN = np.random.default_rng(9).standard_normal((50, 3)).astype(np.float32)


def saved(agent: object, path: Path) -> dict[str, Array]:
    agent.save(path)  # type: ignore[attr-defined]
    with np.load(path) as arrays:
        return dict(arrays)


@pytest.mark.parametrize("name", PENALTIES)
def test_a_coefficient_of_zero_is_trpo_bit_by_bit(name: str, tmp_path: Path) -> None:
    plain = saved(learned("trpo", 2), tmp_path / "plain.npz")
    method = saved(learned(name, 2, coefficient=0.0), tmp_path / "method.npz")
    assert {key: method[key].tobytes() for key in plain} == {key: plain[key].tobytes() for key in plain}


@pytest.mark.parametrize("name", ["l2", "online-ewc", "cloning", "reset", "multi-head", "snapshots"])
def test_the_first_task_is_learned_as_by_trpo(name: str, tmp_path: Path) -> None:
    plain, method = (saved(learned(agent, 1), tmp_path / "agent.npz") for agent in ("trpo", name))
    assert np.array_equal(plain["policy"], method["policy"])


@pytest.mark.parametrize("name", ("trpo", *METHODS))
def test_a_loaded_agent_learns_and_acts_exactly_as_the_saved_agent(name: str, tmp_path: Path) -> None:
    original, loaded = learned(name, 2), make(name, seed=5)
    original.save(tmp_path / "agent.npz")
    loaded.load(tmp_path / "agent.npz")
    contents = []
    for agent in (original, loaded):
        agent.learn(Goals(2), 1_200)
        agent.save(tmp_path / "after.npz")
        contents.append((tmp_path / "after.npz").read_bytes())
    assert contents[0] == contents[1]
    assert original.card() == loaded.card()


@pytest.mark.parametrize("name", PENALTIES)
def test_a_strong_penalty_holds_the_policy_of_the_first_task_or_the_initial_weights(name: str) -> None:
    moved = {}
    for strength in (0.0, 1e5):
        agent = learned(name, tasks=int(name != "l2-init"), coefficient=strength)
        before = agent.act(SEEN)
        agent.learn(Goals(1), 1_200)
        moved[strength] = np.abs(agent.act(SEEN) - before).mean()
    assert moved[1e5] < 0.5 * moved[0.0]


def test_reset_starts_every_task_with_fresh_networks_and_moments() -> None:
    agent = learned("reset", 2)
    assert agent._moments.count == 1_200
    np.testing.assert_allclose(agent._moments.mean, 1, atol=0.2)
    assert agent._value.state["updates"] == learned("trpo", 1)._value.state["updates"]
    assert learned("trpo", 2)._moments.count == 2_400


@pytest.mark.parametrize("name", TASK_AWARE)
def test_each_task_has_its_output_layer_log_sigma_and_moments(name: str) -> None:
    agent = learned(name, 3, steps=4_000)
    for task, goal in enumerate(GOALS):
        chosen = agent.act(SEEN + task, in_task(task)).mean(axis=0)
        assert np.abs(chosen - goal).max() < np.abs(goal).max()
        assert agent._heads[task].moments.count == 4_000 * (task + 1)


def test_packnet_gives_every_task_a_third_of_the_hidden_weights() -> None:
    agent = learned("packnet", 3)
    weights = 3 * 8 + 8 * 8
    shares = [np.count_nonzero(agent._owners == number) / weights for number in (1, 2, 3)]
    np.testing.assert_allclose(shares, 1 / 3, atol=0.02)


@pytest.mark.parametrize("name", TASK_AWARE)
@pytest.mark.parametrize("copy_head", [False, True])
def test_a_task_starts_with_a_new_output_layer_or_that_of_the_task_before(name: str, copy_head: bool) -> None:
    agent = learned(name, 1, copy_head=copy_head)
    agent._begin()
    assert np.array_equal(agent._theta[agent._head], agent._heads[0].parameters) == copy_head
    assert ("copy_head" in agent.card().hyperparameters) == copy_head


def test_packnet_trains_the_weights_that_it_kept_for_a_share_of_the_budget() -> None:
    moved = {}
    for share in (0.0, 0.2, 0.5):  # none, one and two of three batches
        agent = make("packnet", retrain_share=share)
        agent.learn(Goals(0), 1_200)
        moved[share] = agent._theta
        assert agent.card().hyperparameters["retrain_share"] == share
    assert len({theta.tobytes() for theta in moved.values()}) == 3
    assert np.array_equal(learned("packnet", 1)._theta, moved[0.2])


@pytest.mark.parametrize("name", TASK_AWARE)
def test_a_task_that_was_not_learned_is_evaluated_with_the_present_head(name: str) -> None:
    agent = learned(name, 2)
    assert np.array_equal(agent.act(SEEN, in_task(2)), agent.act(SEEN, in_task(1)))


@pytest.mark.parametrize("name", TASK_AWARE)
def test_an_agent_with_heads_does_not_learn_several_tasks_at_once(name: str) -> None:
    with pytest.raises(BenchError, match="single task at a time, but the environments run 2 tasks"):
        make(name).learn(Goals(0, 1), 400)


def test_the_card_states_coefficient_stored_states_and_heads() -> None:
    cards = {name: learned(name, 2, steps=800).card() for name in ("trpo", *METHODS)}
    assert [cards[name].hyperparameters["coefficient"] for name in PENALTIES] == [
        make(name).published_coefficient for name in PENALTIES
    ]
    stored = {name: card.stored_steps - cards["trpo"].stored_steps for name, card in cards.items()}
    # 400 of the 800 observations of a task; cloning stores those of the first task during the second.
    assert stored == dict.fromkeys(cards, 0) | {"online-ewc": 400, "cloning": 800}
    head = 8 * 2 + 2 + 2
    assert {name: card.parameters - cards["trpo"].parameters for name, card in cards.items()} == (
        dict.fromkeys(cards, 0) | dict.fromkeys(TASK_AWARE, head) | {"snapshots": len(make("trpo")._theta)}
    )


@pytest.mark.parametrize("order", [(0, 1), (2, 1), (1, 2, 0)])
@pytest.mark.parametrize("name", METHODS)
def test_the_policy_as_arrays_acts_as_the_agent_in_every_task(name: str, order: tuple[int, ...]) -> None:
    agent = make(name)
    for task in order:
        agent.learn(Goals(task), 800)
    policy = agent.policy()
    assert policy.num_tasks <= 3
    for task in range(3):
        acted = agent.act(SEEN, in_task(task)) if agent.observes.task_in_evaluation else agent.act(SEEN)
        np.testing.assert_allclose(policy.act(SEEN, task=task), acted, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("name", TASK_AWARE)
def test_the_policy_of_a_single_later_task_has_a_row_for_every_earlier_one(name: str) -> None:
    agent = make(name)
    agent.learn(Goals(1), 400)
    assert agent.policy().num_tasks == 2
    assert np.array_equal(agent.policy().act(SEEN, task=0), agent.policy().act(SEEN, task=1))


@pytest.mark.parametrize("name", METHODS)
def test_each_learns_from_the_training_context_of_a_run(name: str) -> None:
    agent, ids = make(name), ("first", "second")
    for stage, task in enumerate(ids, start=1):
        shown = {"observes": agent.observes, "group_ids": ids, "stage": stage}
        env = TrainingEnv(Goals(stage - 1), [task], steps=400, batch_steps=200, seed=0, **shown)
        agent.learn(env, 400)
    assert agent.card().stored_steps >= 200


@pytest.mark.parametrize("name", ["packnet", "snapshots"])
def test_the_policy_of_a_finished_task_never_changes(name: str) -> None:
    agent, plain, finished = make(name), make("trpo"), []
    for task in range(3):
        agent.learn(Goals(task), 1_200)
        plain.learn(Goals(task), 1_200)
        finished.append(agent.act(SEEN, in_task(task)))
        if name == "snapshots":  # learns as trpo, and acts so in a task that it did not learn
            assert np.array_equal(agent.policy().act(SEEN, task=2), plain.policy().act(SEEN))
            assert agent.card().parameters == plain.card().parameters + task * len(plain._theta)
    for task, before in enumerate(finished):
        assert np.array_equal(agent.act(SEEN, in_task(task)), before)
    assert not np.array_equal(finished[0], finished[1])
