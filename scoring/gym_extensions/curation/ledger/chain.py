"""Reads a ledger and checks its chain: hashes, dates, and the order of each entry's events."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from gym_extensions.curation.ledger.line import START, LedgerLine, decode
from gym_extensions.errors import BenchError

FILE = "ledger.jsonl"
"""The ledger's file name, in the folder of the submissions."""
MAX_BYTES = 64 * 2**20
ACTIVE = ("accepted", "rescored", "challenged")
"""Events after which an entry is on the boards."""


@dataclass(frozen=True)
class EntryState:
    """An entry after some lines: its last line, and the line that accepted the present digest."""

    last: LedgerLine
    accepted: LedgerLine

    @property
    def active(self) -> bool:
        """Whether the entry is on the boards."""
        return self.last.event in ACTIVE


def parse(data: bytes, name: str = FILE) -> tuple[LedgerLine, ...]:
    """The lines of a ledger whose chain is whole.

    Raises:
        BenchError: a line cannot be read (``ledger-line``, ``ledger-salt``), does not hold the SHA-256 of
            the line before (``ledger-chain``), is earlier than it (``ledger-date``), or has an event that
            cannot follow the entry's last (``ledger-order``).
    """
    if len(data) > MAX_BYTES:
        raise BenchError("ledger-line", f"The ledger has more than {MAX_BYTES} bytes.", name)
    if data and not data.endswith(b"\n"):
        hint = "Restore the file from git."
        raise BenchError("ledger-line", "The last line has no line end; it may be incomplete.", name, hint)
    lines: list[LedgerLine] = []
    for number, text in enumerate(data.split(b"\n")[:-1], 1):
        where = f"{name}, row {number}"
        line = decode(text + b"\n", where)
        _check_link(lines[-1] if lines else None, line, where)
        lines.append(line)
    states(lines, name)
    return tuple(lines)


def _check_link(before: LedgerLine | None, line: LedgerLine, where: str) -> None:
    expected = before.sha256 if before else START
    if line.previous != expected:
        message = (
            f"`previous` is {line.previous[:12]}…, but the SHA-256 of the line before is {expected[:12]}…."
        )
        hint = "A line before it was edited, removed or added: restore the file from git, then append."
        raise BenchError("ledger-chain", message, where, hint)
    if before and line.date < before.date:
        hint = "Dates do not decrease."
        raise BenchError("ledger-date", f"{line.date} is before {before.date}.", where, hint)


def read(folder: Path) -> tuple[LedgerLine, ...]:
    """The lines of the ledger in a folder of submissions; none without the file. Raises as ``parse``."""
    path = folder / FILE
    if not path.is_file():
        return ()
    return parse(path.read_bytes(), str(path))


def follow(state: EntryState | None, line: LedgerLine, where: str) -> EntryState:
    """The state of an entry after a further line.

    Raises:
        BenchError: the line's event cannot follow, or its digest is not the accepted one.
    """
    active = state is not None and state.active
    if line.event == "accepted":
        if active:
            message = f"The entry {line.entry!r} was accepted already."
            hint = "Append `rescored` for the same files; for others append `superseded` first."
            raise BenchError("ledger-order", message, where, hint)
        return EntryState(line, line)
    if state is None or not active:
        message = f"The entry {line.entry!r} is not on the boards, so it cannot be {line.event}."
        raise BenchError("ledger-order", message, where, "Append `accepted` first.")
    if line.digest != state.accepted.digest:
        message = f"The digest {line.digest[:12]}… is not that of the accepted files of {line.entry!r}."
        hint = "Append `superseded` for the old files, then `accepted` for the new ones."
        raise BenchError("ledger-order", message, where, hint)
    return EntryState(line, state.accepted)


def states(lines: Iterable[LedgerLine], name: str = FILE) -> dict[str, EntryState]:
    """The state of every entry after the lines, by name. Raises as ``follow``.

    Names that differ only in case are one entry's: such a line is refused.
    """
    result: dict[str, EntryState] = {}
    spellings: dict[str, str] = {}
    for number, line in enumerate(lines, 1):
        where = f"{name}, row {number}"
        spelling = spellings.setdefault(line.entry.casefold(), line.entry)
        if spelling != line.entry:
            message = f"The names {spelling!r} and {line.entry!r} differ only in case."
            raise BenchError("ledger-order", message, where, "Rename the later entry.")
        result[line.entry] = follow(result.get(line.entry), line, where)
    return result
