"""Rules about .npz files: arrays of numbers, in bounds, never a pickle."""

from __future__ import annotations

import io
import pickle
import random
import struct
import warnings
import zipfile

import numpy as np

from gym_extensions.catalog.groups import group
from gym_extensions.rollouts import safe_npz as npz
from gym_extensions.rollouts.rules import broken
from gym_extensions.rollouts.rules.npz import Arrays

from .broken import GROUP, TRACE, Broken, Judge, arrays, each, put


def bomb() -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive, archive.open("a.npy", "w") as member:
        np.lib.format.write_array(member, np.zeros(2**25 + 1, np.int8))
        for _ in range(7):
            member.write(bytes(2**25))
    return stream.getvalue()


def archive(*members: tuple[str, bytes], packed: int = zipfile.ZIP_STORED) -> bytes:
    stream = io.BytesIO()
    with warnings.catch_warnings(), zipfile.ZipFile(stream, "w", packed) as made:
        warnings.simplefilter("ignore")  # of a name that stands twice
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


REWRITE = "Write it with numpy.savez_compressed."
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


BROKEN = (
    Broken(
        "malformed-arrays",
        "a trace that is no archive",
        put(TRACE, b"not a zip"),
        (
            (
                TRACE,
                "It is no .npz file: it cannot be read as a zip archive.",
                "Write it with numpy.savez_compressed.",
            ),
        ),
    ),
    Broken(
        "unpacks-too-large",
        "a small file that unpacks to 256 MiB",
        put(TRACE, bomb()),
        (
            (
                TRACE,
                "It unpacks to 1 arrays of 268435585 bytes; the limits are 256 and 268435456.",
                "Keep one episode a trace and one policy a file.",
            ),
        ),
        also=("malformed-array",),
    ),
    Broken(
        "pickled-arrays",
        "an array of Python objects",
        put(TRACE, arrays(actions=np.array([{"a": 1}], dtype=object))),
        (
            (
                TRACE,
                "'actions.npy' is an array of Python objects (a pickle).",
                "Store numbers alone; savez_compressed(..., allow_pickle=False) refuses the rest.",
            ),
        ),
    ),
    Broken(
        "malformed-array",
        "a bare pickle in the archive",
        put(f"{GROUP}/policies/run0.npz", archive(("weights.npy", pickle.dumps([1])[:5]))),
        (
            (
                f"{GROUP}/policies/run0.npz",
                "'weights.npy' has no header of an array of numbers.",
                REWRITE,
            ),
        ),
    ),
    *(
        Broken(
            "malformed-array",
            f"a header that is {title}",
            put(TRACE, archive(("actions.npy", npy(header)))),
            ((TRACE, "'actions.npy' has no header of an array of numbers.", REWRITE),),
        )
        for title, header in HEADERS.items()
    ),
    Broken(
        "malformed-array",
        "a shape of 10^14 numbers without one of them",
        put(TRACE, archive(("actions.npy", npy(SHAPE.format("100000000000000,"))))),
        (
            (
                TRACE,
                "'actions.npy' has 82 bytes; its shape (100000000000000,) needs 400000000000082.",
                REWRITE,
            ),
        ),
    ),
    Broken(
        "malformed-array",
        "numbers behind the last",
        put(TRACE, archive(("actions.npy", npy(SHAPE.format("")) + bytes(9)))),
        ((TRACE, "'actions.npy' has 75 bytes; its shape () needs 70.", REWRITE),),
    ),
    Broken(
        "repeated-array",
        "two arrays of one name",
        put(TRACE, archive(*[("actions.npy", npy(SHAPE.format("")) + bytes(4))] * 2)),
        ((TRACE, "It holds 'actions.npy' 2 times.", REWRITE),),
    ),
    *(
        Broken(
            "foreign-compression",
            title,
            put(TRACE, data),
            ((TRACE, "'actions.npy' is packed in another way or encrypted.", REWRITE),),
        )
        for title, data in (
            ("an array packed by LZMA", archive(("actions.npy", bytes(99)), packed=zipfile.ZIP_LZMA)),
            ("an array packed by bzip2", archive(("actions.npy", bytes(99)), packed=zipfile.ZIP_BZIP2)),
            ("an encrypted array", encrypted(archive(("actions.npy", bytes(99))))),
        )
    ),
    Broken(
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
                "A cell has no episode 999.",
                "Remove the trace.",
            ),
        ),
    ),
    Broken(
        "unexpected-name",
        "a run that is written with a further zero",
        put(TRACE.replace("run0", "run00"), arrays(actions=np.zeros(3))),
        (
            (
                TRACE.replace("run0", "run00"),
                "A file of this name has no place here.",
                "Remove it, or give it the name that docs/rollout-log.md says.",
            ),
        ),
    ),
    Broken(
        "foreign-trace",
        "the trace of a run that is not logged",
        put(TRACE.replace("run0", "run7"), arrays(actions=np.zeros(3))),
        (
            (
                TRACE.replace("run0", "run7"),
                "sequential.csv has no run 7.",
                "Remove the trace, or add the run's log.",
            ),
        ),
    ),
)


@each(BROKEN)
def test_a_broken_folder_breaks_its_rule_and_says_so(example: Broken, judge: Judge) -> None:
    judge(example)


def test_damaged_arrays_are_told_and_never_raise() -> None:
    whole, rng = arrays(actions=np.zeros((50, 3)), returns=np.arange(5.0)), random.Random(1)
    told, members = 0, group(f"{GROUP}-v0")
    for _ in range(1500):
        damaged = bytearray(whole)
        for _ in range(rng.choice((1, 2, 20))):
            place = rng.randrange(len(damaged))
            damaged[place : place + rng.randrange(3)] = rng.randbytes(rng.randrange(3))
        told += bool(broken("arrays", Arrays(TRACE, bytes(damaged), members, {"sequential": (0,)})))
    assert told > 500


def test_damaged_arrays_are_never_read_as_others() -> None:
    whole, rng = arrays(actions=np.zeros((50, 3)), returns=np.arange(5.0)), random.Random(3)
    good = {"actions": np.zeros((50, 3)).tolist(), "returns": [0.0, 1.0, 2.0, 3.0, 4.0]}
    assert {name: values.tolist() for name, values in (npz.read(whole) or {}).items()} == good
    for _ in range(1500):
        damaged = bytearray(whole)
        place = rng.randrange(len(damaged))
        damaged[place] ^= rng.randrange(1, 256)
        found = npz.read(bytes(damaged))
        assert found is None or all(values.tolist() == good[name] for name, values in found.items())
