"""Converts a PyTorch module to a policy that is an ONNX network."""

from __future__ import annotations

import io
import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING

from gym_extensions.errors import BenchError
from gym_extensions.submissions.policies.onnx import OnnxPolicy, required

if TYPE_CHECKING:
    import torch

OPSET = 17
"""Of the networks that are written: old enough for every runtime that is supported."""
SCALES, TOLERANCE = (0.01, 0.1, 1.0, 10.0, 100.0) * 3, 1e-3
"""Of the random batches on which a module and its network are compared; the difference that is rounding."""


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
        dtype: of observations: float32, float64 or uint8. States and noise are of the type of the parameters.

    Raises:
        BenchError: the module cannot be exported, has an operator that is not allowed, or decides by values
            of a tensor in Python (``if x.sum() > 0``), so that its network acts otherwise.

    Example:
        >>> import numpy as np
        >>> import torch
        >>> module = torch.nn.Sequential(torch.nn.Linear(11, 3), torch.nn.Tanh())
        >>> from_torch(module, (11,)).act(np.zeros(11)).shape
        (3,)
    """
    import torch

    if not hasattr(module, "modules") or not hasattr(observation_shape, "__len__"):
        hint = "Give a torch.nn.Module and the shape of an observation, such as (11,)."
        raise BenchError("bad-argument", f"They are {module} and {observation_shape}.", "from_torch()", hint)
    inputs = {"observation": torch.zeros((2, *observation_shape), dtype=getattr(torch, dtype))}
    kind, outputs = next((each.dtype for each in module.parameters()), torch.float32), ["action"]
    if noise:
        inputs["noise"] = torch.zeros((2, noise), dtype=kind)
    if state_shape is not None:
        inputs["state"] = torch.zeros((2, *state_shape), dtype=kind)
        outputs.append("next_state")
    onnx = required("onnx")
    file, fast = io.BytesIO(), torch.backends.mha.get_fastpath_enabled()
    torch.backends.mha.set_fastpath_enabled(False)  # fused attention has no operator in ONNX
    modes = {each: each.training for each in module.modules()}
    module.eval()
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
            model = onnx.load_model_from_string(file.getvalue())
            results = module(*inputs.values())
            results = results if len(outputs) > 1 else [results]
            for value, result in zip(model.graph.output, results, strict=True):
                # The exporter loses shapes that it cannot derive.
                kind, shape = value.type.tensor_type.elem_type, ("batch", *result.shape[1:])
                value.CopyFrom(onnx.helper.make_tensor_value_info(value.name, kind, shape))
            policy = OnnxPolicy(model.SerializeToString())
            seeded = torch.Generator().manual_seed(0)
            for number, scale in enumerate(SCALES):  # of an `if`, the exporter keeps one branch
                sizes = {name: (1 + number % 3, *inputs[name].shape[1:]) for name in inputs}
                drawn = {name: torch.randn(sizes[name], generator=seeded) for name in inputs}
                feeds = {name: (scale * drawn[name]).to(inputs[name].dtype) for name in inputs}
                results = module(*feeds.values())
                found = policy.run({name: feeds[name].numpy() for name in policy.network.inputs})
                for output, result in zip(found, results if len(outputs) > 1 else [results], strict=True):
                    rounding = TOLERANCE, TOLERANCE * max(1.0, scale)
                    if not torch.allclose(torch.from_numpy(output), result, *rounding, equal_nan=True):
                        raise ValueError("its network acts otherwise; decide with torch.where, not with if")
    except (RuntimeError, TypeError, ValueError) as error:
        reason = str(error).splitlines()[0][:200] if str(error) else type(error).__name__
        hint = "Export it yourself, and read it with policies.OnnxPolicy.load."
        raise BenchError("unsupported-policy", f"PyTorch cannot export it: {reason}.", "", hint) from error
    finally:
        torch.backends.mha.set_fastpath_enabled(fast)
        for each, is_training in modes.items():
            each.training = is_training
    return policy
