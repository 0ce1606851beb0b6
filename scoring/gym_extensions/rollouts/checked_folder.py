"""A submission's folder whose parts are checked by the rules while they are read."""

from __future__ import annotations

from typing import Any

from gym_extensions.rollouts import layout, rules
from gym_extensions.rollouts.folder import Folder
from gym_extensions.rollouts.problem import Problem
from gym_extensions.rollouts.reading.csv_lines import Text, columns
from gym_extensions.rollouts.reading.evaluation_log import Cells
from gym_extensions.rollouts.reading.salvage import readable_rows
from gym_extensions.rollouts.rules.folder import UnreadableFile
from gym_extensions.rollouts.rules.rule import Scope

MAX_HEADER = 1000
"""Bytes in which the header of a CSV file is looked for."""


class CheckedFolder:
    """Reads files of a folder, applies the rules and collects the problems in ``problems``."""

    def __init__(self, folder: Folder) -> None:
        self.folder = folder
        self.problems: list[Problem] = []

    def cells_of(
        self, path: str, header: tuple[str, ...], other: tuple[str, ...] | None = None
    ) -> Cells | None:
        """The cells of a CSV file: of all rows, or of those that can be read.

        ``other`` is the expected header of a file with that number of columns.
        """
        data = self.bytes_of(path)
        if data is None:
            return None
        if other is not None and data[:MAX_HEADER].split(b"\n", 1)[0].count(b",") == len(other) - 1:
            header = other
        text = Text(path, header, data)
        if not self.passes("size", text):
            return None
        return Cells(path, columns(text)) if self.passes("text", text) else readable_rows(text)

    def bytes_of(self, path: str) -> bytes | None:
        """The bytes of a file; None if there is none, it is too large, or it cannot be read (a problem)."""
        file = self.folder.files.get(path)
        if file is None or file.size > layout.max_bytes(path):
            return None
        try:
            return self.folder.read(path)
        except OSError as error:
            self.passes("unreadable", UnreadableFile(path, error.strerror or type(error).__name__))
            return None

    def passes(self, scope: Scope, subject: Any) -> bool:
        """Checks the rules of a scope, collects their problems, and returns whether there are none."""
        problems = rules.problems(scope, subject)
        self.problems += problems
        return not problems
