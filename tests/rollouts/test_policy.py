"""A policy's actions, worked by hand; what can be wrong with its arrays; the policies of a run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gym_extensions.catalog.groups import group
from gym_extensions.errors import BenchError
from gym_extensions.rollouts import run_policies
from gym_extensions.rollouts.layout import MAX_POLICY_BYTES, POLICIES, run_file
from gym_extensions.rollouts.policy import Policy
from gym_extensions.rollouts.policy_arrays import ACTIVATIONS, KEYS, LAYER_FIELDS, array_errors

from .examples import arrays

Arrays = dict[str, Any]
SEEN = np.random.default_rng(0).standard_normal((40, 2))
SMALL = Policy(
    action_offset=np.zeros(1, np.float32),
    action_scale=np.ones(1, np.float32),
    weights=(np.array([[0.5, -1.0, 2.0], [1.0, 0.0, 0.5]], np.float32), np.ones((3, 1), np.float32)),
    biases=(np.zeros(3, np.float32), np.full(1, 0.125, np.float32)),
    activation="tanh",
    log_sigma=np.full(1, -1.0, np.float32),
)
TASKED = Policy(
    action_offset=np.zeros(1),
    action_scale=np.ones(1),
    weights=(np.array([[[1.0], [1.0]], [[1.0], [-1.0]]]),),
    biases=(np.zeros(1),),
    masks=(np.array([[[True], [True]], [[True], [False]]]),),
)
"""Two rows of tasks: the sum of the observations, and the first of them."""


def test_a_network_of_two_layers() -> None:
    policy = Policy(
        action_offset=np.array([1.0]),
        action_scale=np.array([10.0]),
        weights=(np.array([[1.0, -1.0], [0.0, 2.0]]), np.array([[1.0], [3.0]])),
        biases=(np.array([0.5, -1.0]), np.array([0.25])),
        activation="relu",
    )
    # Hidden: relu(2 + .5, −2 + 6 − 1) = 2.5, 3; output 2.5 + 9 + .25.
    assert policy.act(np.array([[2.0, 3.0]])).tolist() == [[1 + 10 * 11.75]]


def test_observations_are_normalized_and_clipped() -> None:
    policy = replace(
        TASKED,
        masks=(),
        observation_mean=np.array([1.0, 2.0]),
        observation_scale=np.array([2.0, 0.5]),
        observation_clip=3.0,
    )
    # (5 − 1) / 2 = 2; (10 − 2) / .5 = 16, clipped to 3. Row 0 of the weights is the sum.
    assert policy.act(np.array([[5.0, 10.0]])).tolist() == [[5.0]]


def test_without_layers_the_action_is_constant_for_every_observation() -> None:
    policy = Policy(np.array([0.5, -1.0], np.float32), np.ones(2, np.float32))
    assert policy.act(np.zeros((3, 7))).tolist() == [[0.5, -1.0]] * 3
    assert policy.num_inputs is None


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("linear", [-2.0, 0.0, 2.0]),
        ("tanh", [-0.9640275801, 0.0, 0.9640275801]),
        ("relu", [0.0, 0.0, 2.0]),
        ("leaky_relu", [-0.02, 0.0, 2.0]),
        ("elu", [-0.8646647168, 0.0, 2.0]),  # e⁻² − 1
        ("silu", [-0.2384058440, 0.0, 1.7615941560]),  # ± 2 / (1 + e^∓2)
    ],
)
def test_each_activation(name: str, expected: list[float]) -> None:
    np.testing.assert_allclose(ACTIVATIONS[name](np.array([-2.0, 0.0, 2.0])), expected, atol=1e-10)
    assert ACTIVATIONS[name](np.ones(1, np.float32)).dtype == np.float32


def test_the_mean_and_the_sample_are_squashed_separately() -> None:
    mean = np.full((1, 1), 2.0)
    policy = Policy(np.zeros(1), np.ones(1), weights=(np.ones((1, 1)),), biases=(np.zeros(1),))
    before = replace(policy, output_activation="tanh", head="gaussian", log_sigma=np.zeros(1))
    after = replace(policy, squash="tanh", head="gaussian", log_sigma=np.zeros(1))
    noise = np.random.default_rng(5).standard_normal((1, 1))
    assert before.act(mean, np.random.default_rng(5)) == np.tanh(2.0) + noise
    assert after.act(mean, np.random.default_rng(5)) == np.tanh(2.0 + noise)


def test_sigma_may_depend_on_the_observation_within_bounds() -> None:
    policy = replace(
        SMALL,
        head="gaussian",
        weights=(np.zeros((2, 1), np.float32),),
        biases=(np.zeros(1, np.float32),),
        log_sigma=np.array([0.5], np.float32),
        log_sigma_weight=np.array([[1.0], [0.0]], np.float32),
        log_sigma_clip=np.array([-2.0, 1.0], np.float32),
    )
    states = np.array([[-1.0, 0.0], [-9.0, 0.0], [9.0, 0.0]]).repeat(20_000, axis=0)
    actions = policy.act(states, np.random.default_rng(0)).reshape(3, -1)
    np.testing.assert_allclose(actions.std(axis=1), np.exp([-0.5, -2.0, 1.0]), rtol=0.02)


def test_a_uniform_policy_fills_the_range() -> None:
    policy = Policy(np.array([1.0]), np.array([2.0]), head="uniform")
    actions = policy.act(np.zeros((20_000, 3)), np.random.default_rng(0))
    assert (actions.min(), actions.max()) == pytest.approx((-1.0, 3.0), abs=0.01)
    assert actions.mean() == pytest.approx(1.0, abs=0.05)


def test_arrays_per_task_and_masks() -> None:
    state = np.array([[1.0, 10.0]])
    # Row 0 sums; row 1 is the difference, and its mask leaves out the second observation.
    assert [TASKED.act(state, task=task).item() for task in (0, 1, 2)] == [11.0, 1.0, 1.0]
    assert (TASKED.num_tasks, SMALL.num_tasks) == (2, 0)


def test_later_changes_of_the_agents_arrays_do_not_change_the_policy() -> None:
    weights = np.ones((2, 1))
    policy = replace(SMALL, weights=(weights,), biases=(np.zeros(1),))
    weights[:] = np.nan
    assert policy.act(np.ones((1, 2))).tolist() == [[2.0]]


def test_every_field_is_an_array_of_the_file() -> None:
    names = {LAYER_FIELDS.get(field.name, field.name) for field in fields(Policy)}
    assert names | {"format"} == set(KEYS)


@pytest.mark.parametrize(
    ("call", "fact"),
    [
        (lambda: replace(SMALL, head="gaussian").act(SEEN), "The policy samples"),
        (lambda: SMALL.act(np.zeros((1, 5))), "5 values; the policy has 2 inputs"),
        (lambda: replace(SMALL, activation="swish"), "'activation' is 'swish'"),
        (lambda: replace(SMALL, masks=(*(None for _ in SMALL.weights), None)), "3 masks for 2 layers"),
    ],
)
def test_what_cannot_be_done_is_reported(call: Any, fact: str) -> None:
    with pytest.raises(BenchError, match=fact):
        call()


def text(value: str) -> Any:
    return np.frombuffer(value.encode(), np.uint8)


GAUSSIAN = {"head": text("gaussian")}
WRONG: dict[str, tuple[Callable[[Arrays], object], str]] = {
    "a missing layer": (lambda a: (a.pop("weight_0"), a.pop("bias_0")), "'weight_0' is missing"),
    "a missing bias": (lambda a: a.pop("bias_1"), "'bias_1' is missing"),
    "a missing scale of actions": (lambda a: a.pop("action_scale"), "'action_scale' is missing"),
    "a mean alone": (lambda a: a.update(observation_mean=np.zeros(2)), "'observation_scale' is missing"),
    "a scale alone": (lambda a: a.update(observation_scale=np.ones(2)), "'observation_mean' is missing"),
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


GROUP = group("hopper-gravity")


def write_run(folder: Path, protocol: str, policy: Policy = SMALL) -> dict[run_policies.Key, Policy]:
    by_key = dict.fromkeys(run_policies.policy_keys(protocol, GROUP), policy)
    (folder / GROUP.name / protocol).mkdir(parents=True, exist_ok=True)
    run_policies.write_policies(folder / run_file(GROUP.name, protocol, 0, POLICIES), by_key)
    return by_key


def test_the_policies_of_a_run_are_those_of_its_stages_and_in_single_of_its_tasks() -> None:
    assert run_policies.policy_keys("sequential", GROUP) == [(stage, None) for stage in range(6)]
    assert run_policies.policy_keys("joint", GROUP) == [(1, None)]
    assert run_policies.policy_keys("single", GROUP) == [(1, task.name) for task in GROUP.tasks]
    assert [run_policies.prefix(key) for key in ((3, None), (1, "Hopper"))] == ["stage3/", "stage1/Hopper/"]


@pytest.mark.parametrize("protocol", ["sequential", "single", "joint"])
@pytest.mark.parametrize("policy", [SMALL, TASKED, Policy(np.zeros(1), np.ones(1), head="uniform")])
def test_a_file_gives_the_same_policies(tmp_path: Path, protocol: str, policy: Policy) -> None:
    written = write_run(tmp_path, protocol, policy)
    again = run_policies.read_policies(tmp_path, GROUP, protocol, 0)
    assert list(again) == list(written)
    for one in again.values():
        rngs = (np.random.default_rng(1), np.random.default_rng(1))
        assert np.array_equal(policy.act(SEEN, rngs[0]), one.act(SEEN, rngs[1]))
    assert run_policies.has_policies(tmp_path, GROUP, protocol, 0)
    assert not run_policies.has_policies(tmp_path, GROUP, protocol, 1)


def test_the_digest_is_that_of_the_content_and_not_of_the_packing() -> None:
    arrays = run_policies.run_arrays({(1, None): SMALL})
    digest = run_policies.content_sha256(arrays)
    assert run_policies.content_sha256(run_policies.npz_arrays(run_policies.npz_bytes(arrays))) == digest
    assert run_policies.content_sha256(dict(reversed(arrays.items()))) == digest
    fortran = {name: np.asfortranarray(values) for name, values in arrays.items()}
    assert (
        run_policies.content_sha256(
            {name: fortran[name].reshape(values.shape) for name, values in arrays.items()}
        )
        == digest
    )
    for change in (
        {"stage1/bias_0": arrays["stage1/bias_0"] + 1},
        {"stage1/bias_0": arrays["stage1/bias_0"].astype(np.float64)},
        {"stage1/bias_0": arrays["stage1/bias_0"].reshape(1, -1)},
        {"stage2/bias_0": arrays["stage1/bias_0"]},
    ):
        assert run_policies.content_sha256(arrays | change) != digest


@pytest.mark.parametrize(
    ("data", "fact"),
    [
        (b"not a zip", "cannot be read"),
        (arrays(a=[{}]), "allow_pickle"),
        (run_policies.npz_bytes({"a": np.zeros(MAX_POLICY_BYTES // 8 + 1)}), "unpacks to"),
        (run_policies.npz_bytes(SMALL.arrays())[:-40], "cannot be read"),
    ],
    ids=["no archive", "a pickle", "a bomb", "cut"],
)
def test_a_file_that_is_no_archive_of_numbers_is_refused(data: bytes, fact: str) -> None:
    with pytest.raises(BenchError, match=fact):
        run_policies.npz_arrays(data)


def test_missing_and_foreign_policies_are_named(tmp_path: Path) -> None:
    content = run_policies.run_arrays(write_run(tmp_path, "sequential"))
    less = {name: values for name, values in content.items() if not name.startswith("stage2/")}
    assert list(run_policies.run_errors(less, GROUP, "sequential")) == ["The policy of stage2 is missing."]
    assert "stage7/head" in next(
        run_policies.run_errors(content | {"stage7/head": np.zeros(1)}, GROUP, "sequential")
    )
    with pytest.raises(BenchError, match="stage2"):
        run_policies.policies_of(less, GROUP, "sequential")
    with pytest.raises(BenchError, match="No such file"):
        run_policies.read_policies(tmp_path, GROUP, "sequential", 5)
