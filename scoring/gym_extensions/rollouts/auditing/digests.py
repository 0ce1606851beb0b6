"""The digest by which a log commits to the trace of an episode, and the root of all of them."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

DIGITS = 32
"""Hexadecimal digits of a trace's digest: 128 bits of a SHA-256."""
DIGEST = re.compile(rf"[0-9a-f]{{{DIGITS}}}")
LEAF, NODE = b"\x00", b"\x01"
"""Prefixes of hashed leaves and inner nodes, as in RFC 6962, so that neither passes as the other."""


def trace_digest(
    arrays: Mapping[str, NDArray[Any]], length: int, return_: float, terminated: bool, success: bool | None
) -> str:
    """The first 32 hexadecimal digits of the SHA-256 of a trace in canonical form.

    The form does not depend on the compression of the file: a line with the length, return, ``terminated``
    and ``success`` as in the log's row, separated by commas; then every array, sorted by name: a line with
    its name, type and shape, and its values in C order, little-endian.

    Args:
        arrays: the arrays of the trace by name.
        length: number of steps.
        return_: sum of the rewards, as in the log.
        terminated: whether the task ended the episode.
        success: None where the task defines no success.
    """
    outcome = (str(length), repr(return_), str(terminated), "" if success is None else str(success))
    digest = hashlib.sha256(f"{','.join(outcome).lower()}\n".encode())
    for name in sorted(arrays):
        values = np.ascontiguousarray(arrays[name], arrays[name].dtype.newbyteorder("<"))
        shape = ",".join(map(str, arrays[name].shape))
        digest.update(f"{name} {values.dtype.str} {shape}\n".encode())
        digest.update(values.tobytes())
    return digest.hexdigest()[:DIGITS]


def merkle_root(digests: Sequence[str]) -> str:
    """The root of the Merkle tree over the digests in order, as 64 hexadecimal digits.

    A leaf is SHA-256(0x00 · digest), an inner node SHA-256(0x01 · left · right), with the 16 bytes of each
    digest and the 32 bytes of each node. A node without a neighbor moves up as it is. This is the tree of RFC
    6962; without digests the root is the SHA-256 of nothing.

    Example:
        >>> merkle_root(["00" * 16])
        '0a88111852095cae045340ea1f0b279944b2a756a213d9b50107d7489771e159'
    """
    level = [hashlib.sha256(LEAF + bytes.fromhex(digest)).digest() for digest in digests]
    while len(level) > 1:
        pairs = [
            hashlib.sha256(NODE + left + right).digest()
            for left, right in zip(level[::2], level[1::2], strict=False)
        ]
        level = pairs + ([level[-1]] if len(level) % 2 else [])
    return level[0].hex() if level else hashlib.sha256().hexdigest()
