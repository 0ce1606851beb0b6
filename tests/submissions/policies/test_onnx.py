"""A policy as an ONNX network: which files are refused and why, and how it acts."""

import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

pytest.importorskip("onnx", reason="needs the extra onnx")
pytest.importorskip("onnxruntime", reason="needs the extra onnx")

import onnx

from gym_extensions.errors import BenchError
from gym_extensions.submissions import layout
from gym_extensions.submissions.policies.diagnostics import diagnose
from gym_extensions.submissions.policies.onnx import MISSING, OnnxPolicy, network_errors

from ...conftest import refused
from .networks import FLOAT, endless, graph, model, value

node, tensor = onnx.helper.make_node, onnx.numpy_helper.from_array


def named(name: str, width: int | str = 3, kind: int = FLOAT, batch: int | str = "batch") -> Any:
    """An input or output with this number of values per row."""
    return value(name, kind, [batch, width])


def linear(**changes: Any) -> bytes:
    """A network that gives the first two of three observations as actions."""
    values: dict[str, Any] = {
        "nodes": [node("MatMul", ["observation", "weights"], ["action"])],
        "inputs": [named("observation")],
        "outputs": [named("action", 2)],
        "constants": [tensor(np.eye(3, 2, dtype=np.float32), "weights")],
    }
    return model(graph(**values | changes))


def test_it_acts_on_one_observation_and_on_many() -> None:
    policy = OnnxPolicy(linear())
    assert policy.act(np.array([1.0, 2.0, 3.0])).tolist() == [1, 2]
    assert policy.act(np.ones((4, 3))).shape == (4, 2)
    assert (policy.num_inputs, policy.num_actions, policy.num_tasks) == (3, 2, 0)
    assert policy.head == "deterministic"


def test_a_state_starts_at_zero_and_goes_on_until_it_is_reset() -> None:
    counter = linear(  # the state counts steps; the action is the observation plus the state
        nodes=[
            node("Add", ["state", "one"], ["next_state"]),
            node("Add", ["observation", "state"], ["action"]),
        ],
        inputs=[named("observation"), named("state", 1)],
        outputs=[named("action"), named("next_state", 1)],
        constants=[tensor(np.ones(1, np.float32), "one")],
    )
    policy = OnnxPolicy(counter)
    steps = [policy.act(np.zeros((2, 3)))[0, 0] for _ in range(3)]
    with pytest.raises(BenchError, match="Call reset"):
        policy.act(np.zeros((1, 3)))
    policy.reset()
    assert [*steps, policy.act(np.zeros(3))[0]] == [0, 1, 2, 0]


def test_its_weights_are_tensors_of_two_or_more_dimensions() -> None:
    weights = np.array([[1.0, np.nan], [2.0, 3.0], [4.0, 5.0]], np.float32)
    constants = [tensor(weights, "w"), tensor(np.array([7.0, 7.0], np.float32), "b")]
    nodes = [node("Gemm", ["observation", "w", "b"], ["action"])]
    assert OnnxPolicy(linear(nodes=nodes, constants=constants)).flat_weights().tolist() == [1, 0, 2, 3, 4, 5]


def test_noise_comes_from_the_generator_and_the_task_is_its_index() -> None:
    policy = OnnxPolicy(
        linear(
            nodes=[
                node("Cast", ["task"], ["number"], to=FLOAT),
                node("Unsqueeze", ["number", "axis"], ["column"]),
                node("Add", ["noise", "column"], ["action"]),
            ],
            inputs=[
                *(named("observation"), named("noise", 2)),
                value("task", onnx.TensorProto.INT64, ["batch"]),
            ],
            constants=[tensor(np.array([1]), "axis")],
        )
    )
    assert (policy.head, policy.num_tasks) == ("gaussian", 1)
    expected = 4 + np.random.default_rng(0).standard_normal((1, 2), np.float32)
    np.testing.assert_array_equal(policy.act(np.zeros((1, 3)), np.random.default_rng(0), 4), expected)
    with pytest.raises(BenchError, match="Pass rng"):
        policy.act(np.zeros((1, 3)))


def external() -> bytes:
    weights = tensor(np.eye(3, 2, dtype=np.float32), "weights")
    onnx.external_data_helper.set_external_data(weights, "/etc/passwd")
    return linear(constants=[weights])


def broken(kind: int, **content: Any) -> bytes:
    """A network with a tensor (1, 2) of this content."""
    odd = onnx.TensorProto(name="s", data_type=kind, dims=[1, 2], **content)
    return linear(constants=[tensor(np.eye(3, 2, dtype=np.float32), "weights"), odd])


def doing(operator: str, domain: str = "", inputs: int = 1, **attributes: Any) -> bytes:
    nodes = [node(operator, ["observation"] * inputs, ["action"], domain=domain, **attributes)]
    return linear(nodes=nodes, outputs=[named("action")])


def given(*inputs: Any) -> bytes:
    return linear(inputs=inputs)


STRING = onnx.TensorProto.STRING
TEXT = named("observation", kind=STRING)
REFUSED: dict[str, tuple[Callable[[], bytes], str]] = {
    "no ONNX": (lambda: b"\x0a\xff\xff", "not an ONNX model"),
    "no graph": (lambda: b"", "'observation' is missing"),
    "unknown operator": (lambda: doing("RandomNormalLike"), "RandomNormalLike"),
    "operator of a library": (lambda: doing("Gelu", "com.mine"), "com.mine.Gelu"),
    "operator in a loop": (lambda: endless(3, 3).replace(b"Identity", b"PyFunkyX"), "PyFunkyX"),
    "data elsewhere": (external, "another file"),
    "text as weights": (lambda: broken(STRING, string_data=[b"x", b"y"]), "'s' cannot be read as numbers"),
    "too few weights": (lambda: broken(FLOAT, raw_data=b"1234"), "'s' cannot be read as numbers"),
    "dynamic observation": (
        lambda: given(named("observation", "width")),
        "'observation' has a dynamic shape",
    ),
    "fixed batch": (lambda: given(named("observation", batch=20)), "must be 1 or symbolic; export it"),
    "unknown input": (lambda: given(named("observation"), named("clock")), "Unexpected input 'clock'"),
    "no next state": (lambda: given(named("observation"), named("state")), "'next_state' is missing"),
    "text": (lambda: given(TEXT), "another type"),
    "opset": (lambda: model(graph([], [], []), opset=9), "The opset is 9"),
}


def error_of(data: bytes) -> str:
    return next(iter(network_errors(data)), "")


@pytest.mark.parametrize("case", REFUSED)
def test_what_a_network_may_not_contain_is_named(case: str) -> None:
    data, fact = REFUSED[case]
    assert fact in error_of(data())
    with pytest.raises(BenchError, match=r"docs/policies\.md"):
        OnnxPolicy(data())


def through_a_state() -> bytes:
    """The action is what any episode saw a step before; the state holds it times a ten-thousandth."""
    return linear(
        nodes=[
            node("Transpose", ["observation"], ["columns"], perm=[1, 0]),
            node("ReduceMax", ["columns"], ["most"], keepdims=0, axes=[1]),
            node("Mul", ["observation", "zero"], ["rows"]),
            node("Mul", ["most", "small"], ["hidden"]),
            node("Add", ["rows", "hidden"], ["next_state"]),
            node("Mul", ["state", "large"], ["action"]),
        ],
        inputs=[named("observation"), named("state")],
        outputs=[named("action"), named("next_state")],
        constants=[
            tensor(np.array(number, np.float32), name)
            for name, number in {"zero": 0, "small": 1e-4, "large": 1e4}.items()
        ],
    )


def in_groups_of_ten() -> bytes:
    nodes = [
        node("Reshape", ["observation", "groups"], ["grouped"]),
        node("ReduceMax", ["grouped"], ["most"], axes=[1]),
        node("Add", ["grouped", "most"], ["sums"]),
        node("Reshape", ["sums", "rows"], ["action"]),
    ]
    shapes = [tensor(np.array([-1, 10, 3]), "groups"), tensor(np.array([-1, 3]), "rows")]
    return linear(nodes=nodes, outputs=[named("action")], constants=shapes)


def by_a_maximum() -> bytes:
    nodes = [
        node("ReduceMax", ["observation"], ["most"], axes=[0]),
        node("Add", ["observation", "most"], ["action"]),
    ]
    return linear(nodes=nodes, outputs=[named("action")])


@pytest.mark.parametrize("data", [by_a_maximum, through_a_state])
def test_what_an_episode_sees_changes_no_action_of_another_one(data: Callable[[], bytes]) -> None:
    policies, seen = [OnnxPolicy(data()) for _ in range(2)], np.ones((20, 3))
    other = seen + 5 * (np.arange(20) == 3)[:, None]
    for _ in range(2):
        actions, others = (policy.act(each) for policy, each in zip(policies, (seen, other), strict=True))
    assert np.flatnonzero((actions != others).any(axis=1)).tolist() == [3]


@pytest.mark.parametrize(
    ("data", "why"),
    [
        (in_groups_of_ten, "Reshape"),
        (lambda: doing("Concat", inputs=2, axis=0), "cannot reshape array of size 6"),
    ],
    ids=["it needs other rows", "it gives other rows"],
)
def test_a_network_that_fails_for_one_episode_is_named(data: Callable[[], bytes], why: str) -> None:
    with pytest.raises(BenchError, match=f"The network failed: .*{why}"):
        OnnxPolicy(data()).act(np.zeros((20, 3)))


def test_a_file_may_state_a_batch_of_one() -> None:
    data = linear(inputs=[named("observation", batch=1)], outputs=[named("action", 2, batch=1)])
    assert OnnxPolicy(data).act(np.ones((4, 3))).tolist() == [[1, 1]] * 4


def test_a_file_beyond_the_limit_is_not_parsed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(layout.MAX_FILE_BYTES, layout.NETWORK, 10)
    assert "the limit is 10" in error_of(linear())


def test_a_network_that_never_ends_is_stopped(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gym_extensions.submissions.policies.onnx.MAX_STEP_SECONDS", 0.2)
    with pytest.raises(BenchError, match=r"took more than 0\.2 seconds"):
        OnnxPolicy(endless(3, 3)).act(np.zeros((1, 3)))


def test_without_the_extra_the_error_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    data = linear()
    monkeypatch.setitem(sys.modules, "onnx", None)
    with refused(MISSING, "pip install 'gym-extensions[onnx]'"):
        OnnxPolicy(data)


def test_the_diagnosis_of_a_network_has_its_size_and_refuses_unfit_observations() -> None:
    policy = OnnxPolicy(linear())
    found = diagnose([policy, policy], [np.zeros((4, 3))])
    assert [(each.parameters, each.distances) for each in found] == [(6, ()), (6, (0.0,))]
    assert {each.ranks for each in found} == {None}
    with pytest.raises(BenchError, match=r"The observations have 5 values; the policy has 3 inputs\."):
        diagnose([policy], [np.zeros((4, 5))])
