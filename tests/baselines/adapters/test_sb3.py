"""Stable-Baselines3 models as agents: training, acting, saving, callbacks, and the manifest."""

import functools
import tomllib
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import pytest

torch = pytest.importorskip("torch")
pytest.importorskip("stable_baselines3")

from stable_baselines3 import PPO, SAC, TD3  # noqa: E402
from stable_baselines3.common.callbacks import BaseCallback  # noqa: E402

from gym_extensions.baselines import Context, Factory, Parallel, sb3, train  # noqa: E402
from gym_extensions.baselines.adapters.sb3 import to_manifest_value  # noqa: E402
from gym_extensions.baselines.adapters.sb3_vec_env import BatchVecEnv  # noqa: E402
from gym_extensions.baselines.training.environment import Report, TrainingEnv  # noqa: E402
from gym_extensions.envs import make_vec  # noqa: E402
from gym_extensions.errors import BenchError  # noqa: E402
from gym_extensions.submissions.run import read_run  # noqa: E402

from ...conftest import refused  # noqa: E402
from ..conftest import QUICK_GROUP, digests  # noqa: E402

NETWORK = {"net_arch": [8]}
SMALL: dict[str, Any] = {"n_steps": 30, "batch_size": 20, "n_epochs": 2, "policy_kwargs": NETWORK}
REPLAY = {"policy_kwargs": NETWORK, "learning_starts": 20, "buffer_size": 100, "batch_size": 8}
MODELS: dict[str, tuple[Any, Any]] = {"PPO": (PPO, SMALL), "SAC": (SAC, REPLAY), "TD3": (TD3, REPLAY)}


@pytest.fixture(scope="module")
def env() -> Any:
    return make_vec("Hopper", 2)


def create(env: Any, make: Factory, seed: int = 3) -> Any:
    return make(env.single_observation_space, env.single_action_space, seed)


def learn(agent: Any, env: Any, seed: int = 0, steps: int = 60) -> list[Report]:
    batches: list[Report] = []
    report = batches.append
    agent.learn(TrainingEnv(env, ["Hopper"], steps=steps, batch_steps=60, seed=seed, report=report), steps)
    return batches


def parameters(agent: Any) -> list[float]:
    """The sum of each parameter of the networks and of each moment of the optimizers."""
    leaves, _ = torch.utils._pytree.tree_flatten(agent._model.get_parameters())
    return [float(each.sum()) for each in leaves if isinstance(each, torch.Tensor)]


def test_ppo_trains_through_a_protocol_and_writes_a_submission(tmp_path: Path) -> None:
    network = {"net_arch": [8], "activation_fn": torch.nn.ReLU}
    settings: dict[str, Any] = {"n_steps": 125, "batch_size": 25, "n_epochs": 2, "policy_kwargs": network}
    agent = sb3(PPO, **settings, learning_rate=lambda left: 3e-4 * left)
    (log,) = train(agent, QUICK_GROUP, "joint", "smoke", 0, out=tmp_path / "ppo")
    manifest = tomllib.loads((tmp_path / "ppo/submission.toml").read_text())
    assert manifest["protocol"]["algorithm"] == "sb3-ppo", "not the reference agent"
    assert manifest["protocol"]["evaluation"] == "deterministic"
    stored = manifest["hyperparameters"]
    assert stored.pop("learning_rate").endswith("<lambda>")
    assert stored == settings | {"policy_kwargs": "{'net_arch': [8], 'activation_fn': ReLU}"}
    document = read_run(log.with_suffix(".json"))
    assert document.memory.stored_steps == 250
    assert not document.command, "no command line names the factory"
    assert document.packages == {name: version(name) for name in ("stable-baselines3", "torch")}
    assert 1900 < document.curves[0].steps[-1] <= 2000


def test_rollouts_that_no_budget_fits_are_refused_before_training(tmp_path: Path) -> None:
    agent = sb3(PPO, n_steps=600, policy_kwargs=NETWORK)
    with pytest.raises(BenchError, match=r"whole rollouts of n_steps = 600 × \d+ environments.*n_steps=250"):
        train(agent, QUICK_GROUP, "joint", "smoke", 0, out=tmp_path / "ppo")


class FailsInTheSecondStage(BaseCallback):
    """Raises at step 500 of the second stage."""

    stages = 0

    def _on_training_start(self) -> None:
        self.stages += 1

    def _on_step(self) -> bool:
        if self.stages == 2 and self.num_timesteps == 240:
            raise ValueError("disk full")
        return True


def test_a_run_whose_callback_raised_resumes_with_the_same_files(tmp_path: Path) -> None:
    def run(name: str, **options: Any) -> Path:
        make = sb3(PPO, normalize_observations=True, **SMALL, **options)
        parallel = Parallel(num_envs=2)
        train(make, QUICK_GROUP, "sequential", "smoke", 0, out=tmp_path / name, jobs=parallel)
        return tmp_path / name

    with pytest.raises(ValueError, match="disk full"):
        run("interrupted", callback=FailsInTheSecondStage())
    assert list((tmp_path / "interrupted").rglob("stage1.json"))
    assert not list((tmp_path / "interrupted").rglob("stage2.json"))
    assert digests(run("interrupted")) == digests(run("complete"))


@pytest.mark.parametrize("name", MODELS)
def test_a_loaded_agent_acts_and_learns_as_the_saved_one(name: str, env: Any, tmp_path: Path) -> None:
    model, settings = MODELS[name]
    options: dict[str, Any] = {"normalize_observations": True, "normalize_rewards": True}
    make = sb3(model, deterministic=False, **options, **settings)
    agent, loaded = create(env, make), create(env, make, seed=99)
    learn(agent, env, 1)
    agent.save(tmp_path / "agent.npz")
    loaded.load(tmp_path / "agent.npz")
    observations = np.random.default_rng(0).normal(size=(3, 11))
    before = parameters(agent)
    assert np.array_equal(agent.act(observations), loaded.act(observations))
    np.random.seed(7)  # noqa: NPY002  (what other code draws changes nothing)
    learn(agent, env, 2)
    learn(loaded, env, 2)
    assert parameters(loaded) == parameters(agent) != before
    assert loaded.card() == agent.card()
    assert np.array_equal(agent.act(observations), loaded.act(observations))


def test_acting_does_not_change_what_an_sb3_agent_learns(env: Any) -> None:
    results = []
    for num_actions in (3, 0):
        agent = create(env, sb3(PPO, deterministic=False, **SMALL))
        for seed in range(2):
            for _ in range(num_actions):
                agent.act(np.ones((2, 11)))
            learn(agent, env, seed)
        results.append(parameters(agent))
    assert results[0] == results[1]


@pytest.mark.parametrize("continues", [True, False])
def test_a_model_that_counts_again_at_each_task_uses_the_boundaries(continues: bool, env: Any) -> None:
    make: Any = sb3(PPO, **SMALL)
    assert create(env, replace(make, continue_counting=continues)).observes.boundaries is not continues


def test_a_recurrent_policy_keeps_its_state_until_an_episode_starts(env: Any) -> None:
    algorithm = pytest.importorskip("sb3_contrib").RecurrentPPO
    make = sb3(algorithm, n_steps=64, batch_size=64, n_epochs=1, policy_kwargs={"lstm_hidden_size": 8})
    agent = create(env, make)
    learn(agent, env, steps=128)
    observations = np.random.default_rng(0).normal(size=(6, 3, 11)).astype(np.float32)
    starts = np.zeros((6, 3), bool)
    starts[0], starts[4, 1] = True, True
    actions, state = [], None
    for seen, start in zip(observations, starts, strict=True):
        chosen, state = agent._model.predict(seen, state, start, deterministic=True)
        actions.append(chosen)
    for _ in range(2):  # a second evaluation starts again
        acted = [agent.act(seen, Context(start)) for seen, start in zip(observations, starts, strict=True)]
        assert np.array_equal(np.stack(acted), np.stack(actions))
    stateless = np.stack([agent._model.predict(seen, deterministic=True)[0] for seen in observations])
    assert np.array_equal(acted[4] == stateless[4], [[False] * 3, [True] * 3, [False] * 3])
    with refused("needs-context"):
        agent.act(np.zeros((2, 11), np.float32))


class Counter(BaseCallback):
    """Counts steps, rollouts and ended episodes."""

    steps = rollouts = episodes = ends = 0

    def _on_step(self) -> bool:
        self.steps += self.training_env.num_envs
        self.episodes += sum("episode" in info for info in self.locals["infos"])
        return True

    def _on_rollout_end(self) -> None:
        self.rollouts += 1

    def _on_training_end(self) -> None:
        self.ends += 1


def test_callbacks_are_called_as_in_sb3(env: Any) -> None:
    first, second = Counter(), Counter()
    learn(create(env, sb3(PPO, callback=[first, second], **SMALL)), env, steps=240)
    assert (first.steps, first.rollouts, first.ends, second.steps) == (240, 4, 1, 240)
    assert first.episodes > 0


def test_what_the_run_sets_is_an_error() -> None:
    with pytest.raises(BenchError, match="'seed'"):
        sb3(PPO, seed=1)


class Relu:
    """A class, such as a network's activation function."""


def linear(progress: float) -> float:
    return progress / 2


VALUES: list[tuple[Any, Any]] = [
    *((value, value) for value in ("relu", 3, 0.5, True, [400, 300], [])),
    ((8, "step"), (8, "step")),
    (None, "None"),
    (float("inf"), "inf"),
    ({"net_arch": {"pi": [64], "vf": (32,)}}, "{'net_arch': {'pi': [64], 'vf': [32]}}"),
    ({"activation_fn": Relu}, "{'activation_fn': Relu}"),
    (Relu(), "Relu"),
    (np.array([0.5, 1.0]), "[0.5, 1.0]"),
    (np.float32(0.5), "0.5"),
    ({"b", "a"}, "{'a', 'b'}"),
    (functools.partial(linear, progress=1), "functools.partial(<function linear>, progress=1)"),
    (list(range(5000)), str(list(range(5000)))[:4000]),
]


@pytest.mark.parametrize(("value", "stored"), VALUES, ids=[str(stored)[:30] for _, stored in VALUES])
def test_a_value_that_the_manifest_cannot_store_becomes_text(value: Any, stored: Any) -> None:
    assert to_manifest_value(value) == stored


def test_statistics_change_in_training_only_and_persist(env: Any) -> None:
    agent = create(env, sb3(PPO, normalize_observations=True, **SMALL))
    learn(agent, env, 1)
    statistics = agent._normalizer.obs_rms
    mean, count = statistics.mean.copy(), statistics.count
    agent.act(np.ones((4, 11)))
    assert np.array_equal(agent._normalizer.obs_rms.mean, mean)
    learn(agent, env, 2)
    # 30 steps and the first reset of two environments
    assert agent._normalizer.obs_rms.count - count == 62


def test_rewards_are_scaled_for_the_model_and_not_in_the_training_curve(env: Any) -> None:
    curves = []
    for normalize in (False, True):
        agent = create(env, sb3(PPO, normalize_rewards=normalize, **SMALL | {"learning_rate": 0.0}))
        curves.append([(batch.step, batch.returns) for batch in learn(agent, env, 1, steps=120)])
    assert curves[0] == curves[1] != []


def test_environments_without_a_last_observation_are_refused() -> None:
    with pytest.raises(BenchError, match="The mode is SAME_STEP"):
        BatchVecEnv(make_vec("Hopper", 2, autoreset_mode="SameStep"))


def test_an_environment_whose_episode_ended_is_reset_and_its_info_has_the_last_observation() -> None:
    env = BatchVecEnv(TrainingEnv(make_vec("Hopper", 3), ["Hopper"], steps=1000, batch_steps=100, seed=0))
    env.reset()
    for _ in range(200):
        step: Any = env.step(np.ones((3, 3), np.float32))
        observations, rewards, dones, infos = step
        if dones.any():
            break
    i = int(np.flatnonzero(dones)[0])
    assert rewards.dtype == np.float32
    assert not np.array_equal(infos[i]["terminal_observation"], observations[i])
    assert infos[i]["TimeLimit.truncated"] is False
    assert infos[i]["episode"]["l"] > 0
    assert 1.2 < observations[i][0] < 1.3, "a hopper starts 1.25 m above the ground"
