"""Stable-Baselines3 models as agents."""

from __future__ import annotations

import hashlib
import tomllib
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import pytest

torch = pytest.importorskip("torch")
stable_baselines3 = pytest.importorskip("stable_baselines3")

from gym_extensions.baselines import Context, Factory, sb3, train  # noqa: E402
from gym_extensions.baselines.adapters.sb3_agent import Sb3Agent  # noqa: E402
from gym_extensions.baselines.agent import Described  # noqa: E402
from gym_extensions.baselines.training.evaluation import evaluate  # noqa: E402
from gym_extensions.baselines.training.recorder import Recorder  # noqa: E402
from gym_extensions.envs import make_vec  # noqa: E402
from gym_extensions.errors import BenchError  # noqa: E402
from gym_extensions.rollouts.run import read_run  # noqa: E402

GROUP = "hopper-motor-noise"
"""A group of two tasks."""


def digests(folder: Path) -> dict[str, str]:
    """The sha256 of every finished file, by its path in the folder."""
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and ".progress" not in path.parts
    }


SMALL: dict[str, Any] = {"n_steps": 125, "batch_size": 25, "n_epochs": 2}


def ppo(width: int) -> Factory:
    """PPO with hidden layers of this width."""
    network = {"net_arch": [width], "activation_fn": torch.nn.ReLU}
    return sb3(stable_baselines3.PPO, **SMALL, policy_kwargs=network, learning_rate=lambda left: 3e-4 * left)


@pytest.fixture(scope="module")
def ppo_submission(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """PPO, joint, run 0, at the smoke budget."""
    folder = tmp_path_factory.mktemp("ppo")
    train(ppo(8), GROUP, "joint", "smoke", 0, out=folder)
    return folder


def test_ppo_trains_through_a_protocol_and_writes_a_submission(ppo_submission: Path) -> None:
    manifest = tomllib.loads((ppo_submission / "submission.toml").read_text())
    assert manifest["protocol"]["algorithm"] == "ppo"
    assert manifest["protocol"]["evaluation"] == "deterministic"
    document = read_run(ppo_submission / "hopper-motor-noise/joint/run0.json")
    assert document.memory.stored_steps == 250
    assert document.packages == {name: version(name) for name in ("stable-baselines3", "torch")}
    assert 1900 < document.curves[0].steps[-1] <= 2000


def test_every_setting_is_in_the_manifest(ppo_submission: Path) -> None:
    settings = tomllib.loads((ppo_submission / "submission.toml").read_text())["hyperparameters"]
    assert settings.keys() == {*SMALL, "policy_kwargs", "learning_rate"}
    assert {name: settings[name] for name in SMALL} == SMALL
    assert settings["policy_kwargs"] == "{'net_arch': [8], 'activation_fn': ReLU}"


def test_a_run_with_other_settings_is_rejected(ppo_submission: Path) -> None:
    with pytest.raises(BenchError) as error:
        train(ppo(16), GROUP, "joint", "smoke", 1, out=ppo_submission)
    assert error.value.code == "mixed-submission"


class FailsInTheSecondStage(stable_baselines3.common.callbacks.BaseCallback):  # type: ignore[misc,name-defined]
    """Raises at step 500 of the second stage."""

    stages = 0

    def _on_training_start(self) -> None:
        self.stages += 1

    def _on_step(self) -> bool:
        if self.stages == 2 and self.num_timesteps == 500:
            raise ValueError("disk full")
        return True


@pytest.mark.slow
def test_a_run_whose_callback_raised_resumes_with_the_same_files(tmp_path: Path) -> None:
    def run(name: str, **options: Any) -> Path:
        make = sb3(stable_baselines3.PPO, normalize_observations=True, **SMALL, **options)
        train(make, GROUP, "sequential", "smoke", 0, out=tmp_path / name)
        return tmp_path / name

    with pytest.raises(BenchError, match="FailsInTheSecondStage raised ValueError: disk full"):
        run("interrupted", callback=FailsInTheSecondStage())
    assert list((tmp_path / "interrupted").rglob("stage1.json"))
    assert not list((tmp_path / "interrupted").rglob("stage2.json"))
    folder = run("interrupted")
    assert digests(folder) == digests(run("complete"))


def test_the_card_has_the_settings_as_passed_even_if_the_model_changes_them() -> None:
    env = make_vec("Hopper", 1)
    network = {"net_arch": [8]}
    make = sb3(stable_baselines3.SAC, policy_kwargs=network, buffer_size=100)
    for _ in range(2):
        agent = make(env.single_observation_space, env.single_action_space, 3)
        assert isinstance(agent, Described)
        assert agent.card().hyperparameters == {"policy_kwargs": "{'net_arch': [8]}", "buffer_size": 100}
    assert network == {"net_arch": [8]}


def trained_parameters(num_actions: int) -> list[float]:
    """The sum of each parameter after two calls of learn, with sampled actions before each."""
    env = make_vec("Hopper", 1)
    make = sb3(stable_baselines3.PPO, deterministic=False, **SMALL)
    agent: Any = make(env.single_observation_space, env.single_action_space, 3)
    for _ in range(2):
        for _ in range(num_actions):
            agent.act(np.ones((2, 11)))
        agent.learn(Recorder(env, ["Hopper"], steps=125, batch_steps=125, seed=0), 125)
    return [float(values.detach().sum()) for values in agent._model.policy.parameters()]


@pytest.mark.parametrize("continues", [True, False])
def test_a_model_that_starts_to_count_again_at_each_task_uses_the_boundaries(continues: bool) -> None:
    env = make_vec("Pusher", 1)
    options = replace(ppo(8)._options, continue_counting=continues)  # type: ignore[attr-defined]
    agent = Sb3Agent((env.single_observation_space, env.single_action_space), 0, options)
    env.close()
    assert agent.observes.boundaries is not continues


def test_acting_does_not_change_what_an_sb3_agent_learns() -> None:
    assert trained_parameters(num_actions=3) == trained_parameters(num_actions=0)


@pytest.fixture(scope="module")
def recurrent() -> Any:
    """A RecurrentPPO agent after one batch of training."""
    algorithm = pytest.importorskip("sb3_contrib").RecurrentPPO
    env = make_vec("Hopper", 2)
    make = sb3(algorithm, n_steps=64, batch_size=64, n_epochs=1, policy_kwargs={"lstm_hidden_size": 8})
    agent = make(env.single_observation_space, env.single_action_space, 3)
    agent.learn(Recorder(env, ["Hopper"], steps=128, batch_steps=128, seed=0), 128)
    return agent


def test_a_recurrent_policy_keeps_its_state_until_an_episode_starts(recurrent: Any) -> None:
    observations = np.random.default_rng(0).normal(size=(6, 3, 11)).astype(np.float32)
    starts = np.zeros((6, 3), bool)
    starts[0], starts[4, 1] = True, True
    actions, state = [], None
    for seen, start in zip(observations, starts, strict=True):
        chosen, state = recurrent._model.predict(seen, state, start, deterministic=True)
        actions.append(chosen)
    for _ in range(2):  # a second evaluation starts again
        acted = [
            recurrent.act(seen, Context(start)) for seen, start in zip(observations, starts, strict=True)
        ]
        assert np.array_equal(np.stack(acted), np.stack(actions))
    stateless = np.stack([recurrent._model.predict(seen, deterministic=True)[0] for seen in observations])
    assert np.array_equal(acted[0], stateless[0])
    assert np.array_equal(acted[4] == stateless[4], [[False] * 3, [True] * 3, [False] * 3])


def test_an_evaluation_gives_a_recurrent_policy_the_starts_of_its_episodes(recurrent: Any) -> None:
    env = make_vec("Hopper", 3)
    first, second = evaluate(recurrent, env, [1, 2, 3]), evaluate(recurrent, env, [1, 2, 3])
    assert first == second
    assert recurrent._state[0].shape[1] == 3
    assert [row.length for row in evaluate(recurrent, make_vec("Hopper", 1), [2])] == [first[1].length]


def test_a_recurrent_policy_without_a_context_is_an_error(recurrent: Any) -> None:
    with pytest.raises(BenchError) as error:
        recurrent.act(np.zeros((2, 11), np.float32))
    assert error.value.code == "needs-context"
