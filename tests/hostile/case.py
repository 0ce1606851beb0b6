"""A hostile folder as data: how a valid submission is changed, how it is judged, and what is expected."""

from __future__ import annotations

import io
import struct
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from ..rollouts.examples import GROUP, TOML, Change, all_of, arrays, edit, remove
from ..rollouts.examples import cell as cell_of
from ..rollouts.examples import lines as lines_of

__all__ = [
    "GROUP",
    "LOG",
    "TOML",
    "TRACE",
    "Case",
    "all_of",
    "arrays",
    "cell",
    "edit",
    "lines",
    "put",
    "remove",
]

LOG = f"{GROUP}/single.csv"
TRACES = f"{GROUP}/traces"
POLICIES = f"{GROUP}/policies"
TRACE = f"{TRACES}/single-run0-stage1-HopperGravityHalf-episode3.npz"
POLICY = f"{POLICIES}/single-run0-stage1-HopperGravityHalf.npz"


def cell(number: int, column: int, value: str) -> Change:
    """Writes another value into one cell of the log; the header is row 1."""
    return cell_of(number, column, value, LOG)


def lines(change_rows: Callable[[list[str]], list[str]]) -> Change:
    """Changes the list of data rows of the log."""
    return lines_of(change_rows, LOG)


@dataclass(frozen=True)
class Case:
    """A change of a valid submission, the rules that it breaks, and the command that judges it.

    Without rules, the folder is accepted. ``name`` is that of the folder.
    """

    title: str
    change: Change
    rules: tuple[str, ...] = ()
    command: str = "score"
    name: str = "entry"


def put(path: str, data: bytes | Callable[[], bytes]) -> Change:
    """Writes a file; large contents are made when the case is tested."""

    def change(folder: Path) -> None:
        target = folder / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.unlink(missing_ok=True)  # traces of the valid submission are links to one file
        target.write_bytes(data if isinstance(data, bytes) else data())

    return change


def manifest(addition: str, section: str = "") -> Change:
    """Appends text to submission.toml, or adds lines to one of its sections."""
    if not section:
        return lambda folder: (folder / TOML).write_text((folder / TOML).read_text() + addition)
    return edit(f"[{section}]\n", f"[{section}]\n{addition}\n", TOML)


def value(key: str, new: str) -> Change:
    """Gives a key of submission.toml another value, as TOML."""

    def change(folder: Path) -> None:
        text = (folder / TOML).read_text().splitlines()
        changed = [f"{key} = {new}" if line.split(" =")[0] == key else line for line in text]
        assert changed != text
        (folder / TOML).write_text("\n".join(changed) + "\n", encoding="utf-8")

    return change


def npy(descr: str, shape: str, data: bytes = b"", version: bytes = b"\x01\x00") -> bytes:
    """A .npy file with this header."""
    header = f"{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}\n".encode()
    return (
        b"\x93NUMPY"
        + version
        + struct.pack("<H" if version == b"\x01\x00" else "<I", len(header))
        + header
        + data
    )


def zipped(members: dict[str, bytes], compression: int = zipfile.ZIP_DEFLATED) -> bytes:
    """A zip archive of these members, compressed fast."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", compression, compresslevel=1) as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return stream.getvalue()
