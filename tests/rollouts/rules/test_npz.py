"""Rules about .npz files: arrays of numbers, in bounds, never a pickle."""

from __future__ import annotations

import io
import pickle
import random
import struct
import warnings
import zipfile
from pathlib import Path

import numpy as np

from gym_extensions.catalog.groups import group
from gym_extensions.rollouts.rules import problems
from gym_extensions.rollouts.rules.npz import ArrayFile

from ..examples import GROUP, TRACE, Check, Example, arrays, parametrize, put


def bomb(folder: Path) -> None:
    """Writes a small trace that unpacks to 256 MiB."""
    (folder / TRACE).parent.mkdir(parents=True, exist_ok=True)
    with (
        zipfile.ZipFile(folder / TRACE, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
        archive.open("a.npy", "w") as member,
    ):
        np.lib.format.write_array(member, np.zeros(2**25 + 1, np.int8))
        for _ in range(7):
            member.write(bytes(2**25))


def archive(*members: tuple[str, bytes], packed: int = zipfile.ZIP_STORED) -> bytes:
    stream = io.BytesIO()
    with warnings.catch_warnings(), zipfile.ZipFile(stream, "w", packed) as made:
        warnings.simplefilter("ignore")  # duplicate names
        for name, content in members:
            made.writestr(name, content)
    return stream.getvalue()


def encrypted(data: bytes) -> bytes:
    found = bytearray(data)
    for mark, flags in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
        found[found.index(mark) + flags] |= 1
    return bytes(found)


def npy(header: str) -> bytes:
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header.encode()


POLICY = f"{GROUP}/policies/sequential-run0-stage1.npz"
REWRITE = "Write the file with numpy.savez_compressed."
SHAPE = "{{'descr': '<f4', 'fortran_order': False, 'shape': ({}), }}\n"
HEADERS = {
    "cut off": "{'descr': ('<f4',\n",
    "an open text": "{'descr': '<f4', 'x': '''abc \n",
    "thousands of brackets": "(" * 3000,
    "a type of one part": "{'descr': ('<f4',), 'fortran_order': False, 'shape': (3,), }\n",
    "a type that is a number": "{'descr': 5, 'fortran_order': False, 'shape': (3,), }\n",
    "a set": "{1, 2}\n",
    "of text": "{'descr': '<U3', 'fortran_order': False, 'shape': (3,), }\n",
    "longer than its file": "{" * 60000,
}


EXAMPLES = (
    Example(
        "malformed-arrays",
        "a trace that is not a zip archive",
        put(TRACE, b"not a zip"),
        (
            (
                TRACE,
                "The file cannot be read as a zip archive.",
                REWRITE,
            ),
        ),
    ),
    Example(
        "unpacks-too-large",
        "a small file that unpacks to 256 MiB",
        bomb,
        (
            (
                TRACE,
                "The file unpacks to 1 array of 268435585 bytes; the limits are 256 and 4194304.",
                "Write one episode per trace and one policy per file.",
            ),
        ),
        also=("malformed-array",),
    ),
    Example(
        "pickled-arrays",
        "an array of Python objects",
        put(TRACE, arrays(actions=np.array([{"a": 1}], dtype=object))),
        (
            (
                TRACE,
                "'actions.npy' is an array of Python objects (a pickle).",
                "Store only numbers; savez_compressed(..., allow_pickle=False) refuses objects.",
            ),
        ),
    ),
    Example(
        "malformed-array",
        "a bare pickle in the archive",
        put(POLICY, archive(("weights.npy", pickle.dumps([1])[:5]))),
        (
            (
                POLICY,
                "'weights.npy' has no valid header of an array of numbers.",
                REWRITE,
            ),
        ),
        also=("missing-policy",),
    ),
    *(
        Example(
            "malformed-array",
            f"a header that is {title}",
            put(TRACE, archive(("actions.npy", npy(header)))),
            ((TRACE, "'actions.npy' has no valid header of an array of numbers.", REWRITE),),
        )
        for title, header in HEADERS.items()
    ),
    Example(
        "malformed-array",
        "a shape of 10^14 numbers without data",
        put(TRACE, archive(("actions.npy", npy(SHAPE.format("100000000000000,"))))),
        (
            (
                TRACE,
                "'actions.npy' has 82 bytes; expected 400000000000082 for its shape (100000000000000,).",
                REWRITE,
            ),
        ),
    ),
    Example(
        "malformed-array",
        "bytes after the last number",
        put(TRACE, archive(("actions.npy", npy(SHAPE.format("")) + bytes(9)))),
        ((TRACE, "'actions.npy' has 75 bytes; expected 70 for its shape ().", REWRITE),),
    ),
    Example(
        "repeated-array",
        "two arrays of one name",
        put(TRACE, archive(*[("actions.npy", npy(SHAPE.format("")) + bytes(4))] * 2)),
        ((TRACE, "'actions.npy' appears 2 times.", REWRITE),),
    ),
    *(
        Example(
            "foreign-compression",
            title,
            put(TRACE, data),
            ((TRACE, "'actions.npy' is encrypted or uses an unsupported compression method.", REWRITE),),
        )
        for title, data in (
            ("an array compressed with LZMA", archive(("actions.npy", bytes(99)), packed=zipfile.ZIP_LZMA)),
            ("an array compressed with bzip2", archive(("actions.npy", bytes(99)), packed=zipfile.ZIP_BZIP2)),
            ("an encrypted array", encrypted(archive(("actions.npy", bytes(99))))),
        )
    ),
    Example(
        "foreign-trace",
        "a stage and an episode that no log has",
        put(
            TRACE.replace("stage1", "stage99").replace("episode3", "episode999"), arrays(actions=np.zeros(3))
        ),
        (
            (
                TRACE.replace("stage1", "stage99").replace("episode3", "episode999"),
                "sequential.csv has no stage 99.",
                "Remove the trace.",
            ),
            (
                TRACE.replace("stage1", "stage99").replace("episode3", "episode999"),
                "Episode 999 does not exist; cells have episodes 0 to 19.",
                "Remove the trace.",
            ),
        ),
    ),
    Example(
        "unexpected-name",
        "a run number with a leading zero",
        put(TRACE.replace("run0", "run00"), arrays(actions=np.zeros(3))),
        (
            (
                TRACE.replace("run0", "run00"),
                "Unexpected file.",
                "Remove it, or rename it as described in docs/rollout-log.md.",
            ),
        ),
    ),
    Example(
        "foreign-trace",
        "the trace of a run that is not logged",
        put(TRACE.replace("run0", "run7"), arrays(actions=np.zeros(3))),
        (
            (
                TRACE.replace("run0", "run7"),
                "sequential.csv has no run 7.",
                "Remove the trace, or add the run to the log.",
            ),
        ),
    ),
)


@parametrize(EXAMPLES)
def test_the_rule_reports_these_problems_and_no_other(example: Example, check: Check) -> None:
    check(example)


def test_damaged_arrays_are_reported_and_never_raise() -> None:
    whole, rng = arrays(actions=np.zeros((50, 3)), returns=np.arange(5.0)), random.Random(1)
    reported, members = 0, group(f"{GROUP}-v0")
    for _ in range(1500):
        damaged = bytearray(whole)
        for _ in range(rng.choice((1, 2, 20))):
            place = rng.randrange(len(damaged))
            damaged[place : place + rng.randrange(3)] = rng.randbytes(rng.randrange(3))
        reported += bool(problems("arrays", ArrayFile(TRACE, bytes(damaged), members, {"sequential": (0,)})))
    assert reported > 500
