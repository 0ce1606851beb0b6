"""The published observations of the tasks fit the tasks, and are recorded again as they were."""

import numpy as np

from gym_extensions.catalog.descriptions import descriptions
from gym_extensions.catalog.groups import GROUPS
from gym_extensions.catalog.states import states
from gym_extensions.catalog.tasks import task
from gym_extensions.references import experts
from tools.environments.states import record


def test_every_group_but_those_of_images_has_observations_of_each_task() -> None:
    """Without those of a new task: python -m tools.environments."""
    for group in GROUPS.values():
        described = [descriptions()[each] for each in group.task_ids]
        found = states(group.task_ids)
        assert (found is not None) == all(each.observations for each in described), group.name
        shapes = {each.shape for each in found or []}
        assert len(shapes) <= 1, "all tasks of a group have the same observations"
        assert all(np.isfinite(each).all() and len(each) == 128 for each in found or [])


def test_a_group_with_a_task_of_ones_own_has_none() -> None:
    assert states(("gym_extensions/Hopper-v0", "mine/Hopper-v0")) is None


def test_policies_of_a_body_act_on_them() -> None:
    (observations,) = states(("gym_extensions/Hopper-v0",)) or []
    assert experts.load("Hopper").act(observations).shape == (128, 3)


def test_a_task_is_recorded_as_it_was_published() -> None:
    for name in ("HopperWall", "State-Based-Navigation-2d-Map0-Goal0"):
        (published,) = states((task(name).id,)) or []
        again = record(task(name)).astype(np.float32)
        assert np.array_equal(again[:, :4], published[:, :4]), "this machine has the published physics"
