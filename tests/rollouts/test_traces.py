"""Traces: what is written is what is read, and anything else is a problem with a reason."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from gym_extensions.catalog.registry import TASKS
from gym_extensions.envs.state import DERIVED as DERIVED_STATE
from gym_extensions.rollouts.auditing.digests import trace_digest
from gym_extensions.rollouts.folder import scan
from gym_extensions.rollouts.problem import Problem
from gym_extensions.rollouts.safe_npz import read
from gym_extensions.rollouts.trace_reader import RecordedEpisode, TraceRequest, read_trace
from gym_extensions.rollouts.traces import DERIVED, cut, lengths, trace_arrays, trace_bytes

Arrays = dict[str, NDArray[Any]]
PATH = "hopper-gravity/traces/trace.npz"
LENGTH, K = 27, 10
REWARDS = np.arange(LENGTH) / 8
OUTCOME = (LENGTH, float(REWARDS.sum()), True, None)
STATES: list[Arrays] = [
    {"qpos": np.full(6, float(t)), "time": np.array(float(t)), "derived_x": np.zeros(2)} for t in (9, 19, 29)
]
ACTIONS = np.linspace(-1, 1, 3 * LENGTH).reshape(LENGTH, 3)
DIGEST = trace_digest(trace_arrays(cut(ACTIONS, REWARDS, STATES, K)), *OUTCOME)
REQUEST = TraceRequest(PATH, TASKS["gym_extensions/Hopper-v0"], 7, *OUTCOME, digest=DIGEST)


def valid() -> Arrays:
    """The arrays of a valid trace of ``REQUEST``."""
    return dict(read(trace_bytes(cut(ACTIONS, REWARDS, STATES, K))) or {})


def reread(folder: Path, arrays: Arrays) -> RecordedEpisode | Problem:
    """The trace of these arrays, read from a folder."""
    content = io.BytesIO()
    np.savez_compressed(content, allow_pickle=False, **arrays)
    (folder / PATH).parent.mkdir(parents=True)
    (folder / PATH).write_bytes(content.getvalue())
    return read_trace(scan(folder), REQUEST)


def test_an_episode_is_cut_into_segments_with_a_state_before_each_but_the_first() -> None:
    arrays = valid()
    assert set(arrays) == {"actions", "segment_steps", "segment_returns", "state_qpos", "state_time"}
    assert arrays["segment_returns"].tolist() == [
        REWARDS[:10].sum(),
        REWARDS[10:20].sum(),
        REWARDS[20:].sum(),
    ]
    assert arrays["state_time"].tolist() == [9.0, 19.0]
    assert arrays["state_qpos"].shape == (2, 6)
    assert arrays["actions"].dtype == np.float32


@pytest.mark.parametrize(("steps", "segments"), [(1, 1), (10, 1), (11, 2), (20, 2), (21, 3)])
def test_lengths_of_the_arrays(steps: int, segments: int) -> None:
    assert lengths(steps, K) == {"actions": steps, "segment_returns": segments, "state_": segments - 1}


def test_a_written_trace_is_read_as_it_was(tmp_path: Path) -> None:
    episode = reread(tmp_path, valid())
    assert isinstance(episode, RecordedEpisode)
    assert (episode.where, episode.task, episode.seed) == (PATH, REQUEST.task, 7)
    assert (episode.length, episode.terminated, episode.segment_steps) == (LENGTH, True, K)
    assert np.array_equal(episode.actions, ACTIONS.astype(np.float32))
    assert set(episode.states) == {"qpos", "time"}


def test_a_trace_with_another_action_is_not_the_one_of_the_log(tmp_path: Path) -> None:
    arrays = valid()
    arrays["actions"] = -arrays["actions"]
    problem = reread(tmp_path, arrays)
    assert isinstance(problem, Problem)
    assert (problem.rule, problem.message) == (
        "trace-differs",
        "The log commits to another trace of this episode.",
    )


def test_equal_traces_have_equal_bytes() -> None:
    assert trace_bytes(cut(ACTIONS, REWARDS, STATES, K)) == trace_bytes(cut(ACTIONS, REWARDS, STATES, K))


def test_a_missing_trace_is_a_problem(tmp_path: Path) -> None:
    problem = read_trace(scan(tmp_path), REQUEST)
    assert isinstance(problem, Problem)
    assert (problem.rule, problem.where) == ("trace-missing", PATH)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda a: a.pop("actions"), "The array 'actions' is missing."),
        (lambda a: a.update(segment_steps=np.array(5)), "'segment_steps' is 5; it is 10 for Hopper."),
        (
            lambda a: a.update(actions=a["actions"].astype(np.float64)),
            "'actions' is float64 of shape (27, 3); expected float32 of shape (27, …).",
        ),
        (
            lambda a: a.update(state_qpos=a["state_qpos"][:1]),
            "'state_qpos' is float64 of shape (1, 6); expected float64 of shape (2, …).",
        ),
        (
            lambda a: a.update(segment_returns=np.zeros((3, 1))),
            "'segment_returns' is float64 of shape (3, 1); expected float64 of shape (3,).",
        ),
        (
            lambda a: a.update(actions=np.full_like(a["actions"], np.inf)),
            "'actions' contains a value that is not finite.",
        ),
        (lambda a: a.update(rewards=REWARDS), "Unexpected array 'rewards'."),
        (
            lambda a: a.update(segment_returns=np.array([1.0, 2.0, 3.0])),
            "The segment returns sum to 6.0; the return in the log is 43.875.",
        ),
        (
            lambda a: a.update(segment_returns=np.full(3, 1.7e308)),
            "The segment returns sum to inf; the return in the log is 43.875.",
        ),
    ],
)
def test_a_trace_with_other_arrays_is_a_problem(
    tmp_path: Path, change: Callable[[Arrays], object], message: str
) -> None:
    arrays = valid()
    change(arrays)
    problem = reread(tmp_path, arrays)
    assert isinstance(problem, Problem)
    assert (problem.rule, problem.message) == ("trace-malformed", message)


def test_environments_and_traces_agree_on_derived_states() -> None:
    assert DERIVED == DERIVED_STATE
