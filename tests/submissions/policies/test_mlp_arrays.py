"""The arrays of a policy: their names, and what can be wrong with them."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from gym_extensions.submissions.policies.mlp_arrays import array_errors

from .test_mlp import SMALL, TASKED

Arrays = dict[str, Any]


def text(value: str) -> Any:
    return np.frombuffer(value.encode(), np.uint8)


GAUSSIAN = {"head": text("gaussian")}
WRONG: dict[str, tuple[Callable[[Arrays], object], str]] = {
    "a missing layer": (lambda a: (a.pop("weight_0"), a.pop("bias_0")), "'weight_0' is missing"),
    "a missing bias": (lambda a: a.pop("bias_1"), "'bias_1' is missing"),
    "a missing scale of actions": (lambda a: a.pop("action_scale"), "'action_scale' is missing"),
    "a mean alone": (lambda a: a.update(observation_mean=np.zeros(2)), "'observation_scale' is missing"),
    "a scale alone": (lambda a: a.update(observation_scale=np.ones(2)), "'observation_mean' is missing"),
    "a slope alone": (
        lambda a: (a.update(log_sigma_weight=np.zeros((3, 1))), a.pop("log_sigma")),
        "'log_sigma' is missing",
    ),
    "an unknown array": (lambda a: a.update(memory=np.zeros(3)), "Unexpected array 'memory'"),
    "no layer": (lambda a: a.update(weight=np.zeros(3)), "Unexpected array 'weight'"),
    "NaN weights": (lambda a: a["weight_1"].fill(np.nan), "'weight_1' contains a value that is not finite"),
    "an unknown name": (lambda a: a.update(head=text("greedy")), "'greedy'; expected one of deterministic,"),
    "no ASCII": (lambda a: a.update(head=np.full(2, 255, np.uint8)), "'head' is '��'"),
    "half precision": (lambda a: a.update(weight_0=a["weight_0"].astype(np.float16)), "float16; expected"),
    "another byte order": (lambda a: a.update(bias_0=a["bias_0"].astype(">f4")), "is >f4; expected float32"),
    "another format": (lambda a: a.update(format=np.array(2)), "The format is 2; expected 1"),
    "layers that do not fit": (lambda a: a.update(weight_1=np.zeros((4, 1))), "(2, 3); expected (2, 4)"),
    "a bias of another width": (lambda a: a.update(bias_0=np.zeros(4)), "the shape (4,); expected (3,)"),
    "a scalar for weights": (lambda a: a.update(weight_0=np.float64(1)), "the shape (); expected (0, 3)"),
    "observations of another size": (
        lambda a: a.update(observation_mean=np.zeros(3), observation_scale=np.ones(3)),
        "'observation_mean' has the shape (3,); expected (2,)",
    ),
    "no actions": (lambda a: a.update(weight_1=np.zeros((3, 0)), bias_1=np.zeros(0)), "'weight_1' is empty"),
    "a scale of zero": (
        lambda a: a.update(observation_mean=np.zeros(2), observation_scale=np.zeros(2)),
        "'observation_scale' contains a value that is not above 0",
    ),
    "no sigma": (lambda a: (a.update(GAUSSIAN), a.pop("log_sigma")), "a gaussian policy needs it"),
    "exchanged bounds": (lambda a: a.update(log_sigma_clip=np.array([2.0, -20.0])), "above the upper bound"),
    "numbers of tasks": (
        lambda a: a.update(bias_0=np.zeros((2, 3)), bias_1=np.zeros((3, 1))),
        "'bias_1' has rows for 3 tasks; 'bias_0' has 2",
    ),
    "actions per task": (lambda a: a.update(action_scale=np.ones((2, 1))), "shape (2, 1); expected (1,)"),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_arrays_are_named(name: str) -> None:
    change, fact = WRONG[name]
    arrays = {name: values.copy() for name, values in SMALL.arrays().items()}
    change(arrays)
    assert fact in next(array_errors(arrays))


def test_valid_arrays_have_no_errors() -> None:
    assert list(array_errors(SMALL.arrays())) == []
    assert list(array_errors(TASKED.arrays())) == []
