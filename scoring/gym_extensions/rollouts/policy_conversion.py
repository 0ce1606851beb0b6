"""Converts policies: plain arrays to a PyTorch module or an ONNX network, and a module to a network."""

from __future__ import annotations

import io
import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gym_extensions.errors import BenchError
from gym_extensions.rollouts.onnx_policy import OnnxPolicy, required
from gym_extensions.rollouts.policy_arrays import LEAK, Array, Arrays, key_of, text_of

if TYPE_CHECKING:
    import torch

OPSET, IR_VERSION = 17, 8
"""Of the networks that are written: old enough for every runtime that is supported."""
BUFFERS = (
    *("observation_mean", "observation_scale", "action_offset", "action_scale"),
    *("log_sigma", "log_sigma_weight", "log_sigma_clip"),
)
"""The arrays of a policy that a module does not train."""


def _of_task(arrays: Arrays, task: int) -> dict[str, Any]:
    """The arrays of one task, with masks applied, and the layers as pairs; names as text."""
    chosen: dict[str, Any] = {}
    for name, values in arrays.items():
        key = key_of(name)
        assert key is not None, "the policy checked its arrays"
        has_rows = key.has_tasks and values.ndim > len(key.shape)
        row = values[min(task, len(values) - 1)] if has_rows else values
        chosen[name] = text_of(row) if key.kind == "name" else row
    layers = sum(name.startswith("weight_") for name in chosen)
    if not layers or chosen["head"] == "uniform":
        message = "The policy is uniform." if chosen["head"] == "uniform" else "The policy has no layers."
        raise BenchError("unsupported-policy", message, "policy", "Only a policy with layers is converted.")
    for layer in range(layers):
        if f"mask_{layer}" in chosen:
            chosen[f"weight_{layer}"] = chosen[f"weight_{layer}"] * chosen[f"mask_{layer}"]
    chosen["layers"] = [(chosen[f"weight_{layer}"], chosen[f"bias_{layer}"]) for layer in range(layers)]
    return chosen


def torch_module(arrays: Arrays, task: int) -> torch.nn.Module:
    """See :meth:`gym_extensions.rollouts.policy.Policy.to_torch`."""
    try:
        import torch
    except ImportError as error:
        raise BenchError("missing-extra", "to_torch() needs torch.", hint="Run: pip install torch") from error
    functional = torch.nn.functional
    activations: dict[str, Any] = {
        "linear": lambda values: values,
        "tanh": torch.tanh,
        "relu": functional.relu,
        "leaky_relu": lambda values: functional.leaky_relu(values, LEAK),
        "elu": functional.elu,
        "silu": functional.silu,
    }
    parts = _of_task(arrays, task)

    class PolicyModule(torch.nn.Module):
        """Actions (…, a) from observations (…, o); the mean without noise (…, a)."""

        def __init__(self) -> None:
            super().__init__()
            self.layers = torch.nn.ModuleList()
            for weights, biases in parts["layers"]:
                layer = torch.nn.Linear(*weights.shape).to(torch.from_numpy(weights).dtype)
                layer.load_state_dict({"weight": torch.tensor(weights.T), "bias": torch.tensor(biases)})
                self.layers.append(layer)
            for name in BUFFERS:
                if name in parts:
                    self.register_buffer(name, torch.tensor(parts[name]))

        def forward(self, observation: torch.Tensor, noise: torch.Tensor | None = None) -> torch.Tensor:
            own: Any = self
            values = observation.to(getattr(torch, parts["observation_dtype"]))
            if "observation_mean" in parts:
                values = (values - own.observation_mean) / own.observation_scale
            if "observation_clip" in parts:
                bound = float(parts["observation_clip"])
                values = values.clamp(-bound, bound)
            values = values.to(own.layers[0].weight.dtype)
            for layer in own.layers[:-1]:
                values = activations[parts["activation"]](layer(values))
            mean = activations[parts["output_activation"]](own.layers[-1](values))
            if noise is not None and parts["head"] == "gaussian":
                log_sigma = own.log_sigma
                if "log_sigma_weight" in parts:
                    log_sigma = values @ own.log_sigma_weight + log_sigma
                if "log_sigma_clip" in parts:
                    log_sigma = log_sigma.clamp(*own.log_sigma_clip)
                mean = mean + log_sigma.exp() * noise
            action: torch.Tensor = own.action_offset + own.action_scale * activations[parts["squash"]](mean)
            return action

    return PolicyModule()


class _Graph:
    """Collects the nodes and constants of a network."""

    def __init__(self, onnx: Any) -> None:
        self._onnx = onnx
        self.nodes: list[Any] = []
        self.constants: list[Any] = []

    def put(self, operator: str, *inputs: str | Array, **attributes: Any) -> str:
        """Adds a node, and returns the name of its output."""
        names = [each if isinstance(each, str) else self._constant(each) for each in inputs]
        output = f"value_{len(self.nodes)}"
        self.nodes.append(self._onnx.helper.make_node(operator, names, [output], **attributes))
        return output

    def _constant(self, values: Array) -> str:
        name = f"constant_{len(self.constants)}"
        self.constants.append(self._onnx.numpy_helper.from_array(np.ascontiguousarray(values), name))
        return name

    def cast(self, value: str, dtype: np.dtype[Any]) -> str:
        """A value as another type."""
        return self.put("Cast", value, to=self._onnx.helper.np_dtype_to_tensor_dtype(dtype))

    def clip(self, value: str | Array, low: Any, high: Any, dtype: np.dtype[Any]) -> str:
        """A value within bounds."""
        return self.put("Min", self.put("Max", value, np.array(low, dtype)), np.array(high, dtype))

    def activation(self, name: str, value: str, dtype: np.dtype[Any]) -> str:
        """An activation of a policy, from operators that know both types of numbers."""
        zero, one, leak = (np.array(number, dtype) for number in (0, 1, LEAK))
        if name == "tanh":
            return self.put("Tanh", value)
        if name == "relu":
            return self.put("Max", value, zero)
        if name == "leaky_relu":
            return self.put("Max", value, self.put("Mul", value, leak))
        if name == "silu":
            return self.put("Mul", value, self.put("Sigmoid", value))
        if name == "elu":
            below = self.put("Sub", self.put("Exp", self.put("Min", value, zero)), one)
            return self.put("Where", self.put("Greater", value, zero), value, below)
        return value


def onnx_bytes(arrays: Arrays, task: int) -> bytes:
    """See :meth:`gym_extensions.rollouts.policy.Policy.to_onnx`."""
    onnx, parts = required("onnx"), _of_task(arrays, task)
    graph, inner = _Graph(onnx), parts["layers"][0][0].dtype
    inputs, outputs = parts["layers"][0][0].shape[0], len(parts["action_offset"])
    seen = np.dtype(parts["observation_dtype"])
    value, dtype = "observation", seen
    if "observation_mean" in parts:
        mean, scale = parts["observation_mean"], parts["observation_scale"]
        dtype = np.result_type(dtype, mean, scale)
        value = graph.put("Sub", graph.cast(value, dtype), mean.astype(dtype))
        value = graph.put("Div", value, scale.astype(dtype))
    if "observation_clip" in parts:
        bound = float(parts["observation_clip"])
        value = graph.clip(value, -bound, bound, dtype)
    value = graph.cast(value, inner)
    for weights, biases in parts["layers"][:-1]:
        value = graph.put("Add", graph.put("MatMul", value, weights), biases.astype(inner))
        value = graph.activation(parts["activation"], value, inner)
    weights, biases = parts["layers"][-1]
    mean = graph.put("Add", graph.put("MatMul", value, weights), biases.astype(inner))
    mean = graph.activation(parts["output_activation"], mean, inner)
    has_noise = parts["head"] == "gaussian"
    if has_noise:
        log_sigma: str | Array = parts["log_sigma"].astype(inner)
        if "log_sigma_weight" in parts:
            product = graph.put("MatMul", value, parts["log_sigma_weight"].astype(inner))
            log_sigma = graph.put("Add", product, log_sigma)
        if "log_sigma_clip" in parts:
            low, high = parts["log_sigma_clip"].tolist()
            log_sigma = graph.clip(log_sigma, low, high, inner)
        mean = graph.put("Add", mean, graph.put("Mul", graph.put("Exp", log_sigma), "noise"))
    result = np.result_type(inner, parts["action_offset"], parts["action_scale"])
    squashed = graph.cast(graph.activation(parts["squash"], mean, inner), result)
    scaled = graph.put("Mul", squashed, parts["action_scale"].astype(result))
    action = graph.put("Add", scaled, parts["action_offset"].astype(result))
    graph.nodes.append(onnx.helper.make_node("Identity", [action], ["action"]))

    def described(name: str, kind: np.dtype[Any], size: int) -> Any:
        number = onnx.helper.np_dtype_to_tensor_dtype(kind)
        return onnx.helper.make_tensor_value_info(name, number, ["batch", size])

    read = [described("observation", seen, inputs)]
    read += [described("noise", inner, outputs)] if has_noise else []
    made = onnx.helper.make_graph(
        graph.nodes, "policy", read, [described("action", result, outputs)], graph.constants
    )
    opsets = [onnx.helper.make_opsetid("", OPSET)]
    model = onnx.helper.make_model(made, opset_imports=opsets, ir_version=IR_VERSION)
    data: bytes = model.SerializeToString()
    return data


def from_torch(
    module: torch.nn.Module,
    observation_shape: Sequence[int],
    *,
    state_shape: Sequence[int] | None = None,
    noise: int = 0,
    dtype: str = "float32",
) -> OnnxPolicy:
    """The policy of a PyTorch module as an ONNX network.

    The module maps observations (k, …), then noise (k, m) if there is any, then the state (k, …) if there is
    one, to actions (k, a); with a state it returns actions and the next state.

    Args:
        module: the network.
        observation_shape: of one observation.
        state_shape: of the state of one episode; None without.
        noise: the number of standard normal numbers that the module reads, for a policy that samples.
        dtype: of observations: float32, float64 or uint8.

    Raises:
        BenchError: the module cannot be exported, or has an operator that is not allowed.

    Example:
        >>> module = torch.nn.Sequential(torch.nn.Linear(11, 3), torch.nn.Tanh())
        >>> from_torch(module, (11,)).act(np.zeros(11)).shape  # doctest: +SKIP
        (3,)
    """
    import torch

    inputs = {"observation": torch.zeros((2, *observation_shape), dtype=getattr(torch, dtype))}
    outputs = ["action"]
    if noise:
        inputs["noise"] = torch.zeros((2, noise))
    if state_shape is not None:
        inputs["state"] = torch.zeros((2, *state_shape))
        outputs.append("next_state")
    onnx = required("onnx")
    file, fast = io.BytesIO(), torch.backends.mha.get_fastpath_enabled()
    torch.backends.mha.set_fastpath_enabled(False)  # fused attention has no operator in ONNX
    try:
        with warnings.catch_warnings(), torch.no_grad():
            # This exporter needs no further package; the newer one needs onnxscript.
            warnings.simplefilter("ignore")
            torch.onnx.export(
                module,
                tuple(inputs.values()),
                file,  # type: ignore[arg-type]
                input_names=list(inputs),
                output_names=outputs,
                dynamic_axes={name: {0: "batch"} for name in (*inputs, *outputs)},
                opset_version=OPSET,
                dynamo=False,
            )
    except (RuntimeError, TypeError, ValueError) as error:
        reason = str(error).splitlines()[0][:200] if str(error) else type(error).__name__
        hint = "Export it yourself, and read it with policies.OnnxPolicy.load."
        raise BenchError("unsupported-policy", f"PyTorch cannot export it: {reason}.", "", hint) from error
    finally:
        torch.backends.mha.set_fastpath_enabled(fast)
    model = onnx.load_model_from_string(file.getvalue())
    with torch.no_grad():
        results = module(*inputs.values())
    for value, result in zip(model.graph.output, results if len(outputs) > 1 else [results], strict=True):
        # The exporter loses shapes that it cannot derive.
        kind = value.type.tensor_type.elem_type
        described = onnx.helper.make_tensor_value_info(value.name, kind, ["batch", *result.shape[1:]])
        value.CopyFrom(described)
    return OnnxPolicy(model.SerializeToString())
