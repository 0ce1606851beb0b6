"""What an agent asks for is what it can read; the rest is refused by name."""

from __future__ import annotations

import pickle
from dataclasses import fields

import numpy as np
import pytest

from gym_extensions.baselines import Context, Observes
from gym_extensions.baselines.agent import TaskLabel, not_requested
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.manifest import SECTIONS

STARTS = np.array([True, False])


def test_an_agent_can_ask_for_what_the_manifest_declares() -> None:
    assert [item.name for item in fields(Observes)] == list(SECTIONS["observes"].__struct_fields__)
    assert Observes() == Observes(False, False, False)


def test_the_task_is_in_the_context_of_an_agent_that_asked_for_it() -> None:
    context = Context(STARTS, TaskLabel("gym_extensions/Hopper-v0", 2))
    assert (context.task_id, context.task) == ("gym_extensions/Hopper-v0", 2)
    assert "Hopper" not in repr(context)


@pytest.mark.parametrize("name", ["task_id", "task"])
def test_the_task_is_refused_to_an_agent_that_did_not_ask(name: str) -> None:
    with pytest.raises(BenchError) as error:
        getattr(Context(STARTS), name)
    assert error.value.code == "not-requested"


def test_a_test_for_a_refused_attribute_raises_nothing() -> None:
    context = Context(STARTS)
    assert not hasattr(context, "task_id")
    assert getattr(context, "task", None) is None


def test_the_error_reaches_the_parent_of_a_worker_process_unchanged() -> None:
    error = not_requested("env.stage", "boundaries")
    copy = pickle.loads(pickle.dumps(error))  # noqa: S301
    assert (type(copy), str(copy), copy.code) == (type(error), str(error), "not-requested")
