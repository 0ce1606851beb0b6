"""The reference agents, and what holds of all of them."""

from __future__ import annotations

import numpy as np
import pytest

from gym_extensions.baselines import algorithms
from gym_extensions.baselines.agent import Described, Resumable
from gym_extensions.baselines.agent_checks import card_of
from gym_extensions.baselines.training.seeding import training_seed
from gym_extensions.catalog.bodies import SEGMENTS, segments
from gym_extensions.catalog.registry import TASKS
from gym_extensions.envs import make_batch

NAMES = ("random", "still", "trpo", "trpo-2017")


@pytest.fixture(scope="module")
def spaces():
    env = make_batch("Pusher", 1)
    return env.single_observation_space, env.single_action_space


def test_the_reference_agents_are_named():
    assert algorithms.names() == list(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_each_describes_itself_and_can_be_stopped(name, spaces):
    agent = algorithms.factory(name)(*spaces, 0)
    assert isinstance(agent, Described)
    assert isinstance(agent, Resumable)
    assert card_of(agent, "other").algorithm == name


@pytest.mark.parametrize("name", NAMES)
def test_each_gives_an_action_a_lane_and_repeats_itself_from_the_seed(name, spaces):
    seen = np.zeros((4, *spaces[0].shape))
    first, again = (algorithms.factory(name)(*spaces, 7).act(seen) for _ in range(2))
    assert first.shape == (4, *spaces[1].shape)
    assert np.array_equal(first, again)


def test_random_fills_the_box_and_still_stays_at_zero(spaces):
    seen = np.zeros((2000, *spaces[0].shape))
    drawn = algorithms.factory("random")(*spaces, 0).act(seen)
    low, high = spaces[1].low, spaces[1].high
    assert ((drawn >= low) & (drawn <= high)).all()
    np.testing.assert_allclose(drawn.mean(axis=0), (low + high) / 2, atol=0.1 * high.max())
    np.testing.assert_allclose(drawn.std(axis=0), (high - low) / np.sqrt(12), rtol=0.05)
    assert not algorithms.factory("still")(*spaces, 0).act(seen).any()


def test_an_untrained_trpo_2017_draws_around_the_middle_of_the_box_with_its_half_width(spaces):
    drawn = algorithms.factory("trpo-2017")(*spaces, 0).act(np.zeros((4000, *spaces[0].shape)))
    np.testing.assert_allclose(drawn.std(axis=0), spaces[1].high, rtol=0.06)
    np.testing.assert_allclose(drawn.mean(axis=0), 0.0, atol=0.15)


def test_seeds_differ_by_run_and_by_purpose():
    purposes = [
        ("hopper-gravity-v0", "agent"),
        ("hopper-gravity-v0", "training"),
        ("hopper-gravity-v0/agent", ""),
    ]
    found = {training_seed(run, *purpose) for run in range(5) for purpose in purposes}
    assert len(found) == 15
    assert all(0 <= seed < 2**32 for seed in found)


def test_every_task_is_cut_into_segments_of_its_family():
    found = {segments(task).steps for task in TASKS.values()}
    assert found == {5, 10}
    assert {task.base for task in TASKS.values() if segments(task).steps == 5} <= {"Pusher", "Striker"}
    assert all(row.tolerance > 0 for row in SEGMENTS.values())
