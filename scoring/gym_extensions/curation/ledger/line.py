"""One line of the ledger, and its only spelling as JSON."""

from __future__ import annotations

import hashlib
import json
import re
from dataclasses import dataclass
from datetime import date
from typing import Annotated, Literal

import msgspec

from gym_extensions.errors import BenchError
from gym_extensions.rollouts.layout import NAME
from gym_extensions.scoring.scorecard.record import Level

Event = Literal["accepted", "rescored", "challenged", "superseded", "withdrawn"]
EVENTS: tuple[Event, ...] = ("accepted", "rescored", "challenged", "superseded", "withdrawn")
LEVELS: tuple[Level, ...] = ("reported", "validated", "replayed", "re-evaluated", "reproduced")
SHA256 = "^[0-9a-f]{64}$"
START = "0" * 64
"""What the first line has in place of the SHA-256 of a line before it."""
MAX_REASON = 1000
"""Characters of a reason."""
MAX_LINE = 8192
"""Bytes of a line."""

Sha256 = Annotated[str, msgspec.Meta(pattern=SHA256)]
Count = Annotated[int, msgspec.Meta(ge=0, le=10**9)]


@dataclass(frozen=True, slots=True, kw_only=True)
class LedgerLine:
    """An event in the life of an entry.

    ``previous`` is the SHA-256 of the line before, its ``\\n`` included. ``references`` is the SHA-256 of
    the references' file that the scorer used. ``salt`` is empty, or derived from ``value`` and the digest of
    the files without the traces.
    """

    previous: Sha256
    date: Annotated[str, msgspec.Meta(pattern=r"^\d{4}-\d{2}-\d{2}$")]
    event: Event
    entry: str
    reason: Annotated[str, msgspec.Meta(min_length=1, max_length=MAX_REASON)]
    digest: Sha256
    level: Level
    replayed: Count
    episodes: Count
    scorer: Annotated[str, msgspec.Meta(min_length=1, max_length=100)]
    references: Sha256
    value: Annotated[str, msgspec.Meta(pattern="^([0-9a-f]{40,128})?$")]
    salt: str

    def encode(self) -> bytes:
        """The line as ASCII JSON with sorted keys, no spaces and ``\\n`` at the end."""
        text = json.dumps(msgspec.to_builtins(self), sort_keys=True, separators=(",", ":"))
        return f"{text}\n".encode("ascii")

    @property
    def sha256(self) -> str:
        """The SHA-256 of the encoded line."""
        return hashlib.sha256(self.encode()).hexdigest()


def _wrong(where: str, message: str, hint: str = "") -> BenchError:
    return BenchError("ledger-line", message, where, hint or "Write lines with `gym-extensions ledger add`.")


def require_salt(salt: str, where: str) -> None:
    """Raises BenchError unless a salt is empty or 64 lower-case hexadecimal digits."""
    if salt and not re.fullmatch(SHA256, salt):
        hint = "A salt is the SHA-256 that `check-pr` derives, or empty."
        raise BenchError("ledger-salt", f"The salt {salt[:80]!r} is malformed.", where, hint)


def check_values(line: LedgerLine, where: str) -> None:
    """Raises BenchError for a value that its type alone does not refuse."""
    require_salt(line.salt, where)
    if bool(line.salt) != bool(line.value):
        raise _wrong(where, "A salt and the value that it was derived from belong together.")
    if not NAME.fullmatch(line.entry):
        raise _wrong(where, f"{line.entry[:80]!r} is not a name of an entry.")
    try:
        date.fromisoformat(line.date)
    except ValueError:
        raise _wrong(where, f"{line.date!r} is not a date.") from None
    if not line.reason.isprintable() or not line.scorer.isprintable():
        raise _wrong(where, "The reason contains a control or invisible character.")
    if line.replayed > line.episodes:
        raise _wrong(where, f"{line.replayed} of {line.episodes} episodes cannot be replayed.")
    if (line.level in ("reported", "validated")) == bool(line.replayed):
        raise _wrong(where, f"The level {line.level} does not fit {line.replayed} replayed episodes.")


def decode(data: bytes, where: str) -> LedgerLine:
    """The line of its bytes.

    Args:
        data: the line with ``\\n`` at its end.
        where: the file and row, for the error.

    Raises:
        BenchError: the bytes are not a line, or have another spelling than ``LedgerLine.encode``.
    """
    if len(data) > MAX_LINE:
        raise _wrong(where, f"The line has {len(data)} bytes; the limit is {MAX_LINE}.")
    try:
        line = msgspec.json.decode(data, type=LedgerLine)
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise _wrong(where, f"The line cannot be read: {error}.") from None
    check_values(line, where)
    if line.encode() != data:
        message = "The line has unknown keys, or another spelling than the one of the format."
        raise _wrong(where, message)
    return line
