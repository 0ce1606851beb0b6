"""The environment of ``learn`` counts, clips, records, enforces the budget, and shows what was asked for."""

import time
from collections.abc import Callable
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.wrappers.vector import RecordEpisodeStatistics

from gym_extensions.baselines.training.environment import Report, TrainingEnv
from gym_extensions.envs import VectorTaskId, customize, group, make_vec
from gym_extensions.errors import BenchError
from gym_extensions.submissions.manifest import Observes

from ...conftest import refused


class Counting(gym.vector.VectorEnv[Any, Any, Any]):
    """Environments with episodes of ``lengths[i]`` steps of reward 1. Stores actions and seeds."""

    def __init__(self, lengths: list[int]) -> None:
        self.num_envs, self.lengths = len(lengths), np.array(lengths)
        self.single_observation_space = gym.spaces.Box(-1, 1, (1,))
        self.single_action_space = gym.spaces.Box(-0.5, 0.5, (1,))
        self.observation_space = gym.vector.utils.batch_space(self.single_observation_space, self.num_envs)
        self.action_space = gym.vector.utils.batch_space(self.single_action_space, self.num_envs)
        self.metadata = {"autoreset_mode": gym.vector.AutoresetMode.NEXT_STEP}
        self.received: list[Any] = []
        self.seeds: list[Any] = []

    def reset(self, *, seed: Any = None, options: Any = None) -> Any:
        self.seeds.append(seed)
        mask = np.ones(self.num_envs, bool) if options is None else options["reset_mask"]
        if options is None:
            self.at, self.over = np.zeros(self.num_envs, int), np.zeros(self.num_envs, bool)
        self.at[mask], self.over[mask] = 0, False
        return np.zeros((self.num_envs, 1)), {}

    def step(self, actions: Any) -> Any:
        self.received.append(actions)
        self.at = np.where(self.over, 0, self.at + 1)
        rewards = np.where(self.over, 0.0, 1.0)
        self.over = self.at == self.lengths
        return np.zeros((self.num_envs, 1)), rewards, np.zeros(self.num_envs, bool), self.over.copy(), {}


def recorded(
    lengths: list[int],
    steps: int,
    *,
    batch: int = 10,
    tasks: tuple[str, ...] = ("a",),
    report: Callable[[Report], object] = lambda _: None,
) -> TrainingEnv:
    return TrainingEnv(Counting(lengths), tasks, steps=steps, batch_steps=batch, seed=3, report=report)


def received_by(recorder: TrainingEnv) -> Counting:
    assert isinstance(recorder.env, Counting)
    return recorder.env


def run(recorder: TrainingEnv, vector_steps: int) -> None:
    recorder.reset()
    for _ in range(vector_steps):
        recorder.step(np.zeros((recorder.num_envs, 1)))


def test_the_step_that_resets_an_environment_is_not_counted() -> None:
    recorder = recorded([2, 5], steps=100)
    run(recorder, 6)
    # Environment 0: two steps, a reset, two steps, a reset. Environment 1: five steps, a reset.
    assert recorder.taken == 4 + 5


def test_actions_are_clipped_and_cast_to_the_dtype_of_the_action_space() -> None:
    recorder = recorded([5, 5], steps=100)
    recorder.reset()
    recorder.step(np.array([[2.0], [-0.25]]))
    received = received_by(recorder).received[0]
    assert received.tolist() == [[0.5], [-0.25]]
    assert received.dtype == np.float32


def test_a_point_is_the_mean_return_of_the_episodes_that_ended_since_the_last_point() -> None:
    batches: list[Report] = []
    recorder = recorded([2, 5], steps=100, batch=5, report=batches.append)
    run(recorder, 6)
    recorder.flush()
    # Five steps are taken after the third row of actions: environment 0 has ended once (return 2). In the
    # sixth row environment 1 is reset; its first and the other's second episode have ended: (2 + 5) / 2.
    assert [(batch.step, batch.returns) for batch in batches] == [(5, {"a": 2.0}), (9, {"a": 3.5})]


def test_each_task_of_joint_training_has_its_own_points() -> None:
    batches: list[Report] = []
    recorder = recorded([2, 4, 2, 4], steps=100, batch=100, tasks=("a", "b"), report=batches.append)
    run(recorder, 4)
    recorder.flush()
    assert [(batch.step, batch.returns) for batch in batches] == [(14, {"a": 2.0, "b": 4.0})]


def test_an_agent_may_exceed_its_budget_by_two_percent() -> None:
    recorder = recorded([1000], steps=100)
    run(recorder, 102)
    with refused("budget-exceeded"):
        for _ in range(10):
            recorder.step(np.zeros((1, 1)))


def test_the_agent_cannot_choose_the_seeds_of_its_training() -> None:
    mine, other = recorded([5], steps=100), recorded([5], steps=100)
    mine.reset(seed=1)
    other.reset(seed=2)
    other.reset()
    seeds = received_by(other).seeds
    assert received_by(mine).seeds[0] == seeds[0]
    assert seeds[1] != seeds[0]


def test_an_environment_that_is_reset_by_mask_takes_transitions_at_once() -> None:
    recorder = recorded([2, 5], steps=100)
    run(recorder, 2)
    recorder.reset(options={"reset_mask": np.array([True, False])})
    recorder.step(np.zeros((2, 1)))
    assert recorder.taken == 6
    with pytest.raises(BenchError, match="Give 2 booleans"):
        recorder.reset(options={"reset_mask": [True]})


GROUP = group("hopper-gravity")
EVERYTHING = Observes(True, True, True)
NEEDS = {
    "task_ids": "task_in_training",
    "env_task_ids": "task_in_training",
    "env_tasks": "task_in_training",
    "stage": "boundaries",
    "num_tasks": "boundaries",
}


def training(observes: Observes, trained: slice = slice(2, 4), num_envs: int = 4, stage: int = 3) -> Any:
    """The environment of the tasks in the slice of hopper-gravity."""
    tasks = GROUP.tasks[trained]
    shown: Any = {"observes": observes, "group_ids": GROUP.task_ids, "stage": stage}
    ids = [task.id for task in tasks]
    return TrainingEnv(make_vec(tasks, num_envs), ids, steps=400, batch_steps=50, seed=0, **shown)


def test_an_agent_that_asks_for_everything_reads_the_tasks_and_the_stage() -> None:
    env, (first, second) = training(EVERYTHING), GROUP.task_ids[2:4]
    assert env.task_ids == (first, second)
    assert env.env_task_ids == (first, second, first, second)
    assert env.env_tasks.tolist() == [2, 3, 2, 3]
    assert (env.stage, env.num_tasks) == (3, 5)


@pytest.mark.parametrize(("name", "needed"), NEEDS.items())
def test_an_attribute_that_was_not_asked_for_is_refused(name: str, needed: str) -> None:
    env = training(Observes(**{field: field != needed for field in NEEDS.values()}))
    with refused("not-requested"):
        getattr(env, name)
    assert not hasattr(env, name)
    assert getattr(env, name, None) is None


@pytest.mark.parametrize("method", ["call", "get_attr"])
def test_a_call_that_shows_the_task_is_refused(method: str) -> None:
    with pytest.raises(BenchError, match=r"^env\.call\('task'\): .* observes\.task_in_training\."):
        getattr(training(Observes(task_in_evaluation=True, boundaries=True)), method)("task")


def test_calls_return_what_the_wrapped_environment_returns() -> None:
    env = training(Observes(task_in_training=True))
    env.reset()
    assert env.call("task") == env.get_attr("task") == GROUP.tasks[2:4] * 2


def test_the_unwrapped_environment_and_the_spec_do_not_show_the_task() -> None:
    for observes, shown in ((Observes(), None), (EVERYTHING, gym.spec("CartPole-v1"))):
        env = training(observes)
        env.env.spec = gym.spec("CartPole-v1")
        assert env.unwrapped is env
        assert env.spec is (shown and env.env.spec)


def test_the_wrapper_that_appends_the_task_works_in_training() -> None:
    env = VectorTaskId(training(Observes(task_in_training=True)), GROUP)
    observations, _ = env.reset()
    assert observations[:, -5:].argmax(axis=1).tolist() == [2, 3, 2, 3]
    assert env.step(env.action_space.sample())[0].shape == (4, 16)


def test_the_spaces_and_the_generator_follow_from_the_runs_seed() -> None:
    first, second = training(Observes()), training(Observes())
    for name in ("action_space", "single_action_space", "observation_space", "single_observation_space"):
        samples = [getattr(env, name).sample() for env in (first, second)]
        assert np.array_equal(*samples)
    assert first.np_random.random() == second.np_random.random()


@pytest.mark.parametrize("mode", gym.vector.AutoresetMode)
def test_every_autoreset_mode_counts_transitions_and_returns(mode: gym.vector.AutoresetMode) -> None:
    batches: list[Report] = []
    env = make_vec(customize("Pusher", max_steps=5), 2, autoreset_mode=mode)
    recorder = TrainingEnv(env, ("a",), steps=100, batch_steps=100, seed=3, report=batches.append)
    recorder.reset()
    transitions = 0
    for _ in range(12):
        *_, truncated, infos = recorder.step(np.zeros((2, 7)))
        transitions += 2
        if mode is gym.vector.AutoresetMode.SAME_STEP:
            assert ("final_obs" in infos) == truncated.any()
        if mode is gym.vector.AutoresetMode.DISABLED and truncated.any():
            recorder.reset(options={"reset_mask": truncated})
    recorder.flush()
    is_next = mode is gym.vector.AutoresetMode.NEXT_STEP
    assert (recorder.taken, recorder.autoreset_mode) == (transitions - 4 * is_next, mode)
    assert batches[0].mean_return is not None
    assert RecordEpisodeStatistics(recorder).metadata["autoreset_mode"] is mode


def test_a_slow_agent_tells_how_far_it_is_within_a_batch(monkeypatch: pytest.MonkeyPatch) -> None:
    now, ticks = 0.0, list[tuple[int, float]]()
    monkeypatch.setattr(time, "perf_counter", lambda: now)
    given: Any = {"steps": 100, "batch_steps": 10, "seed": 3, "tick": lambda *each: ticks.append(each)}
    recorder = TrainingEnv(Counting([100]), ("a",), **given)
    recorder.reset()
    for _ in range(12):
        now += 4.0
        recorder.step(np.zeros((1, 1)))
    # After 10 steps a report starts the time again.
    assert ticks == [(3, 0.25), (6, 0.25), (9, 0.25)]
