"""Policy files that are made to harm their reader end with a refusal: nothing is executed."""

import io
import os
import pickle
import struct
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from gym_extensions.submissions.reader import read
from gym_extensions.submissions.review import read_review
from gym_extensions.verification.cli import main

from ..verification.made_submissions import GROUP, copy, honest

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no limits")

FILE = f"{GROUP}/sequential/run0.npz"


class Executed:
    """A pickle that would make a file if it were read."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self) -> tuple[object, ...]:
        return os.mkdir, (str(self.path),)


def npy(descr: str, shape: str, data: bytes = b"") -> bytes:
    """A .npy file with this header."""
    header = f"{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}\n".encode()
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header + data


def zipped(name: str, content: bytes, times: int = 1) -> bytes:
    stream = io.BytesIO()
    with (
        zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
        archive.open(name, "w") as file,
    ):
        for _ in range(times):
            file.write(content)
    return stream.getvalue()


def objects(path: Path) -> bytes:
    stream = io.BytesIO()
    np.savez(stream, allow_pickle=True, weight=np.array([Executed(path)], object))
    return stream.getvalue()


FILES: dict[str, Callable[[Path], bytes]] = {
    "nothing": lambda _: b"",
    "no archive": lambda _: b"PK\x03\x04 and nothing more",
    "a pickle": lambda path: pickle.dumps(Executed(path)),
    "an array of objects": objects,
    "an array that is larger than its data": lambda _: zipped(
        "stage0/weight_0.npy", npy("'<f8'", "(10**12,)")
    ),
    "a negative shape": lambda _: zipped("stage0/weight_0.npy", npy("'<f8'", "(-1,)")),
    "a header that is a program": lambda _: zipped("stage0/weight_0.npy", npy("__import__('os')", "(1,)")),
    "a name that leads out of the folder": lambda _: zipped("../../outside.npy", npy("'<f8'", "(0,)")),
    "an archive that unpacks to a gigabyte": lambda _: zipped("stage0/weight_0.npy", bytes(2**20), 1024),
    "half an archive": lambda _: zipped("stage0/weight_0.npy", npy("'<f8'", "(2,)", bytes(16)))[:60],
}


@pytest.mark.parametrize("name", FILES)
def test_a_hostile_policy_file(name: str, tmp_path: Path) -> None:
    submission, trap = copy(honest(runs=1), tmp_path / "submission"), tmp_path / "trap"
    (submission / FILE).write_bytes(FILES[name](trap))
    assert not trap.exists(), "only reading the file makes the trap snap"
    problems = read(submission, policies=True).problems
    assert any(problem.where.startswith(FILE.rpartition(".")[0]) for problem in problems)
    assert main([str(submission), "--seeds", "5e" * 20, "--cache", str(tmp_path / "cache"), "--write"]) in (
        1,
        2,
    )
    assert not any(each.passed for each in read_review(submission).verifications)
    assert not trap.exists()


def test_a_link_in_place_of_the_policies_is_not_followed(tmp_path: Path) -> None:
    submission = copy(honest(runs=1), tmp_path / "submission")
    (submission / FILE).unlink()
    (submission / FILE).symlink_to(honest(runs=1) / FILE)
    assert read(submission).problems != ()
    assert main([str(submission), "--seeds", "5e" * 20, "--cache", str(tmp_path / "cache")]) == 1
