"""Small ONNX models for tests; imported where the extra ``onnx`` is installed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

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
