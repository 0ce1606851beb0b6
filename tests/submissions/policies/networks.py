"""Small ONNX models for tests; imported where the extra ``onnx`` is installed."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import onnx

FLOAT = onnx.TensorProto.FLOAT


def value(name: str, kind: int, shape: Sequence[int | str]) -> Any:
    """The description of an input or output."""
    return onnx.helper.make_tensor_value_info(name, kind, shape)


def graph(nodes: Sequence[Any], inputs: Sequence[Any], outputs: Sequence[Any], constants: Any = ()) -> Any:
    """A graph."""
    return onnx.helper.make_graph(nodes, "graph", inputs, outputs, list(constants))


def model(content: Any, opset: int = 17) -> bytes:
    """The bytes of a model."""
    made = onnx.helper.make_model(content, opset_imports=[onnx.helper.make_opsetid("", opset)], ir_version=8)
    return bytes(made.SerializeToString())


def endless(inputs: int, actions: int) -> bytes:
    """A linear network, then a loop of 2⁶² rounds."""
    integer, truth = onnx.TensorProto.INT64, onnx.TensorProto.BOOL
    node = onnx.helper.make_node
    body = graph(
        [node("Identity", ["goes_on"], ["still"]), node("Identity", ["x"], ["y"])],
        [value("round", integer, []), value("goes_on", truth, []), value("x", FLOAT, ["batch", actions])],
        [value("still", truth, []), value("y", FLOAT, ["batch", actions])],
    )
    constants = [
        onnx.helper.make_tensor("rounds", integer, [], [2**62]),
        onnx.helper.make_tensor("yes", truth, [], [True]),
        onnx.numpy_helper.from_array(np.eye(inputs, actions, dtype=np.float32), "weights"),
    ]
    nodes = [
        node("MatMul", ["observation", "weights"], ["start"]),
        node("Loop", ["rounds", "yes", "start"], ["action"], body=body),
    ]
    whole = [value("observation", FLOAT, ["batch", inputs])], [value("action", FLOAT, ["batch", actions])]
    return model(graph(nodes, *whole, constants))
