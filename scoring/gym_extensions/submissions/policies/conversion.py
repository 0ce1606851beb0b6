"""Converts a PyTorch module to a policy that is an ONNX network."""

from __future__ import annotations

import copy
import io
import logging
import re
import threading
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any
from unittest import mock

import numpy as np

from gym_extensions.errors import BenchError
from gym_extensions.submissions.policies.onnx import MISSING, OnnxPolicy, required

if TYPE_CHECKING:
    import torch

OPSET = 17
"""Of the exporter that traces: old enough for every runtime that is supported."""
DTYPES = ("float32", "float64", "uint8")
"""Of observations."""
SCALES, TOLERANCE = (0.01, 0.1, 1.0, 10.0, 100.0) * 3, 1e-3
"""Of the random batches on which a module and its network are compared; the difference that is rounding."""
OPERATOR = re.compile(r"(?:operator|namespace) '?(\w+::\w+)|op='([\w.]+)'")
"""The operator in an exporter's error that ONNX does not have."""
OUTPUTS = ("action", "next_state")
ONE_AT_A_TIME = threading.Lock()


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
    one, to actions (k, a); with a state it returns actions and the next state. If it returns more, the
    actions are the first element of a tuple, or the element ``action`` or ``actions`` of a dictionary. A
    compiled module and a ``DataParallel`` are unwrapped; on another device, a copy is exported.

    Args:
        module: the network, which is exported as in evaluation (``module.eval()``) and stays as it is.
        observation_shape: of one observation.
        state_shape: of the state of one episode; None without.
        noise: the number of standard normal numbers that the module reads, for a policy that samples.
        dtype: of observations: float32, float64 or uint8. States and noise are of the type of the parameters.

    Raises:
        BenchError: the module returns something else, cannot be exported, has an operator that is not
            allowed, or decides by values of a tensor in Python (``if x.sum() > 0``), so that its network acts
            otherwise.

    Example:
        >>> import numpy as np
        >>> import torch
        >>> module = torch.nn.Sequential(torch.nn.Linear(11, 3), torch.nn.Tanh())
        >>> from_torch(module, (11,)).act(np.zeros(11)).shape
        (3,)
    """
    import torch

    given = {"observation": observation_shape, "noise": (noise,) if noise else None, "state": state_shape}
    shapes: dict[str, Any] = {key: shape for key, shape in given.items() if shape is not None}
    if not hasattr(module, "modules") or not all(map(_is_shape, shapes.values())):
        hint = "Give a torch.nn.Module and shapes such as (11,); noise is a number."
        raise BenchError("bad-argument", f"They are {module} and {shapes}.", "from_torch()", hint)
    if str(dtype) not in DTYPES:
        hint = f"Give the name of a type: {', '.join(DTYPES)}."
        raise BenchError("bad-argument", f"The dtype is {dtype!r}.", "from_torch()", hint)
    required("onnx")
    parallel = (torch.nn.DataParallel, torch.nn.parallel.DistributedDataParallel)
    while isinstance(module, parallel) or hasattr(module, "_orig_mod"):
        inner: Any = module.module if isinstance(module, parallel) else module._orig_mod
        module = inner
    name, tensors = type(module).__name__, [*module.parameters(), *module.buffers()]
    if any(map(torch.nn.parameter.is_lazy, tensors)):
        raise _refused(name, "it has a lazy layer without weights", "Call it once with observations.")
    if unfit := {each.dtype for each in tensors if each.is_floating_point() and each.element_size() < 4}:
        found = " and ".join(sorted(str(each).removeprefix("torch.") for each in unfit))
        raise _refused(name, f"it has numbers in {found}", "Pass module.float().")
    number = next((each.dtype for each in module.parameters()), torch.float32)
    sizes = {key: (2, *shape) for key, shape in shapes.items()}
    types = {key: getattr(torch, str(dtype)) if key == "observation" else number for key in sizes}
    zeros = {key: torch.zeros(size, dtype=types[key]) for key, size in sizes.items()}
    modes = {each: each.training for each in module.modules()}
    with _exporting():
        try:
            if any(each.device.type != "cpu" for each in tensors):
                module = copy.deepcopy(module).to("cpu")
            acting = _acting(module, with_state=state_shape is not None).eval()
            with torch.nn.utils.parametrize.cached():  # normalized weights become constants
                results = acting(*zeros.values())
                return _network(acting, zeros, results, name)
        except BenchError:
            raise
        except Exception as error:  # the module may raise anything
            raise _refused(name, f"it fails on zeros: {_reason(error)}") from error
        finally:
            for each, is_training in modes.items():
                each.training = is_training


def _is_shape(value: object) -> bool:
    return isinstance(value, Sequence) and all(
        isinstance(size, int | np.integer) and size > 0 for size in value
    )


def _network(
    acting: torch.nn.Module, zeros: dict[str, torch.Tensor], results: tuple[Any, ...], name: str
) -> OnnxPolicy:
    """The network of a module's results for zeros, by the first exporter whose network acts as the module."""
    import torch

    if not all(isinstance(each, torch.Tensor) for each in results) or results[0].ndim != 2:
        shapes = [tuple(each.shape) if hasattr(each, "shape") else type(each).__name__ for each in results]
        shown = ", ".join(map(str, shapes))
        raise _refused(name, f"for two observations it returns {shown}; expected actions of shape (2, a)")
    reasons = []
    for dynamo in (False, True) if find_spec("onnxscript") else (False,):
        try:
            policy = OnnxPolicy(_exported(acting, zeros, results, dynamo))
            seeded = torch.Generator().manual_seed(0)
            for index, scale in enumerate(SCALES):  # of an `if`, an exporter keeps one branch
                sizes = {key: (1 + index % 3, *each.shape[1:]) for key, each in zeros.items()}
                drawn = {key: scale * torch.randn(size, generator=seeded) for key, size in sizes.items()}
                feeds = {key: values.to(zeros[key].dtype) for key, values in drawn.items()}
                found = policy.run({key: feeds[key].numpy() for key in policy.network.inputs})
                rounding = TOLERANCE, TOLERANCE * max(1.0, scale)
                for output, result in zip(found, acting(*feeds.values()), strict=True):
                    if not torch.allclose(torch.from_numpy(output), result, *rounding, equal_nan=True):
                        raise ValueError("its network acts otherwise; decide with torch.where, not with if")
        except Exception as error:  # an exporter may raise anything
            if isinstance(error, BenchError) and error.code == MISSING:
                raise
            reasons.append(_reason(error))
        else:
            return policy
    raise _refused(name, reasons[0], "Export it yourself, and read it with policies.OnnxPolicy.load.")


def _exported(
    acting: torch.nn.Module, zeros: dict[str, torch.Tensor], results: tuple[Any, ...], dynamo: bool
) -> bytes:
    """The file of a network, from the exporter that traces, or from PyTorch's current one.

    The first is quick and exports scripted modules. The second knows more operators and needs onnxscript.
    """
    import torch

    onnx, file, inputs = required("onnx"), io.BytesIO(), tuple(zeros.values())
    names: dict[str, Any] = {"input_names": list(zeros), "output_names": list(OUTPUTS[: len(results)])}
    if dynamo:
        batch = (tuple({0: torch.export.Dim.AUTO} for _ in inputs),)
        program = torch.onnx.export(acting, inputs, dynamo=True, dynamic_shapes=batch, **names)
        assert program is not None
        model = program.model_proto
    else:
        if any(isinstance(each, torch.jit.ScriptModule) for each in acting.modules()):
            acting = torch.jit.trace(acting, inputs, check_trace=False)  # type: ignore[no-untyped-call]
        axes = {name: {0: "batch"} for each in names.values() for name in each}
        options: Any = {"opset_version": OPSET, "dynamic_axes": axes, "dynamo": False}
        torch.onnx.export(acting, inputs, file, **names, **options)  # type: ignore[arg-type]
        model = onnx.load_model_from_string(file.getvalue())
    for value, result in zip(model.graph.output, results, strict=True):
        # An exporter loses shapes that it cannot derive.
        kind, shape = value.type.tensor_type.elem_type, ("batch", *result.shape[1:])
        value.CopyFrom(onnx.helper.make_tensor_value_info(value.name, kind, shape))
    data: bytes = model.SerializeToString()
    return data


def _acting(module: torch.nn.Module, with_state: bool) -> torch.nn.Module:
    """The module with a tuple of the actions, and of the next state if there is one, as its results."""
    import torch

    class Acting(torch.nn.Module):
        def __init__(self) -> None:
            super().__init__()
            self.module = module

        def forward(self, *inputs: torch.Tensor) -> tuple[Any, ...]:
            results = self.module(*inputs)
            if isinstance(results, dict):
                results = results.get("action", results.get("actions", results))
            if with_state:
                actions, state, *_ = results
                return actions, state
            return (results[0] if isinstance(results, tuple | list) and results else results,)

    return Acting()


def _refused(name: str, reason: str, hint: str = "docs/policies.md says what modules return.") -> BenchError:
    return BenchError("unsupported-policy", f"{name} cannot become a policy: {reason}.", "from_torch()", hint)


def _reason(error: Exception) -> str:
    """An error in one line; the operator, if it is one that ONNX does not have."""
    if isinstance(error, BenchError) and error.code == "onnx-failed":
        if missing := re.search(r"implementation for (\w+)", error.message):
            return f"onnxruntime has no {missing[1]} for numbers of this type; use module.float()"
        return "its network fails for other batches than two; use x.shape[0], not len(x)"
    if isinstance(error, BenchError):
        return error.message.rstrip(".")
    if operator := OPERATOR.search(f"{error}\n{error.__cause__}"):
        return f"ONNX has no operator {operator[1] or operator[2]}"
    first, *_ = [*str(error).strip().splitlines(), type(error).__name__]
    return first[:200].rstrip(".")


@contextmanager
def _exporting() -> Iterator[None]:
    """Modules are called as they are written, without gradients, and nobody sees graphs and advice.

    They are not compiled, and use no fused attention, which has no operator in ONNX. Distributions do not
    check values, on which a graph cannot depend. All of this is set for the process, so that threads wait for
    each other, and what another thread prints meanwhile is lost.
    """
    import torch

    attention, distributions, unseen = torch.backends.mha, torch.distributions.Distribution, io.StringIO()
    printed_from_c = mock.patch.object(torch._C, "_jit_onnx_log", lambda *_: None, create=True)
    with ONE_AT_A_TIME, printed_from_c, redirect_stdout(unseen), redirect_stderr(unseen):
        before = attention.get_fastpath_enabled(), distributions._validate_args, logging.root.manager.disable
        attention.set_fastpath_enabled(False)
        distributions.set_default_validate_args(False)
        logging.disable()
        try:
            with torch.no_grad(), torch.compiler.set_stance("force_eager"), warnings.catch_warnings():
                warnings.simplefilter("ignore")
                yield
        finally:
            attention.set_fastpath_enabled(before[0])
            distributions.set_default_validate_args(before[1])
            logging.disable(before[2])
