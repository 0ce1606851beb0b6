"""The salt of an audit sample: known only after the submission is fixed."""

from __future__ import annotations

import hashlib
import re

from gym_extensions.errors import BenchError

VALUE = re.compile(r"[0-9a-f]{40,128}")


def derive_salt(digest: str, value: str) -> str:
    """The SHA-256 of the digest of a submission followed by a value, both as hexadecimal text.

    Args:
        digest: the submission's digest.
        value: a number that nobody knew before the submission was fixed: the commit that merged it, or a
            round of a public random beacon. 40 to 128 lower-case hexadecimal digits.

    Raises:
        BenchError: the value is malformed.
    """
    if not VALUE.fullmatch(value):
        hint = "Pass the id of the merge commit, or a beacon's randomness: 40 to 128 digits 0-9 and a-f."
        raise BenchError("malformed-value", f"The value {value[:80]!r} is malformed.", "--value", hint)
    return hashlib.sha256(f"{digest}{value}".encode()).hexdigest()
