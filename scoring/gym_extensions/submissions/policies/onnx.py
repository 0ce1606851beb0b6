"""A policy as an ONNX network: what its file may contain, and how onnxruntime runs it.

It needs the extra ``onnx``. Nothing here is imported by what scores logs.
"""

import importlib
import math
import threading
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from gym_extensions.errors import BenchError
from gym_extensions.files import write_bytes
from gym_extensions.submissions.layout import MAX_FILE_BYTES, NETWORK, read_regular
from gym_extensions.submissions.policies.mlp_arrays import Array, require_size
from gym_extensions.submissions.problem import escape, quote

ONNX = "onnx"
"""The name of the array that holds the bytes of a network."""
RUNTIME = "onnxruntime"
MISSING = "missing-extra"
"""The code of the error if a package is not installed, which says nothing about the policy."""
HINT = "docs/policies.md says what a network may contain."
MAX_STEP_SECONDS = 5.0
"""Longest time for the actions of one step."""
OPSETS = range(13, 24)
OPERATORS = """
    Abs Acos Acosh Add And ArgMax ArgMin Asin Asinh Atan Atanh Attention AveragePool BatchNormalization
    Cast CastLike Ceil Celu Clip Concat Constant ConstantOfShape Conv ConvTranspose Cos Cosh CumSum
    DepthToSpace Div Einsum Elu Equal Erf Exp Expand EyeLike Flatten Floor GRU Gather GatherElements
    GatherND Gelu Gemm GlobalAveragePool GlobalMaxPool Greater GreaterOrEqual GroupNormalization
    HardSigmoid HardSwish Identity If InstanceNormalization IsInf IsNaN LSTM LayerNormalization
    LeakyRelu Less LessOrEqual Log LogSoftmax Loop LpNormalization MatMul Max MaxPool Mean Min Mish Mod
    Mul Neg NonZero Not OneHot Or PRelu Pad Pow RMSNormalization RNN Range Reciprocal ReduceL1 ReduceL2
    ReduceLogSum ReduceLogSumExp ReduceMax ReduceMean ReduceMin ReduceProd ReduceSum ReduceSumSquare
    Relu Reshape Resize RotaryEmbedding Round Scan ScatterElements ScatterND Selu Shape Sigmoid Sign Sin
    Sinh Size Slice Softmax Softplus Softsign SpaceToDepth Split Sqrt Squeeze Sub Sum Swish Tan Tanh
    ThresholdedRelu Tile TopK Transpose Trilu Unsqueeze Where Xor
"""
"""Operators of the standard domain that compute numbers from numbers, without randomness."""
ALLOWED = frozenset(OPERATORS.split())
DOMAINS = ("", "ai.onnx")
DTYPES = {1: np.float32, 2: np.uint8, 3: np.int8, 6: np.int32, 7: np.int64, 9: np.bool_, 11: np.float64}
"""The types of inputs and outputs by their number in ONNX."""
KINDS: dict[str, tuple[tuple[type[np.generic], ...], int | None]] = {
    "observation": ((np.float32, np.float64, np.uint8), None),
    "noise": ((np.float32, np.float64), 1),
    "task": ((np.int64,), 0),
    "action": ((np.float32, np.float64), 1),
}
"""The types and the number of dimensions, without the batch, of inputs and of the action."""


class Tensor(NamedTuple):
    """An input or output: its type, and its shape without the batch."""

    dtype: type[np.generic]
    shape: tuple[int, ...]


class Network(NamedTuple):
    """The inputs and outputs of a network by name."""

    inputs: dict[str, Tensor]
    outputs: dict[str, Tensor]


def is_state(name: str) -> bool:
    """Whether an input is a state; its new value is the output ``next_<name>``."""
    return name == "state" or name.startswith("state_")


def required(package: str) -> Any:
    """A package of the extra. Raises ``BenchError`` if it is not installed."""
    try:
        return importlib.import_module(package)
    except ImportError as error:
        name = package.partition(".")[0]
        hint = "Run: pip install 'gym-extensions[onnx]'"
        raise BenchError(MISSING, f"A policy is an ONNX network; it needs {name}.", hint=hint) from error


def file_bytes(path: Path, suffix: str) -> bytes:
    """The bytes of a file of policies. Raises ``BenchError`` if it cannot be read, or is too large."""
    try:
        return read_regular(path, MAX_FILE_BYTES[suffix])
    except OSError as error:
        message = f"The policies cannot be read: {error.strerror or error}."
        raise BenchError("bad-policy", message, str(path), HINT) from error


def network_errors(data: bytes) -> list[str]:
    """What is wrong with the file of a network, of which nothing is run. It needs the package ``onnx``."""
    return _examined(data)[0]


def _examined(data: bytes) -> tuple[list[str], Network]:
    """The errors of a file, and its inputs and outputs as far as they are right."""
    network = Network({}, {})
    if len(data) > MAX_FILE_BYTES[NETWORK]:
        return [f"The network has {len(data)} bytes; the limit is {MAX_FILE_BYTES[NETWORK]}."], network
    onnx, message = required("onnx"), required("google.protobuf.message")
    try:
        model = onnx.ModelProto.FromString(data)
    except message.DecodeError:
        return ["The file is not an ONNX model."], network
    errors = list(_content_errors(model))
    initialized = {tensor.name for tensor in model.graph.initializer}
    inputs = (each for each in model.graph.input if each.name not in initialized)
    for values, tensors in ((inputs, network.inputs), (model.graph.output, network.outputs)):
        for value in values:
            tensor = _tensor(value)
            if isinstance(tensor, str):
                errors.append(f"{quote(value.name)} {tensor}")
            else:
                tensors[value.name] = tensor
    return errors or list(_signature_errors(network)), network


def _content_errors(model: Any) -> Iterator[str]:
    for opset in model.opset_import:
        if opset.domain not in DOMAINS:
            yield f"The domain {quote(opset.domain)} is not allowed; only standard operators are."
        elif opset.version not in OPSETS:
            yield f"The opset is {opset.version}; it must be {OPSETS[0]} to {OPSETS[-1]}."
    if model.functions or model.training_info:
        yield "The model has functions or training information; only a graph is allowed."
    operators, is_external, is_sparse = set[str](), False, False
    for graph in _graphs(model.graph):
        is_sparse |= bool(graph.sparse_initializer)
        for node in graph.node:
            if node.domain not in DOMAINS or node.op_type not in ALLOWED:
                operators.add(f"{node.domain}.{node.op_type}".lstrip("."))
            for attribute in node.attribute:
                is_sparse |= attribute.HasField("sparse_tensor") or bool(attribute.sparse_tensors)
        is_external |= any(tensor.data_location or tensor.external_data for tensor in _tensors(graph))
    for name in sorted(operators)[:3]:
        yield f"The operator {quote(name)} is not allowed."
    if is_external:
        yield "A tensor lies in another file; all data must be in the file itself."
    else:
        yield from _value_errors(model.graph)
    if is_sparse:
        yield "A tensor is sparse; only dense ones are allowed."


def _value_errors(main: Any) -> Iterator[str]:
    """What is wrong with the values of tensors, none of which lies in another file."""
    to_array, unreadable = required("onnx").numpy_helper.to_array, list[str]()
    for tensor in (tensor for graph in _graphs(main) for tensor in _tensors(graph)):
        try:
            to_array(tensor).astype(np.float64)
        except (TypeError, ValueError, LookupError, ArithmeticError):
            unreadable.append(tensor.name)
    for name in unreadable[:3]:
        yield f"The tensor {quote(name)} cannot be read as numbers of its type and shape."


def _graphs(graph: Any) -> Iterator[Any]:
    """A graph and those of its loops and branches."""
    yield graph
    for node in graph.node:
        for attribute in node.attribute:
            for inner in ([attribute.g] if attribute.HasField("g") else []) + list(attribute.graphs):
                yield from _graphs(inner)


def _tensors(graph: Any) -> Iterator[Any]:
    """The tensors of a graph, without those of its loops and branches."""
    yield from graph.initializer
    for node in graph.node:
        for attribute in node.attribute:
            yield from (*([attribute.t] if attribute.HasField("t") else []), *attribute.tensors)


def _tensor(value: Any) -> Tensor | str:
    """An input or output, or what is wrong with it."""
    kind = value.type.tensor_type
    if kind.elem_type not in DTYPES:
        return "is of another type than the allowed ones."
    dims = list(kind.shape.dim)
    if not dims or (dims[0].HasField("dim_value") and dims[0].dim_value != 1):
        return "has no batch of one: its first dimension must be 1 or symbolic; export it with such a batch."
    if not all(dim.HasField("dim_value") and dim.dim_value > 0 for dim in dims[1:]):
        return "has a dynamic shape: all dimensions but the first must be fixed."
    return Tensor(DTYPES[kind.elem_type], tuple(dim.dim_value for dim in dims[1:]))


def _signature_errors(network: Network) -> Iterator[str]:
    inputs, outputs = network.inputs, network.outputs
    for name in inputs:
        if name not in KINDS and not is_state(name):
            yield f"Unexpected input {quote(name)}; expected observation, state, noise or task."
    if "observation" not in inputs:
        yield "The input 'observation' is missing."
    states = {f"next_{name}": tensor for name, tensor in inputs.items() if is_state(name)}
    for name in ("action", *states):
        if name not in outputs:
            yield f"The output {quote(name)} is missing."
        elif name in states and outputs[name] != states[name]:
            yield f"{quote(name)} has another type or shape than {quote(name.removeprefix('next_'))}."
    for name in outputs:
        if name not in ("action", *states):
            yield f"Unexpected output {quote(name)}; expected action, and next_state for a state."
    for name, (dtypes, rank) in KINDS.items():
        tensor = {**inputs, **outputs}.get(name)
        if tensor is not None and tensor.dtype not in dtypes:
            names = " or ".join(np.dtype(each).name for each in dtypes)
            yield f"{name!r} is {np.dtype(tensor.dtype).name}; expected {names}."
        if tensor is not None and rank is not None and len(tensor.shape) != rank:
            yield f"{name!r} has {len(tensor.shape) + 1} dimensions; expected {rank + 1}."


class OnnxPolicy:
    """A policy of any architecture as an ONNX network, which onnxruntime runs on one core.

    It acts for each observation of a batch by itself, so that episodes cannot see each other. Inputs and
    outputs, where k is 1 or symbolic:

    * ``observation`` (k, …): float32, float64 or uint8.
    * ``action`` (k, a), an output: float32 or float64, not clipped to the action space.
    * ``state`` (k, …), optional: zeros at the start of an episode, then the output ``next_state`` of the same
      shape. Further states are ``state_<name>`` and ``next_state_<name>``.
    * ``noise`` (k, m), optional: standard normal numbers. A policy without it is deterministic.
    * ``task`` (k,), optional: int64, the index of the task in the group.

    Args:
        data: the content of an ONNX file, which ``where`` names in errors.

    Raises:
        BenchError: the network has an operator, a shape or a tensor that is not allowed, or the package
            ``onnx`` is not installed.
    """

    def __init__(self, data: bytes, where: str = "policy()") -> None:
        errors, network = _examined(data)
        if errors:
            raise BenchError("bad-policy", errors[0], where, HINT)
        self._data, self.network = data, network
        self._session: Any = None
        self._states: dict[str, Array] = {}

    @classmethod
    def load(cls, path: str | Path) -> "OnnxPolicy":
        """The policy in an ONNX file. Raises ``BenchError`` as the class does, or if it cannot be read."""
        return cls(file_bytes(Path(path), NETWORK), str(path))

    @property
    def num_inputs(self) -> int:
        """The number of values of an observation."""
        return math.prod(self.network.inputs["observation"].shape)

    @property
    def num_actions(self) -> int:
        """The number of values of an action."""
        return self.network.outputs["action"].shape[0]

    @property
    def num_tasks(self) -> int:
        """1 if the policy reads the task, else 0."""
        return int("task" in self.network.inputs)

    @property
    def head(self) -> str:
        """``gaussian`` if the policy reads noise, else ``deterministic``."""
        return "gaussian" if "noise" in self.network.inputs else "deterministic"

    def arrays(self) -> dict[str, Array]:
        """The bytes of the network as the array ``onnx``."""
        return {ONNX: np.frombuffer(self._data, np.uint8)}

    def flat_weights(self) -> Array:
        """The values of all tensors of two or more dimensions in one row; infinite ones and NaN are 0."""
        onnx = required("onnx")
        graphs = _graphs(onnx.ModelProto.FromString(self._data).graph)
        tensors = (tensor for graph in graphs for tensor in _tensors(graph) if len(tensor.dims) > 1)
        rows = (onnx.numpy_helper.to_array(tensor).ravel().astype(np.float64) for tensor in tensors)
        return np.nan_to_num(np.concatenate([np.zeros(0), *rows]), posinf=0.0, neginf=0.0)

    def to_onnx(self, path: str | Path | None = None) -> bytes:
        """The network's bytes, which are also written to ``path`` if there is one."""
        if path is not None:
            write_bytes(Path(path), self._data)
        return self._data

    def reset(self) -> None:
        """Starts new episodes: states are zeros in the next call of :meth:`act`."""
        self._states = {}

    def act(self, observations: Array, rng: np.random.Generator | None = None, task: int = 0) -> Array:
        """Actions, not clipped to the action space: (a,) for one observation (…), (k, a) for many (k, …).

        The states are kept for the next call. ``rng`` is the source of ``noise``, ``task`` the index of the
        task in the group, for policies that read them.

        Raises:
            BenchError: the observations have another size, the network fails, a step takes longer
                than ``MAX_STEP_SECONDS``, or onnxruntime is not installed.
        """
        values = np.asarray(observations)
        if values.ndim == len(self.network.inputs["observation"].shape):
            return self.act(values[None], rng, task)[0]
        size, feeds = len(values), dict[str, Array]()
        require_size(values, self.num_inputs)
        for name, tensor in self.network.inputs.items():
            shape = (size, *tensor.shape)
            if name == "observation":
                feeds[name] = np.asarray(values, tensor.dtype).reshape(shape)
            elif name == "task":
                feeds[name] = np.full(shape, task, np.int64)
            elif name == "noise":
                if rng is None:
                    hint = "Pass rng, a numpy Generator."
                    raise BenchError("no-generator", "The policy samples.", "act()", hint)
                feeds[name] = rng.standard_normal(shape, tensor.dtype)  # type: ignore[arg-type]
            else:
                feeds[name] = self._states.get(name, np.zeros(shape, tensor.dtype))
                if len(feeds[name]) != size:
                    message = f"There are {size} observations; the states are of {len(feeds[name])}."
                    raise BenchError("bad-observations", message, "act()", "Call reset() before.")
        outputs = dict(zip(self.network.outputs, self.run(feeds), strict=True))
        if outputs["action"].shape != (size, self.num_actions):
            message = f"The actions have the shape {outputs['action'].shape} for {size} observations."
            raise BenchError("onnx-failed", message, "act()", HINT)
        self._states = {name: outputs[f"next_{name}"] for name in self.network.inputs if is_state(name)}
        return outputs["action"]

    def run(self, feeds: Mapping[str, Array]) -> Sequence[Array]:
        """The outputs for inputs (k, …), in the order of the network: those of each row by itself."""
        size = len(next(iter(feeds.values())))
        outputs = [np.empty((size, *each.shape), each.dtype) for each in self.network.outputs.values()]
        runtime = required(RUNTIME)
        # The exceptions of onnxruntime have no common base.
        own = vars(runtime.capi.onnxruntime_pybind11_state).values()
        failures = tuple(each for each in own if isinstance(each, type) and issubclass(each, Exception))
        failures += (RuntimeError, ValueError, MemoryError)
        options = runtime.RunOptions()
        options.log_severity_level = 4
        timer = threading.Timer(MAX_STEP_SECONDS, setattr, (options, "terminate", True))
        timer.daemon = True
        try:
            if self._session is None:
                self._session = _session(runtime, self._data)
            timer.start()
            for row in range(size):
                one = {name: values[row : row + 1] for name, values in feeds.items()}
                results = self._session.run(list(self.network.outputs), one, options)
                for output, result in zip(outputs, results, strict=True):
                    output[row] = result.reshape(output.shape[1:])
        except failures as error:
            if options.terminate:
                message = f"A step took more than {MAX_STEP_SECONDS:g} seconds."
                raise BenchError("slow-policy", message, "act()", "Publish a smaller network.") from error
            reason = escape(str(error).splitlines()[0][:200]) if str(error) else type(error).__name__
            raise BenchError("onnx-failed", f"The network failed: {reason}.", "act()", HINT) from error
        finally:
            timer.cancel()
        return outputs


def _session(runtime: Any, data: bytes) -> Any:
    """One thread, and the graph as it is: an optimizer would compute constants without a limit of time."""
    options = runtime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.graph_optimization_level = runtime.GraphOptimizationLevel.ORT_DISABLE_ALL
    options.enable_cpu_mem_arena = False
    options.use_deterministic_compute = True
    options.log_severity_level = 4
    return runtime.InferenceSession(data, options, providers=["CPUExecutionProvider"])
