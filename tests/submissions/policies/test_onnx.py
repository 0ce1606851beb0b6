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
from gym_extensions.submissions.diagnostics import diagnose
from gym_extensions.submissions.policies.onnx import MISSING, OnnxPolicy, network_errors

from ...conftest import refused
from .networks import FLOAT, endless, graph, model, value

BATCH = "batch"


def error_of(data: bytes) -> str:
    return next(iter(network_errors(data)), "")


def linear(**changes: Any) -> bytes:
    """A network that gives the first two of three observations as actions."""
    weights = onnx.numpy_helper.from_array(np.eye(3, 2, dtype=np.float32), "weights")
    node = onnx.helper.make_node("MatMul", ["observation", "weights"], ["action"])
    values: dict[str, Any] = {
        "nodes": [node],
        "inputs": [value("observation", FLOAT, [BATCH, 3])],
        "outputs": [value("action", FLOAT, [BATCH, 2])],
        "constants": [weights],
    }
    return model(graph(**values | changes))


def counter() -> bytes:
    """A network whose state counts steps; the action is the observation plus the state."""
    one = onnx.numpy_helper.from_array(np.ones(1, np.float32), "one")
    return linear(
        nodes=[
            onnx.helper.make_node("Add", ["state", "one"], ["next_state"]),
            onnx.helper.make_node("Add", ["observation", "state"], ["action"]),
        ],
        inputs=[value("observation", FLOAT, [BATCH, 3]), value("state", FLOAT, [BATCH, 1])],
        outputs=[value("action", FLOAT, [BATCH, 3]), value("next_state", FLOAT, [BATCH, 1])],
        constants=[one],
    )


def test_it_acts_on_one_observation_and_on_many() -> None:
    policy = OnnxPolicy(linear())
    assert policy.act(np.array([1.0, 2.0, 3.0])).tolist() == [1, 2]
    assert policy.act(np.ones((4, 3))).shape == (4, 2)
    assert (policy.num_inputs, policy.num_actions, policy.num_tasks, policy.head) == (
        3,
        2,
        0,
        "deterministic",
    )


def test_a_state_starts_at_zero_and_goes_on_until_it_is_reset() -> None:
    policy = OnnxPolicy(counter())
    steps = [policy.act(np.zeros((2, 3)))[0, 0] for _ in range(3)]
    with pytest.raises(BenchError, match="Call reset"):
        policy.act(np.zeros((1, 3)))
    policy.reset()
    assert [*steps, policy.act(np.zeros(3))[0]] == [0, 1, 2, 0]


def test_its_weights_are_tensors_of_two_or_more_dimensions() -> None:
    constants = [
        onnx.numpy_helper.from_array(np.array([[1.0, np.nan], [2.0, 3.0], [4.0, 5.0]], np.float32), "w"),
        onnx.numpy_helper.from_array(np.array([7.0, 7.0], np.float32), "b"),
    ]
    nodes = [onnx.helper.make_node("Gemm", ["observation", "w", "b"], ["action"])]
    assert OnnxPolicy(linear(nodes=nodes, constants=constants)).flat_weights().tolist() == [1, 0, 2, 3, 4, 5]


def test_noise_comes_from_the_generator_and_the_task_is_its_index() -> None:
    policy = OnnxPolicy(
        linear(
            nodes=[
                onnx.helper.make_node("Cast", ["task"], ["number"], to=FLOAT),
                onnx.helper.make_node("Unsqueeze", ["number", "axis"], ["column"]),
                onnx.helper.make_node("Add", ["noise", "column"], ["action"]),
            ],
            inputs=[
                value("observation", FLOAT, [BATCH, 3]),
                value("noise", FLOAT, [BATCH, 2]),
                value("task", onnx.TensorProto.INT64, [BATCH]),
            ],
            constants=[onnx.numpy_helper.from_array(np.array([1]), "axis")],
        )
    )
    assert (policy.head, policy.num_tasks) == ("gaussian", 1)
    expected = 4 + np.random.default_rng(0).standard_normal((1, 2), np.float32)
    np.testing.assert_array_equal(policy.act(np.zeros((1, 3)), np.random.default_rng(0), 4), expected)
    with pytest.raises(BenchError, match="Pass rng"):
        policy.act(np.zeros((1, 3)))


def external() -> bytes:
    tensor = onnx.numpy_helper.from_array(np.eye(3, 2, dtype=np.float32), "weights")
    onnx.external_data_helper.set_external_data(tensor, "/etc/passwd")
    return linear(constants=[tensor])


REFUSED: dict[str, tuple[Callable[[], bytes], str]] = {
    "no ONNX": (lambda: b"\x0a\xff\xff", "not an ONNX model"),
    "no graph": (lambda: b"", "'observation' is missing"),
    "unknown operator": (
        lambda: linear(nodes=[onnx.helper.make_node("RandomNormalLike", ["observation"], ["action"])]),
        "RandomNormalLike",
    ),
    "operator of a library": (
        lambda: linear(nodes=[onnx.helper.make_node("Gelu", ["observation"], ["action"], domain="com.mine")]),
        "com.mine.Gelu",
    ),
    "operator in a loop": (lambda: endless(3, 3).replace(b"Identity", b"PyFunkyX"), "PyFunkyX"),
    "data elsewhere": (external, "another file"),
    "dynamic observation": (
        lambda: linear(inputs=[value("observation", FLOAT, [BATCH, "width"])]),
        "'observation' has a dynamic shape",
    ),
    "fixed batch": (lambda: linear(inputs=[value("observation", FLOAT, [1, 3])]), "has no batch"),
    "unknown input": (
        lambda: linear(inputs=[value("observation", FLOAT, [BATCH, 3]), value("clock", FLOAT, [BATCH, 1])]),
        "Unexpected input 'clock'",
    ),
    "state without next": (
        lambda: linear(inputs=[value("observation", FLOAT, [BATCH, 3]), value("state", FLOAT, [BATCH, 4])]),
        "'next_state' is missing",
    ),
    "text": (
        lambda: linear(inputs=[value("observation", onnx.TensorProto.STRING, [BATCH, 3])]),
        "another type",
    ),
    "opset": (lambda: model(graph([], [], []), opset=9), "The opset is 9"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_a_network_may_not_contain_is_named(case: str) -> None:
    data, named = REFUSED[case]
    assert named in error_of(data())
    with pytest.raises(BenchError, match=r"docs/policies\.md"):
        OnnxPolicy(data())


def talking(axes: Sequence[int] | None, *, as_input: bool = False) -> bytes:
    """A network whose actions are a maximum over these axes, or all, added to the observation."""
    stated = {} if as_input or axes is None else {"axes": list(axes)}
    kind = "ReduceSum" if as_input else "ReduceMax"
    constants = [onnx.numpy_helper.from_array(np.array(axes), "axes")] if as_input else []
    names = ["observation", *(["axes"] if as_input else [])]
    nodes = [
        onnx.helper.make_node(kind, names, ["most"], keepdims=1, **stated),
        onnx.helper.make_node("Add", ["observation", "most"], ["action"]),
    ]
    shape = [value("observation", FLOAT, [BATCH, 3])], [value("action", FLOAT, [BATCH, 3])]
    return model(graph(nodes, *shape, constants))


@pytest.mark.parametrize("as_input", [False, True])
def test_a_reduction_over_the_batch_is_refused_and_others_are_not(as_input: bool) -> None:
    for axes in ([0], [1, 0]) if as_input else ([0], [0, 1], None):
        assert "reduces axis 0, the batch" in error_of(talking(axes, as_input=as_input))
    assert OnnxPolicy(talking([1], as_input=as_input)).act(np.ones((4, 3))).shape == (4, 3)


def test_a_network_whose_rows_see_each_other_in_another_way_is_refused() -> None:
    nodes = [
        onnx.helper.make_node("CumSum", ["observation", "axis"], ["action"])  # row by row
    ]
    constants = [onnx.numpy_helper.from_array(np.array(0), "axis")]
    shape = [value("observation", FLOAT, [BATCH, 3])], [value("action", FLOAT, [BATCH, 3])]
    policy = OnnxPolicy(model(graph(nodes, *shape, constants)))
    assert policy.act(np.zeros((4, 3))).tolist() == np.zeros((4, 3)).tolist()
    with pytest.raises(BenchError, match="another one of the batch"):
        policy.act(np.ones((4, 3)))


def test_a_file_beyond_the_limit_is_not_parsed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(layout.MAX_FILE_BYTES, layout.NETWORK, 10)
    assert "the limit is 10" in error_of(linear())


def test_a_network_that_never_ends_is_stopped(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gym_extensions.submissions.policies.onnx.MAX_STEP_SECONDS", 0.2)
    with pytest.raises(BenchError, match=r"took more than 0\.2 seconds"):
        OnnxPolicy(endless(3, 3)).act(np.zeros((1, 3)))


def test_a_network_that_fails_is_named() -> None:
    shape = onnx.numpy_helper.from_array(np.array([7, 7]), "shape")
    node = onnx.helper.make_node("Reshape", ["observation", "shape"], ["action"])
    with pytest.raises(BenchError, match=r"The network failed: .*Reshape"):
        OnnxPolicy(linear(nodes=[node], constants=[shape])).act(np.zeros((1, 3)))


def test_without_the_extra_the_error_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    data = linear()
    monkeypatch.setitem(sys.modules, "onnx", None)
    with refused(MISSING, "pip install 'gym-extensions[onnx]'"):
        OnnxPolicy(data)


def test_the_diagnosis_of_a_network_has_its_size_and_refuses_unfit_observations() -> None:
    policy = OnnxPolicy(linear())
    found = diagnose([policy, policy], [np.zeros((4, 3))])
    assert [(each.parameters, each.distances, each.ranks) for each in found] == [
        (6, (), None),
        (6, (0.0,), None),
    ]
    with pytest.raises(BenchError, match=r"The observations have 5 values; the policy has 3 inputs\."):
        diagnose([policy], [np.zeros((4, 5))])
