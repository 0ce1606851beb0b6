"""A policy as an ONNX network: which files are refused and why, and how it acts."""

import sys
from collections.abc import Callable, Sequence
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


def doing(operator: str, domain: str = "") -> bytes:
    return linear(nodes=[node(operator, ["observation"], ["action"], domain=domain)])


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
    "fixed batch": (lambda: given(named("observation", batch=1)), "has no batch"),
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


def talking(axes: Sequence[int] | None, *, as_input: bool = False) -> bytes:
    """A network whose actions are a maximum over these axes, or all, added to the observation."""
    stated = {} if as_input or axes is None else {"axes": list(axes)}
    names = ["observation", *(["axes"] if as_input else [])]
    return linear(
        nodes=[
            node("ReduceSum" if as_input else "ReduceMax", names, ["most"], keepdims=1, **stated),
            node("Add", ["observation", "most"], ["action"]),
        ],
        outputs=[named("action")],
        constants=[tensor(np.array(axes), "axes")] if as_input else [],
    )


@pytest.mark.parametrize("as_input", [False, True])
def test_a_reduction_over_the_batch_is_refused_and_others_are_not(as_input: bool) -> None:
    for axes in ([0], [1, 0]) if as_input else ([0], [0, 1], None):
        assert "reduces axis 0, the batch" in error_of(talking(axes, as_input=as_input))
    assert OnnxPolicy(talking([1], as_input=as_input)).act(np.ones((4, 3))).shape == (4, 3)


@pytest.mark.parametrize(
    ("stated", "is_refused"),
    [
        ({"value": tensor(np.array([1]))}, False),
        ({"value_ints": [1]}, False),
        ({"value_int": 1}, False),
        ({"value_ints": [0, 1]}, True),
        ({}, True),
    ],
)
def test_axes_may_be_a_constant_of_any_kind(stated: dict[str, Any], is_refused: bool) -> None:
    axes = node("Constant", [], ["axes"], **stated)
    least = node("ReduceSum", ["observation", "axes"], ["action"], keepdims=1)
    error = error_of(linear(nodes=[axes, least], outputs=[named("action", 1)], constants=[]))
    assert ("reduces axis 0, the batch" in error) == is_refused
    assert bool(error) == is_refused


def with_constant(operator: str, name: str, values: Any) -> OnnxPolicy:
    """The policy that applies an operator to the observation and a constant."""
    nodes = [node(operator, ["observation", name], ["action"])]
    return OnnxPolicy(
        linear(nodes=nodes, outputs=[named("action")], constants=[tensor(np.array(values), name)])
    )


def test_a_network_whose_rows_see_each_other_in_another_way_is_refused() -> None:
    policy = with_constant("CumSum", "axis", 0)
    assert policy.act(np.zeros((4, 3))).tolist() == np.zeros((4, 3)).tolist()
    with pytest.raises(BenchError, match="another one of the batch"):
        policy.act(np.ones((4, 3)))


def test_a_network_that_fails_is_named() -> None:
    with pytest.raises(BenchError, match=r"The network failed: .*Reshape"):
        with_constant("Reshape", "shape", [7, 7]).act(np.zeros((1, 3)))


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
