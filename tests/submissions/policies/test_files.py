"""The policies of a run: their file, their digest, and what can be wrong with them."""

import io
import os
import struct
import warnings
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gym_extensions.catalog.groups import group
from gym_extensions.errors import BenchError
from gym_extensions.submissions.layout import MAX_POLICY_BYTES, POLICIES, run_file
from gym_extensions.submissions.policies import files
from gym_extensions.submissions.policies.mlp import Policy

from ...conftest import refused
from ..examples import arrays
from .test_mlp import SEEN, SMALL, TASKED

GROUP = group("hopper-gravity")


def write_run(folder: Path, protocol: str, policy: Policy = SMALL) -> dict[files.Key, Policy]:
    by_key = dict.fromkeys(files.policy_keys(protocol, GROUP), policy)
    (folder / GROUP.name / protocol).mkdir(parents=True, exist_ok=True)
    files.write_policies(folder / run_file(GROUP.name, protocol, 0, POLICIES), by_key)
    return by_key


def test_the_policies_of_a_run_are_those_of_its_stages_and_in_single_of_its_tasks() -> None:
    assert files.policy_keys("sequential", GROUP) == [(stage, None) for stage in range(6)]
    assert files.policy_keys("joint", GROUP) == [(1, None)]
    assert files.policy_keys("single", GROUP) == [(1, task.name) for task in GROUP.tasks]
    assert [files.policy_name(key) for key in ((3, None), (1, "Hopper"))] == ["stage3", "stage1/Hopper"]


def test_a_network_of_a_task_with_a_namespace_is_read_again(tmp_path: Path) -> None:
    tasks = [replace(task, name=f"mine/{task.name}-v0") for task in GROUP.tasks]
    custom = replace(GROUP, tasks=tuple(tasks))
    network = run_file(GROUP.name, "single", 0, f".stage1.mine.{GROUP.tasks[0].name}-v0.onnx")
    (tmp_path / network).parent.mkdir(parents=True)
    (tmp_path / network).write_bytes(b"a network")
    (tmp_path / network).with_name("run0.stage9.Foreign.onnx").write_bytes(b"of no task")
    assert set(files.read_arrays(tmp_path, custom, "single", 0)) == {
        f"stage1/{tasks[0].name}/onnx",
        "stage9.Foreign/onnx",
    }


@pytest.mark.parametrize("protocol", ["sequential", "single", "joint"])
@pytest.mark.parametrize("policy", [SMALL, TASKED, Policy(np.zeros(1), np.ones(1), head="uniform")])
def test_a_file_gives_the_same_policies(tmp_path: Path, protocol: str, policy: Policy) -> None:
    written = write_run(tmp_path, protocol, policy)
    again = files.read_policies(tmp_path, GROUP, protocol, 0)
    assert list(again) == list(written)
    for one in again.values():
        rngs = (np.random.default_rng(1), np.random.default_rng(1))
        assert np.array_equal(policy.act(SEEN, rngs[0]), one.act(SEEN, rngs[1]))
    assert files.has_policies(tmp_path, GROUP, protocol, 0)
    assert not files.has_policies(tmp_path, GROUP, protocol, 1)


def test_the_digest_is_that_of_the_content_and_not_of_the_packing() -> None:
    arrays = files.run_arrays({(1, None): SMALL})
    digest = files.content_sha256(arrays)
    assert files.content_sha256(files.npz_arrays(files.npz_bytes(arrays))) == digest
    assert files.content_sha256(dict(reversed(arrays.items()))) == digest
    assert files.content_sha256({name: np.array(each, order="F") for name, each in arrays.items()}) == digest
    bias = arrays["stage1/bias_0"]
    for changed in (bias + 1, bias.astype(np.float64), bias.reshape(1, -1)):
        assert files.content_sha256(arrays | {"stage1/bias_0": changed}) != digest
    assert files.content_sha256(arrays | {"stage2/bias_0": bias}) != digest


def test_few_weights_or_equal_ones_have_no_sketch() -> None:
    def linear(weights: np.ndarray) -> Policy:
        return Policy(np.zeros(20), np.ones(20), weights=(weights,), biases=(np.zeros(20),))

    equal, drawn = linear(np.ones((2, 20))), linear(np.random.default_rng(0).normal(size=(2, 20)))
    sketches = files.parameter_sketch({(0, None): SMALL, (1, None): equal, (2, None): drawn})
    assert sketches.keys() == {"stage2"}


def archive(*members: tuple[str, bytes], comment: bytes = b"") -> bytes:
    """A zip file with the same array under these names, with comments."""
    content, array = io.BytesIO(), io.BytesIO()
    np.save(array, np.zeros(2))
    with zipfile.ZipFile(content, "w") as file, warnings.catch_warnings(action="ignore"):
        file.comment = comment
        for name, note in members:
            info = zipfile.ZipInfo(name)
            info.comment = note
            file.writestr(info, array.getvalue())
    return content.getvalue()


def with_header(header: str, size: int = 118) -> bytes:
    """A zip file with one array, whose header is this text."""
    content, member = io.BytesIO(), np.lib.format.magic(1, 0) + struct.pack("<H", size)
    with zipfile.ZipFile(content, "w") as file:
        file.writestr("bias_0.npy", member + header.encode().ljust(size))
    return content.getvalue()


NUMBERS = "{{'descr': {}, 'fortran_order': False, 'shape': ({},), }}"


class Trap:
    """A pickle that makes a folder if it is read."""

    def __reduce__(self) -> tuple[object, ...]:
        return os.mkdir, ("trap",)


def test_missing_policies_are_named(tmp_path: Path) -> None:
    content = files.run_arrays(write_run(tmp_path, "sequential"))
    less = {name: values for name, values in content.items() if not name.startswith("stage2/")}
    with pytest.raises(BenchError, match="stage2"):
        files.policies_of(less, GROUP, "sequential")
    with pytest.raises(BenchError, match="No such file"):
        files.read_policies(tmp_path, GROUP, "sequential", 5)


@pytest.mark.parametrize(
    ("data", "fact"),
    [
        (b"", "cannot be read"),
        (b"not a zip", "cannot be read"),
        (arrays(a=[Trap()]), "is a pickle"),
        (with_header(NUMBERS.format("'O'", 1)), "is a pickle"),
        (with_header(NUMBERS.format("'object'", 1)), "is a pickle"),
        (with_header(NUMBERS.format("[('a', 'O')]", 1)), "is a pickle"),
        (with_header(" " * 400 + NUMBERS.format("'|O'", 1), 460), "cannot be read"),
        (files.npz_bytes({"a": np.zeros(MAX_POLICY_BYTES // 8 + 1)}), "unpacks to"),
        (files.npz_bytes(SMALL.arrays())[:-40], "cannot be read"),
        (with_header("{'descr': ("), "cannot be read"),
        (with_header("{1: 2, 'a': 3}"), "cannot be read"),
        (with_header(NUMBERS.format("'<f8'", 10**12)), "cannot be read"),
        (with_header(NUMBERS.format("'<f8'", -1)), "cannot be read"),
        (with_header(NUMBERS.format("os.mkdir('trap')", 1)), "cannot be read"),
        (archive(("bias_0.npy", b""), ("bias_0.npy", b"")), "a member twice"),
        (archive(("bias_0", b"")), "'bias_0' is not a numpy array"),
        (archive(("bias_0.npy", b"a")), "a comment"),
        (archive(("bias_0.npy", b""), comment=b"b"), "a comment"),
    ],
    ids=[
        *("nothing", "no archive", "a pickle", "objects", "objects by another name", "records of objects"),
        *("a long header", "a bomb", "cut", "half a header", "another header"),
        *("less data than stated", "a negative shape", "a program", "twice", "another member", "commented"),
        "a comment",
    ],
)
def test_a_file_that_is_no_archive_of_numbers_is_refused_and_not_executed(
    data: bytes, fact: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with refused("bad-policy", fact):
        files.npz_arrays(data)
    assert not any(tmp_path.iterdir())
