"""The policies of a run: their files, their digest, and what is wrong with them."""

import hashlib
import io
import struct
import tokenize
import zipfile
import zlib
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path

import numpy as np
from numpy.lib.format import magic, read_array_header_1_0

from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.catalog.protocol import stages
from gym_extensions.errors import BenchError
from gym_extensions.files import write_bytes
from gym_extensions.submissions import layout
from gym_extensions.submissions.policies.mlp import HINT, Policy
from gym_extensions.submissions.policies.mlp_arrays import Array, Arrays, array_errors
from gym_extensions.submissions.policies.onnx import ONNX, OnnxPolicy, file_bytes, network_errors

NPZ_ERRORS = (
    *(OSError, ValueError, KeyError, EOFError, MemoryError, NotImplementedError, RuntimeError, SyntaxError),
    *(TypeError, tokenize.TokenError, zipfile.BadZipFile, zlib.error),
)
"""What numpy and zipfile raise for a file that is not an .npz file."""
MAGIC = magic(1, 0)
"""What an array begins with whose header has at most 65,535 bytes. numpy writes others for records alone."""
HEAD = 256
"""Bytes of a member that have its header: numpy writes one of 128 for arrays of numbers."""
SKETCH = 128
"""Numbers of a sketch of parameters: that of independent ones correlates by 0 ± .09."""
UNTRAINED = "stage0"
"""The name of the policy before training, which methods with a common start share."""
FEWEST_PARAMETERS = 32
"""Fewer parameters may correlate by chance."""
SAME_POLICY = 0.99
"""Correlation from which two policies are one. In the committed submissions it is at most .12."""
COPIED_POLICY = 0.999
"""The same for the last policies of two submissions. Methods with a common start end near each other with the
same seed: in the committed submissions they correlate by up to .9934 (``l2`` and ``online-ewc``)."""
Key = tuple[int, str | None]
"""Stage and, in the single protocol, name of the trained task."""
AnyPolicy = Policy | OnnxPolicy
"""A policy of a submission: both have ``act``, ``arrays``, ``head`` and the numbers of their inputs."""

Sketches = Mapping[str, list[float]]
"""Sketches of the policies of a run by name (:func:`parameter_sketch`)."""


def policy_name(key: Key) -> str:
    """``stage3``, or ``stage1/TASK`` (single). The full name of an array is ``stage3/weight_0``."""
    stage, task = key
    return f"stage{stage}" if task is None else f"stage{stage}/{task}"


def policy_keys(protocol: str, group: TaskGroup) -> list[Key]:
    """Stage and task name (None but in the single protocol) of every policy of a run."""
    tasks: list[str | None] = [task.name for task in group.tasks] if protocol == "single" else [None]
    return [(stage, task) for stage in stages(protocol, len(group.tasks)) for task in tasks]


def content_sha256(arrays: Arrays) -> str:
    """The SHA-256 of arrays by their full names, which does not depend on how they are packed.

    For every array, sorted by name: a line with its name, type and shape; its values in C order,
    little-endian.
    """
    digest = hashlib.sha256()
    for name in sorted(arrays):
        values = np.ascontiguousarray(arrays[name], arrays[name].dtype.newbyteorder("<"))
        shape = ",".join(map(str, arrays[name].shape))
        digest.update(f"{name} {values.dtype.str} {shape}\n".encode())
        digest.update(values.tobytes())
    return digest.hexdigest()


def require_digest(arrays: Arrays, sha256: str, where: str = "") -> None:
    """Raises ``BenchError`` unless the arrays have this :func:`content_sha256`."""
    if (actual := content_sha256(arrays)) != sha256:
        message = f"The policies have the digest {actual}, not {sha256}."
        raise BenchError("other-policy", message, where, "Get the files of the run.")


def npz_bytes(arrays: Arrays) -> bytes:
    """The content of an .npz file. Equal arrays give equal bytes (numpy dates every member 1980-01-01)."""
    content = io.BytesIO()
    np.savez_compressed(content, allow_pickle=False, **arrays)
    return content.getvalue()


def npz_error(data: bytes) -> str:
    """What is wrong with a file as an .npz file, from its directory and the beginnings of its members.

    Nothing is unpacked but the first ``HEAD`` bytes of each member, so that also the process that scores may
    ask. A member twice would be two arrays of one name, of which another reader may take the other.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            members, comment = archive.infolist(), archive.comment
        names = [info.filename for info in members]
        if (size := sum(info.file_size for info in members)) > layout.MAX_POLICY_BYTES:
            return f"it unpacks to {size} bytes; the limit is {layout.MAX_POLICY_BYTES}"
        if comment or any(info.comment for info in members) or len(set(names)) < len(names):
            return "it has a comment, or a member twice"
        for info in members:
            lengths = struct.unpack_from("<HH", data, info.header_offset + 26)
            start = info.header_offset + 30 + sum(lengths)
            head = data[start : start + HEAD]
            if info.compress_type == zipfile.ZIP_DEFLATED:
                head = zlib.decompressobj(-zlib.MAX_WBITS).decompress(head, HEAD)
            if not (info.filename.endswith(".npy") and head.startswith(MAGIC)):
                return f"its member {info.filename[:80]!r} is not a numpy array of format 1.0"
            _, _, dtype = read_array_header_1_0(io.BytesIO(head[len(MAGIC) :]))
            if dtype.hasobject:
                return f"its member {info.filename[:80]!r} is a pickle"
    except (*NPZ_ERRORS, struct.error) as error:
        return str(error)
    return ""


def npz_arrays(data: bytes, where: str = "") -> dict[str, Array]:
    """The arrays of an .npz file, which ``where`` names, by name; never a pickle.

    Raises ``BenchError`` if it is not such a file, or unpacks to more than ``MAX_POLICY_BYTES``.
    """
    try:
        if error := npz_error(data):
            raise ValueError(error)
        with np.load(io.BytesIO(data), allow_pickle=False) as file:
            return {name: file[name] for name in file.files}
    except NPZ_ERRORS as error:
        raise BenchError("bad-policy", f"The file cannot be read: {error}.", where, HINT) from error


def run_arrays(policies: Mapping[Key, AnyPolicy]) -> dict[str, Array]:
    """The arrays of a run's policies by their full names."""
    return {
        f"{policy_name(key)}/{name}": values
        for key, policy in policies.items()
        for name, values in policy.arrays().items()
    }


def parameter_sketch(policies: Mapping[Key, AnyPolicy]) -> dict[str, list[float]]:
    """A sketch of the weights of each policy by its name; none where they are few or all equal.

    The product of two sketches is about the correlation of the flattened weights, also after noise was added.
    A weight is added to a random place with a random sign (Charikar, Chen & Farach-Colton 2002, "Finding
    frequent items in data streams").
    """
    found = {}
    for key, policy in policies.items():
        weights = policy.flat_weights()
        if weights.size < FEWEST_PARAMETERS or not (deviations := weights - weights.mean()).any():
            continue
        rng = np.random.default_rng(0)
        places, signs = rng.integers(SKETCH, size=weights.size), rng.choice((-1.0, 1.0), weights.size)
        sketch = np.bincount(places, signs * deviations, SKETCH)
        found[policy_name(key)] = (sketch / np.linalg.norm(sketch)).tolist()
    return found


def nearly_equal(first: Sketches, second: Sketches, least: float = SAME_POLICY) -> str:
    """Where trained policies of two runs correlate by more than ``least``, in words; empty if nowhere.

    A run that learns nothing, whose weights are those of stage 0 at every stage, may equal another one.
    """
    if UNTRAINED in first and all(sketch == first[UNTRAINED] for sketch in first.values()):
        return ""
    for name, sketch in first.items():
        if name != UNTRAINED and name in second and np.dot(sketch, second[name]) > least:
            return f"{name}: the weights correlate by more than {least}"
    return ""


def file_suffix(name: str) -> str:
    """The suffix of the file with an array of this full name: ``.npz``, or ``.stage3.onnx`` of a network."""
    return f".{name.replace('/', '.')}" if name.endswith(f"/{ONNX}") else layout.POLICIES


def policy_files(arrays: Arrays) -> dict[str, bytes]:
    """The contents of the files of a run's policies by suffix: ``.npz``, and ``.stage3.onnx`` per network."""
    plain = {name: values for name, values in arrays.items() if file_suffix(name) == layout.POLICIES}
    files = {layout.POLICIES: npz_bytes(plain)} if plain or not arrays else {}
    return files | {file_suffix(name): arrays[name].tobytes() for name in arrays if name not in plain}


def size_error(arrays: Arrays) -> str:
    """Which limit the policies of a run exceed, by their arrays of full names; empty if none."""
    total = sum(values.nbytes for values in arrays.values())
    if total > layout.MAX_POLICY_BYTES:
        return f"The policies of a run have {total:,} bytes; the limit is {layout.MAX_POLICY_BYTES:,}."
    for suffix, data in policy_files(arrays).items():
        if len(data) > (limit := layout.max_bytes(suffix)):
            return f"The file *{suffix} of a run's policies has {len(data):,} bytes; the limit is {limit:,}."
    return ""


def network_names(group: TaskGroup, protocol: str) -> dict[str, str]:
    """The full names of the arrays of a run all of whose policies are networks, by the suffix of the file."""
    names = [f"{policy_name(key)}/{ONNX}" for key in policy_keys(protocol, group)]
    return {file_suffix(name): name for name in names}


def missing_networks(suffixes: Collection[str], group: TaskGroup, protocol: str) -> list[str]:
    """The suffixes of the networks that a run lacks: without an .npz file, each of its policies is one."""
    expected = () if layout.POLICIES in suffixes else network_names(group, protocol)
    return [suffix for suffix in expected if suffix not in suffixes]


def write_policies(path: Path, policies: Mapping[Key, AnyPolicy]) -> None:
    """Writes policies by stage and, in the single protocol, task name (else None), each file atomically.

    ``path`` is ``run3.npz``; ONNX networks become ``run3.stage5.onnx`` beside it, in the single protocol
    ``run3.stage1.Hopper.onnx``.
    """
    for suffix, data in policy_files(run_arrays(policies)).items():
        write_bytes(path.with_name(f"{path.stem}{suffix}"), data)


def network_files(folder: Path, group_name: str, protocol: str, run: int) -> list[Path]:
    """The ONNX networks of a run in a submission."""
    path = folder / layout.run_file(group_name, protocol, run, "")
    return sorted(path.parent.glob(f"{path.name}.*{layout.NETWORK}"))


def has_policies(folder: Path, group: TaskGroup, protocol: str, run: int) -> bool:
    """Whether the policies of a run lie in the submission."""
    path = folder / layout.run_file(group.name, protocol, run, layout.POLICIES)
    return path.is_file() or bool(network_files(folder, group.name, protocol, run))


def read_arrays(folder: Path, group: TaskGroup, protocol: str, run: int) -> dict[str, Array]:
    """The arrays of a run's policies by their full names, as they are; for a limited process.

    Raises ``BenchError`` if there are none, or a file is not an .npz file within the limits.
    """
    path = folder / layout.run_file(group.name, protocol, run, layout.POLICIES)
    networks = network_files(folder, group.name, protocol, run)
    is_plain = path.is_file() or not networks
    arrays = npz_arrays(file_bytes(path, layout.POLICIES), str(path)) if is_plain else {}
    known = network_names(group, protocol)
    for file in networks:  # run3.stage5.onnx as stage5/onnx
        suffix = file.name.removeprefix(path.stem)
        name = known.get(suffix, f"{suffix[1:].removesuffix(layout.NETWORK)}/{ONNX}")
        arrays[name] = np.frombuffer(file_bytes(file, layout.NETWORK), np.uint8)
        if sum(values.nbytes for values in arrays.values()) > layout.MAX_POLICY_BYTES:
            message = f"The policies have more than {layout.MAX_POLICY_BYTES} bytes."
            raise BenchError("bad-policy", message, str(file), HINT)
    return arrays


def run_errors(arrays: Arrays, group: TaskGroup, protocol: str) -> Iterator[tuple[str, str]]:
    """What is wrong with the arrays of a run's policies, with the suffix of the file; foreign ones first."""
    parts, foreign = _split(arrays, policy_keys(protocol, group))
    for name in foreign[:3]:
        yield file_suffix(name), f"The array {name!r} belongs to no stage of the {protocol} protocol."
    for key, part in parts.items():
        where = policy_name(key)
        if not part:
            yield layout.POLICIES, f"The policy of {where} is missing."
        elif ONNX in part:
            errors = [f"Unexpected array {name!r} beside a network." for name in part if name != ONNX]
            errors = errors or network_errors(part[ONNX].tobytes())
            yield from ((file_suffix(f"{where}/{ONNX}"), f"{where}: {error}") for error in errors)
        else:
            yield from ((layout.POLICIES, f"{where}: {error}") for error in array_errors(part))


def _split(arrays: Arrays, keys: list[Key]) -> tuple[dict[Key, dict[str, Array]], list[str]]:
    """The arrays of each policy by their own names, and the full names of the others."""
    parts = {policy_name(key): dict[str, Array]() for key in keys}
    foreign = []
    for full, values in arrays.items():
        policy, _, name = full.rpartition("/")
        if policy in parts:
            parts[policy][name] = values
        else:
            foreign.append(full)
    return dict(zip(keys, parts.values(), strict=True)), foreign


def policies_of(arrays: Arrays, group: TaskGroup, protocol: str) -> dict[Key, AnyPolicy]:
    """As :func:`read_policies`. Raises ``BenchError`` if an array is missing, foreign or of another kind."""
    if error := next(run_errors(arrays, group, protocol), None):
        raise BenchError("bad-policy", error[1], hint=HINT)
    parts, _ = _split(arrays, policy_keys(protocol, group))
    return {
        key: OnnxPolicy(part[ONNX].tobytes()) if ONNX in part else Policy.from_arrays(part)
        for key, part in parts.items()
    }


def read_policies(folder: Path, group: TaskGroup, protocol: str, run: int) -> dict[Key, AnyPolicy]:
    """The policies of a run of a submission, by stage and, in the single protocol, task name (else None).

    Raises:
        BenchError: there are none, or they do not fit the group and the protocol.
    """
    return policies_of(read_arrays(folder, group, protocol, run), group, protocol)
