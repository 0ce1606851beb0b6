"""Every way in which the arrays of a policy file can be wrong, with its message."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from gym_extensions.errors import BenchError
from gym_extensions.rollouts.layout import MAX_UNPACKED_POLICY_BYTES
from gym_extensions.rollouts.policies import Policy
from gym_extensions.rollouts.policies.checks import array_errors
from gym_extensions.rollouts.safe_npz import npz_bytes

from .examples import SMALL, TASKED

Arrays = dict[str, Any]


def text(value: str) -> Any:
    return np.frombuffer(value.encode(), np.uint8)


WRONG: list[tuple[str, Callable[[Arrays], object], str]] = [
    ("a missing layer", lambda a: (a.pop("weight_0"), a.pop("bias_0")), "The array 'weight_0' is missing."),
    ("a missing bias", lambda a: a.pop("bias_1"), "The array 'bias_1' is missing."),
    ("a missing scale of actions", lambda a: a.pop("action_scale"), "The array 'action_scale' is missing."),
    (
        "a mean without a scale",
        lambda a: a.update(observation_mean=np.zeros(2)),
        "The array 'observation_scale' is missing.",
    ),
    (
        "a scale without a mean",
        lambda a: a.update(observation_scale=np.ones(2)),
        "The array 'observation_mean' is missing.",
    ),
    ("an unknown array", lambda a: a.update(memory=np.zeros(3)), "Unexpected array 'memory'."),
    ("an array without a layer", lambda a: a.update(weight=np.zeros(3)), "Unexpected array 'weight'."),
    (
        "NaN weights",
        lambda a: a["weight_1"].fill(np.nan),
        "'weight_1' contains a value that is not finite.",
    ),
    (
        "an unknown activation",
        lambda a: a.update(activation=text("swish")),
        "'activation' is 'swish'; expected one of linear, tanh, relu, leaky_relu, elu, silu.",
    ),
    (
        "an unknown head",
        lambda a: a.update(head=text("greedy")),
        "'head' is 'greedy'; expected one of deterministic, gaussian, uniform.",
    ),
    (
        "a name that is not ASCII",
        lambda a: a.update(head=np.full(2, 255, np.uint8)),
        "'head' is '��'; expected one of deterministic, gaussian, uniform.",
    ),
    (
        "half precision",
        lambda a: a.update(weight_0=a["weight_0"].astype(np.float16)),
        "'weight_0' is float16; expected float32 or float64.",
    ),
    (
        "the other byte order",
        lambda a: a.update(bias_0=a["bias_0"].astype(">f4")),
        "'bias_0' is >f4; expected float32 or float64.",
    ),
    ("another format", lambda a: a.update(format=np.array(2)), "The format is 2; expected 1."),
    (
        "layers that do not fit",
        lambda a: a.update(weight_1=np.zeros((4, 1))),
        "'weight_0' has the shape (2, 3); expected (2, 4).",
    ),
    (
        "a bias of another width",
        lambda a: a.update(bias_0=np.zeros(4)),
        "'bias_0' has the shape (4,); expected (3,).",
    ),
    (
        "a scalar instead of weights",
        lambda a: a.update(weight_0=np.float64(1)),
        "'weight_0' has the shape (); expected (0, 3).",
    ),
    (
        "observations of another size",
        lambda a: a.update(observation_mean=np.zeros(3), observation_scale=np.ones(3)),
        "'observation_mean' has the shape (3,); expected (2,).",
    ),
    (
        "no actions",
        lambda a: a.update(weight_1=np.zeros((3, 0)), bias_1=np.zeros(0)),
        "'weight_1' is empty.",
    ),
    (
        "a scale of zero",
        lambda a: a.update(observation_mean=np.zeros(2), observation_scale=np.zeros(2)),
        "'observation_scale' contains a value that is not above 0.",
    ),
    (
        "a gaussian head without sigma",
        lambda a: (a.update(head=text("gaussian")), a.pop("log_sigma")),
        "The array 'log_sigma' is missing; a gaussian policy needs it.",
    ),
    (
        "bounds in the wrong order",
        lambda a: a.update(log_sigma_clip=np.array([2.0, -20.0])),
        "The lower bound in 'log_sigma_clip' is above the upper bound.",
    ),
    (
        "tasks of different numbers",
        lambda a: a.update(bias_0=np.zeros((2, 3)), bias_1=np.zeros((3, 1))),
        "'bias_1' has rows for 3 tasks; 'bias_0' has 2.",
    ),
    (
        "actions per task",
        lambda a: a.update(action_scale=np.ones((2, 1))),
        "'action_scale' has the shape (2, 1); expected (1,).",
    ),
]


@pytest.mark.parametrize(("change", "message"), [row[1:] for row in WRONG], ids=[row[0] for row in WRONG])
def test_wrong_arrays_are_named(change: Callable[[Arrays], object], message: str) -> None:
    arrays = {name: values.copy() for name, values in SMALL.arrays().items()}
    change(arrays)
    assert next(array_errors(arrays)) == message
    with pytest.raises(BenchError) as error:
        Policy.from_bytes(npz_bytes(arrays))
    assert error.value.message == message


def test_valid_arrays_have_no_errors() -> None:
    assert list(array_errors(SMALL.arrays())) == []
    assert list(array_errors(TASKED.arrays())) == []


def test_a_gigantic_matrix_is_refused_before_it_is_unpacked() -> None:
    size = MAX_UNPACKED_POLICY_BYTES // 12 + 1
    data = npz_bytes(SMALL.arrays() | {"weight_0": np.zeros((size, 3), np.float32)})
    assert len(data) < 100_000
    with pytest.raises(BenchError, match="The file cannot be read"):
        Policy.from_bytes(data)
