"""Rules about .npz files: arrays of numbers, in bounds, never a pickle."""

from __future__ import annotations

import io
import pickle
import random
import zipfile

import numpy as np

from gym_extensions.scoring.checks import broken
from gym_extensions.scoring.checks.arrays import Arrays

from .broken import GROUP, TRACE, Broken, Judge, arrays, each, put


def bomb() -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive, archive.open("a.npy", "w") as member:
        np.lib.format.write_array(member, np.zeros(2**25 + 1, np.int8))
        for _ in range(7):
            member.write(bytes(2**25))
    return stream.getvalue()


def bare_pickle() -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        archive.writestr("weights.npy", pickle.dumps([1])[:5])
    return stream.getvalue()


BROKEN = (
    Broken(
        "malformed-arrays",
        "a trace that is no archive",
        put(TRACE, b"not a zip"),
        (
            (
                TRACE,
                "It is no .npz file: File is not a zip file.",
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
        "pickled-arrays",
        "a bare pickle in the archive",
        put(f"{GROUP}/policies/run0.npz", bare_pickle()),
        (
            (
                f"{GROUP}/policies/run0.npz",
                "'weights.npy' cannot be read: EOF: reading magic string, expected 8 bytes got 5.",
                "Write it with numpy.savez_compressed.",
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
    told = 0
    for _ in range(1500):
        damaged = bytearray(whole)
        for _ in range(rng.choice((1, 2, 20))):
            place = rng.randrange(len(damaged))
            damaged[place : place + rng.randrange(3)] = rng.randbytes(rng.randrange(3))
        told += bool(broken("arrays", Arrays(TRACE, bytes(damaged), {"sequential": (0,)})))
    assert told > 500
