"""Hostile .npz files: archives, the headers of their arrays, and sizes."""

from __future__ import annotations

import zipfile

from gym_extensions.rollouts.layout import MAX_UNPACKED_BYTES

from .case import TRACE, Case, npy, put, zipped

PICKLE = b"\x80\x04cos\nsystem\n(S'true'\ntR."
MALFORMED = ("malformed-arrays",)


def declares(size: int) -> bytes:
    """An archive whose directory declares another size than the member has."""
    data = bytearray(zipped({"a.npy": npy("'<f8'", "(1,)", bytes(8))}))
    start = data.rindex(b"PK\x01\x02")
    data[start + 24 : start + 28] = size.to_bytes(4, "little")
    return bytes(data)


def overlapping() -> bytes:
    """An archive whose 200 names share the data of one member."""
    single = zipped({"a.npy": npy("'<f8'", "(524288,)", bytes(2**22))})
    start, end = single.rindex(b"PK\x01\x02"), single.rindex(b"PK\x05\x06")
    directory = bytearray(single[start:end])
    count = 200
    tail = bytearray(single[end:])
    tail[8:10] = tail[10:12] = count.to_bytes(2, "little")
    tail[12:16] = (count * len(directory)).to_bytes(4, "little")
    return single[:start] + bytes(directory) * count + bytes(tail)


CASES = (
    Case("a trace of null bytes", put(TRACE, bytes(2**20)), MALFORMED),
    Case("an empty trace", put(TRACE, b""), MALFORMED),
    Case("a trace of the largest size", put(TRACE, lambda: bytes(4 * 2**20)), MALFORMED),
    Case("a trace that is larger", put(TRACE, lambda: bytes(4 * 2**20 + 1)), ("too-large",)),
    Case(
        "the beginning of an archive",
        put(TRACE, lambda: zipped({"a.npy": npy("'<f8'", "(1,)", bytes(8))})[:-30]),
        MALFORMED,
    ),
    Case(
        "an archive with text before it",
        put(TRACE, lambda: b"#!/bin/sh\n" + zipped({"a.npy": npy("'<f8'", "(1,)", bytes(8))})),
        (),
    ),
    Case("a pickle", put(TRACE, lambda: zipped({"a.npy": npy("'|O'", "(1,)", PICKLE)})), ("pickled-arrays",)),
    Case("a pickle without an archive", put(TRACE, PICKLE), MALFORMED),
    Case(
        "an array of 256 MiB of zeros",
        put(TRACE, lambda: zipped({"a.npy": npy("'<f8'", f"({2**25},)", bytes(2**28))})),
        ("unpacks-too-large",),
    ),
    Case(
        "arrays just above the limit",
        put(
            TRACE,
            lambda: zipped({"a.npy": npy("'|u1'", f"({MAX_UNPACKED_BYTES},)", bytes(MAX_UNPACKED_BYTES))}),
        ),
        ("unpacks-too-large",),
    ),
    Case(
        "a header that states 2 to the 48th values",
        put(TRACE, lambda: zipped({"a.npy": npy("'<f8'", f"({2**47},)", bytes(8))})),
        ("malformed-array",),
    ),
    Case(
        "a header of negative lengths",
        put(TRACE, lambda: zipped({"a.npy": npy("'<f8'", "(-1, -1)", bytes(8))})),
        ("malformed-array",),
    ),
    Case(
        "a header of 10,000 dimensions",
        put(TRACE, lambda: zipped({"a.npy": npy("'<f8'", f"({'1,' * 10_000})", bytes(8))})),
        ("malformed-array",),
    ),
    Case(
        "a header of nested brackets",
        put(TRACE, lambda: zipped({"a.npy": npy("'<f8'", "(" * 2000, bytes(8))})),
        ("malformed-array",),
    ),
    Case(
        "a header that calls a function",
        put(TRACE, lambda: zipped({"a.npy": npy("__import__('os').getpid()", "()", bytes(8))})),
        ("malformed-array",),
    ),
    Case(
        "a header of structured values",
        put(TRACE, lambda: zipped({"a.npy": npy("[('a', '<f8')]", "(1,)", bytes(8))})),
        ("malformed-array",),
    ),
    Case(
        "a header of another version",
        put(TRACE, lambda: zipped({"a.npy": npy("'<f8'", "(1,)", bytes(8), b"\x03\x00")})),
        ("malformed-array",),
    ),
    Case(
        "an archive of 300 arrays",
        put(TRACE, lambda: zipped({f"a{i}.npy": npy("'<f8'", "(1,)", bytes(8)) for i in range(300)})),
        ("unpacks-too-large",),
    ),
    Case(
        "an archive of 60,000 names",
        put(TRACE, lambda: zipped({f"{i}": b"" for i in range(30_000)}, zipfile.ZIP_STORED)),
        ("malformed-array", "malformed-arrays", "unpacks-too-large"),
    ),
    Case(
        "an archive whose names share their data",
        put(TRACE, overlapping),
        ("repeated-array", "unpacks-too-large"),
    ),
    Case("a directory that declares less", put(TRACE, declares(1)), ("malformed-array",)),
    Case(
        "a directory that declares more",
        put(TRACE, declares(2**31)),
        ("malformed-array", "unpacks-too-large"),
    ),
    Case(
        "a name with two dots",
        put(TRACE, lambda: zipped({"../a.npy": npy("'<f8'", "(1,)", bytes(8))})),
        MALFORMED,
    ),
    Case(
        "a name that is absolute",
        put(TRACE, lambda: zipped({"/etc/a.npy": npy("'<f8'", "(1,)", bytes(8))})),
        MALFORMED,
    ),
    Case(
        "a name of 60,000 letters",
        put(TRACE, lambda: zipped({"a" * 60_000 + ".npy": npy("'<f8'", "(1,)", bytes(8))})),
        (),
    ),
    Case(
        "another compression",
        put(TRACE, lambda: zipped({"a.npy": npy("'<f8'", "(1,)", bytes(8))}, zipfile.ZIP_LZMA)),
        ("foreign-compression",),
    ),
)
