"""The policies of a run: their files, their digest, and what is wrong with them."""

from __future__ import annotations

import hashlib
import io
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.catalog.protocol import stages
from gym_extensions.errors import BenchError
from gym_extensions.files import write_bytes
from gym_extensions.rollouts.layout import (
    MAX_FILE_BYTES,
    MAX_POLICY_BYTES,
    NETWORK,
    POLICIES,
    read_regular,
    run_file,
)
from gym_extensions.rollouts.onnx_policy import ONNX, OnnxPolicy, network_errors
from gym_extensions.rollouts.policy import HINT, Policy
from gym_extensions.rollouts.policy_arrays import Array, Arrays, array_errors

NPZ_ERRORS = (
    *(OSError, ValueError, KeyError, EOFError, MemoryError, NotImplementedError, RuntimeError, SyntaxError),
    *(zipfile.BadZipFile, zlib.error),
)
"""What numpy and zipfile raise for a file that is not an .npz file."""
Key = tuple[int, str | None]
"""Stage and, in the single protocol, name of the trained task."""
AnyPolicy = Policy | OnnxPolicy
"""A policy of a submission: both have ``act``, ``arrays``, ``head`` and the numbers of their inputs."""


def prefix(key: Key) -> str:
    """What the names of a policy's arrays begin with: ``stage3/``, or ``stage1/TASK/`` (single)."""
    stage, task = key
    return f"stage{stage}/" if task is None else f"stage{stage}/{task}/"


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


def npz_bytes(arrays: Arrays) -> bytes:
    """The content of an .npz file. Equal arrays give equal bytes (numpy dates every member 1980-01-01)."""
    content = io.BytesIO()
    np.savez_compressed(content, allow_pickle=False, **arrays)
    return content.getvalue()


def npz_arrays(data: bytes) -> dict[str, Array]:
    """The arrays of an .npz file by name, never a pickle.

    Raises:
        BenchError: it is not such a file, or unpacks to more than ``MAX_POLICY_BYTES``.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            size = sum(info.file_size for info in archive.infolist())
        if size > MAX_POLICY_BYTES:
            raise ValueError(f"it unpacks to {size} bytes; the limit is {MAX_POLICY_BYTES}")
        with np.load(io.BytesIO(data), allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
    except NPZ_ERRORS as error:
        raise BenchError("bad-policy", f"The file cannot be read: {error}.", hint=HINT) from error
    if not all(isinstance(values, np.ndarray) for values in arrays.values()):
        raise BenchError("bad-policy", "The file has a member that is no array.", hint=HINT)
    return arrays


def run_arrays(policies: Mapping[Key, AnyPolicy]) -> dict[str, Array]:
    """The arrays of a run's policies by their full names."""
    return {
        f"{prefix(key)}{name}": values
        for key, policy in policies.items()
        for name, values in policy.arrays().items()
    }


def policy_files(arrays: Arrays) -> dict[str, bytes]:
    """The contents of the files of a run's policies by suffix: ``.npz``, and ``.stage3.onnx`` per network."""
    networks = {name: values for name, values in arrays.items() if name.endswith(f"/{ONNX}")}
    plain = {name: values for name, values in arrays.items() if name not in networks}
    files = {POLICIES: npz_bytes(plain)} if plain or not networks else {}
    return files | {f".{name.replace('/', '.')}": values.tobytes() for name, values in networks.items()}


def write_policies(path: Path, policies: Mapping[Key, AnyPolicy]) -> None:
    """Writes the policies of a run, each file whole or not at all.

    Args:
        path: ``run3.npz``; ONNX networks become ``run3.stage5.onnx`` beside it, in the single protocol
            ``run3.stage1.Hopper.onnx``.
        policies: by stage and, in the single protocol, task name (else None).
    """
    for suffix, data in policy_files(run_arrays(policies)).items():
        write_bytes(path.with_name(f"{path.stem}{suffix}"), data)


def network_files(folder: Path, group_name: str, protocol: str, run: int) -> list[Path]:
    """The ONNX networks of a run in a submission."""
    path = folder / run_file(group_name, protocol, run, "")
    return sorted(path.parent.glob(f"{path.name}.*{NETWORK}"))


def old_policy_files(folder: Path, group: TaskGroup, protocol: str, run: int) -> dict[Key, Path]:
    """TRANSITIONAL: the policies of a run in the folder ``policies`` of its group, a file each, by key.

    Entries that were migrated from the form before 2026-12 have them until their policies are repacked
    (``scoring/migrate_format_1.py --repack-policies``). Remove this function then.
    """
    names = {
        key: f"{protocol}-run{run}-stage{key[0]}{'' if key[1] is None else f'-{key[1]}'}.npz"
        for key in policy_keys(protocol, group)
    }
    paths = {key: folder / group.name / "policies" / name for key, name in names.items()}
    return {key: path for key, path in paths.items() if path.is_file()}


def has_policies(folder: Path, group: TaskGroup, protocol: str, run: int) -> bool:
    """Whether the policies of a run lie in the submission."""
    path = folder / run_file(group.name, protocol, run, POLICIES)
    networks = network_files(folder, group.name, protocol, run)
    return path.is_file() or bool(networks or old_policy_files(folder, group, protocol, run))


def read_arrays(folder: Path, group: TaskGroup, protocol: str, run: int) -> dict[str, Array]:
    """The arrays of a run's policies by their full names, as they are; for a limited process.

    Args:
        folder: the submission.
        group: the group.
        protocol: one of ``PROTOCOLS``.
        run: the run.

    Raises:
        BenchError: there are none, or a file is not an .npz file within the limits.
    """
    path = folder / run_file(group.name, protocol, run, POLICIES)
    if networks := network_files(folder, group.name, protocol, run):
        return _with_networks(_arrays_of_file(path) if path.is_file() else {}, networks)
    if path.is_file() or not (old := old_policy_files(folder, group, protocol, run)):
        return _arrays_of_file(path)
    return {
        f"{prefix(key)}{name}": values
        for key, file in old.items()
        for name, values in _arrays_of_file(file).items()
    }


def _with_networks(arrays: dict[str, Array], paths: list[Path]) -> dict[str, Array]:
    """The arrays and the bytes of networks, ``run3.stage5.onnx`` as ``stage5/onnx``."""
    for path in paths:
        data = _bytes_of_file(path, NETWORK)
        stage, _, task = path.stem.partition(".")[2].partition(".")  # a task's name may have dots
        arrays["/".join(part for part in (stage, task, ONNX) if part)] = np.frombuffer(data, np.uint8)
        if sum(values.nbytes for values in arrays.values()) > MAX_POLICY_BYTES:
            message = f"The policies have more than {MAX_POLICY_BYTES} bytes."
            raise BenchError("bad-policy", message, str(path), HINT)
    return arrays


def _bytes_of_file(path: Path, suffix: str) -> bytes:
    try:
        return read_regular(path, MAX_FILE_BYTES[suffix])
    except OSError as error:
        message = f"The policies cannot be read: {error.strerror or error}."
        raise BenchError("bad-policy", message, str(path), HINT) from error


def _arrays_of_file(path: Path) -> dict[str, Array]:
    try:
        return npz_arrays(_bytes_of_file(path, POLICIES))
    except BenchError as error:
        raise BenchError(error.code, error.message, str(path), error.hint) from error


def run_errors(arrays: Arrays, group: TaskGroup, protocol: str) -> Iterator[str]:
    """What is wrong with the arrays of a run's policies: missing and foreign policies, then their arrays."""
    parts, foreign = _split(arrays, policy_keys(protocol, group))
    for name in foreign[:3]:
        yield f"The array {name!r} belongs to no stage of the {protocol} protocol."
    for key, part in parts.items():
        where = prefix(key)[:-1]
        if not part:
            yield f"The policy of {where} is missing."
        elif ONNX in part:
            others = [f"Unexpected array {name!r} beside a network." for name in part if name != ONNX]
            yield from (f"{where}: {error}" for error in others or network_errors(part[ONNX].tobytes()))
        else:
            yield from (f"{where}: {error}" for error in array_errors(part))


def _split(arrays: Arrays, keys: list[Key]) -> tuple[dict[Key, dict[str, Array]], list[str]]:
    """The arrays of each policy by their own names, and the full names of the others."""
    parts: dict[Key, dict[str, Array]] = {key: {} for key in keys}
    by_prefix, foreign = {prefix(key): key for key in keys}, []
    for full, values in arrays.items():
        start, _, name = full.rpartition("/")
        key = by_prefix.get(f"{start}/")
        if key is None:
            foreign.append(full)
        else:
            parts[key][name] = values
    return parts, foreign


def policies_of(arrays: Arrays, group: TaskGroup, protocol: str) -> dict[Key, AnyPolicy]:
    """The policies of a run by stage and, in the single protocol, task name (else None).

    Raises:
        BenchError: an array is missing, foreign or of another shape or kind.
    """
    if error := next(run_errors(arrays, group, protocol), ""):
        raise BenchError("bad-policy", error, hint=HINT)
    parts, _ = _split(arrays, policy_keys(protocol, group))
    return {
        key: OnnxPolicy(part[ONNX].tobytes()) if ONNX in part else Policy.from_arrays(part)
        for key, part in parts.items()
    }


def read_policies(folder: Path, group: TaskGroup, protocol: str, run: int) -> dict[Key, AnyPolicy]:
    """The policies of a run by stage and, in the single protocol, task name (else None).

    Args:
        folder: the submission.
        group: the group.
        protocol: one of ``PROTOCOLS``.
        run: the run.

    Raises:
        BenchError: there are none, or they do not fit the group and the protocol.
    """
    return policies_of(read_arrays(folder, group, protocol, run), group, protocol)
