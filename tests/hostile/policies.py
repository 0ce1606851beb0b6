"""Hostile policies: arrays of wrong shapes, types and values, and policies of other runs."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from gym_extensions.rollouts.safe_npz import npz_bytes

from ..rollouts.examples import Change
from .case import POLICIES, POLICY, Case, all_of, put

NAMES = {
    "head": b"deterministic",
    "activation": b"tanh",
    "output_activation": b"linear",
    "squash": b"linear",
    "observation_dtype": b"float64",
}
TASKS = (
    "HopperGravityHalf",
    "HopperGravityThreeQuarters",
    "Hopper",
    "HopperGravityOneAndQuarter",
    "HopperGravityOneAndHalf",
)


def policy(**changes: object) -> bytes:
    """A linear policy of Hopper with these arrays changed; None removes one."""
    text = {name: np.frombuffer(value, np.uint8) for name, value in NAMES.items()}
    content: dict[str, object] = {
        "format": np.array(1),
        **text,
        "action_offset": np.zeros(3),
        "action_scale": np.ones(3),
    }
    content |= {"weight_0": np.zeros((11, 3)), "bias_0": np.zeros(3), **changes}
    return npz_bytes({name: np.asarray(values) for name, values in content.items() if values is not None})


def policies(data: bytes | Callable[[], bytes]) -> Change:
    """The same policy file for all tasks."""
    return all_of(*(put(f"{POLICIES}/single-run0-stage1-{task}.npz", data) for task in TASKS))


CASES = (
    Case("a policy without a layer's bias", policies(policy(bias_0=None)), ("malformed-policy",)),
    Case(
        "a policy whose weights are not numbers",
        policies(policy(weight_0=np.full((11, 3), np.nan))),
        ("malformed-policy",),
    ),
    Case(
        "a policy of infinite weights",
        policies(policy(weight_0=np.full((11, 3), np.inf))),
        ("malformed-policy",),
    ),
    Case(
        "a policy of other observations",
        policies(policy(weight_0=np.zeros((12, 3)))),
        ("policy-fails",),
        "new seeds",
    ),
    Case(
        "a policy of other actions",
        policies(
            policy(
                action_offset=np.zeros(2),
                action_scale=np.ones(2),
                weight_0=np.zeros((11, 2)),
                bias_0=np.zeros(2),
            )
        ),
        ("policy-fails",),
        "new seeds",
    ),
    Case(
        "a policy of an unknown activation",
        policies(policy(activation=np.frombuffer(b"exec", np.uint8))),
        ("malformed-policy",),
    ),
    Case("a policy of an unknown array", policies(policy(code=np.zeros(3))), ("malformed-policy",)),
    Case(
        "a policy of a gigantic matrix",
        policies(lambda: policy(weight_0=np.zeros((11, 100_000)), bias_0=np.zeros(100_000))),
        ("malformed-policy",),
    ),
    Case("a policy of 2 MiB", put(POLICY, bytes(2**21 + 1)), ("missing-policy", "too-large")),
    Case(
        "a policy of 100 layers",
        policies(
            policy(
                weight_0=np.zeros((11, 11)),
                bias_0=np.zeros(11),
                **{f"weight_{i}": np.zeros((11, 3 if i == 99 else 11)) for i in range(1, 100)},
                **{f"bias_{i}": np.zeros(3 if i == 99 else 11) for i in range(1, 100)},
            )
        ),
        (),
    ),
    Case(
        "a policy of a missing layer",
        policies(policy(weight_5=np.zeros((3, 3)), bias_5=np.zeros(3))),
        ("malformed-policy",),
    ),
    Case(
        "a policy of numbers that overflow",
        policies(
            policy(
                weight_0=np.full((11, 3), 1e308),
                observation_mean=np.zeros(11),
                observation_scale=np.full(11, 5e-324),
            )
        ),
        ("policy-fails",),
        "new seeds",
    ),
    Case("a policy of empty arrays", policies(policy(weight_0=np.zeros((0, 3)))), ("malformed-policy",)),
    Case("a policy of scalars", policies(policy(weight_0=np.array(1.0))), ("malformed-policy",)),
    Case("a policy of 32 dimensions", policies(policy(weight_0=np.zeros((1,) * 32))), ("malformed-policy",)),
    Case(
        "a policy of rows per task",
        policies(policy(weight_0=np.zeros((5, 11, 3)))),
        ("policy-observes-task",),
    ),
    Case("one policy of five", put(POLICY, policy()), ("missing-policy",)),
    Case(
        "a policy of a run that does not exist",
        all_of(policies(policy()), put(POLICY.replace("run0", "run7"), policy())),
        ("foreign-policy",),
    ),
    Case(
        "a policy of another stage",
        all_of(policies(policy()), put(POLICY.replace("stage1", "stage9"), policy())),
        ("foreign-policy",),
    ),
)
