"""The log of a run (``run3.csv``): its rows, their writer and reader. All runs of a group as columns."""

from __future__ import annotations

import io
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.errors import BenchError
from gym_extensions.files import write_text
from gym_extensions.submissions import layout, problem

if TYPE_CHECKING:
    import pandas as pd

LOG_COLUMNS = ("stage", "task", "episode", "seed", "length", "return", "terminated", "success")
INTEGERS = ("stage", "episode", "seed", "length")
SUCCESSES = {"true": 1, "false": 0, "": -1}
"""The number of each cell of the column ``success``: -1 where the task defines none."""
BOM = b"\xef\xbb\xbf"
MAX_ROW = 1000
"""Most characters of a row."""
FOREIGN = re.compile(rb"[^A-Za-z0-9,./_\n+-]")
"""A character that no cell contains."""
CELLS = {
    **dict.fromkeys(INTEGERS, ("-?[0-9]{1,18}", "an integer")),
    "task": ("[A-Za-z0-9./_+-]++", "a task id"),
    "return": (r"[+-]?([0-9]++\.?[0-9]*+|\.[0-9]++)([eE][+-]?[0-9]++)?|[+-]?inf|nan", "a number"),
    "terminated": ("true|false", "true or false"),
    "success": ("(true|false)?", "true, false or nothing"),
}
"""By column: what a cell must be, as an expression and in words."""
HEADER = ",".join(LOG_COLUMNS)
ROW = ",".join(f"({CELLS[name][0]})" for name in LOG_COLUMNS)
FILE = re.compile(f"{HEADER}\n({ROW}\n)++".encode())
"""A whole log. Its quantifiers give nothing back, so that no file needs more than linear time."""


@dataclass(frozen=True)
class Episode:
    """One evaluation episode, one row of a run's log.

    ``stage`` is the number of tasks trained so far (0 untrained; 1 where the protocol has one stage),
    ``return_`` the ``math.fsum`` of all rewards, ``terminated`` whether the task ended it (else the time
    limit did), ``success`` the ``is_success`` of its last step, or None where the task defines none.
    """

    stage: int
    task: str
    episode: int
    seed: int
    length: int
    return_: float
    terminated: bool
    success: bool | None


@dataclass(frozen=True, repr=False)
class Log:
    """The logs of the runs of a group and protocol, run after run in the order of the files.

    ``rows`` are those of :func:`log_frame` with two more columns: ``run``, and ``position``, the index of the
    row's task in the group, -1 for a task of another group.
    """

    protocol: str
    group: TaskGroup
    rows: pd.DataFrame

    def __repr__(self) -> str:
        return f"Log({self.path!r}, runs={self.runs}, {len(self.rows)} episodes)"

    @property
    def runs(self) -> tuple[int, ...]:
        """The runs that have rows, ascending."""
        return tuple(self.rows["run"].unique().tolist())

    @property
    def path(self) -> str:
        """The folder of the files inside the submission."""
        return f"{self.group.name}/{self.protocol}"


class TableError(ValueError):
    """A log that cannot be read: the first wrong line, and what is wrong with it."""

    def __init__(self, line: int, message: str) -> None:
        super().__init__(f"Line {line}: {message}")
        self.line, self.message = line, message


def log_text(episodes: Iterable[Episode], task_ids: tuple[str, ...]) -> str:
    """The text of a run's log, sorted by stage, task in the order of the group and episode."""
    flags, lines = {None: "", True: "true", False: "false"}, [HEADER]
    for row in sorted(episodes, key=lambda row: (row.stage, task_ids.index(row.task), row.episode)):
        numbers = f"{row.stage},{row.task},{row.episode},{row.seed},{row.length},{row.return_!r}"
        lines.append(f"{numbers},{flags[row.terminated]},{flags[row.success]}")
    return "\n".join([*lines, ""])


def write_log(path: Path, episodes: Iterable[Episode], task_ids: tuple[str, ...]) -> None:
    """Writes the log of a run, sorted by stage, task in the order of the group and episode."""
    write_text(path, log_text(episodes, task_ids))


def log_frame(data: bytes) -> pd.DataFrame:
    """The rows in the content of a run's log, with the columns ``LOG_COLUMNS``.

    ``terminated`` is bool, ``success`` int8 (1, 0, or -1 where the cell is empty), ``task`` str. Raises
    ``TableError`` if a line is not one of a log.
    """
    import pandas as pd

    if not FILE.fullmatch(data):
        raise _first_error(data)
    dtypes = {name: "int64" if name in INTEGERS else "str" for name in LOG_COLUMNS}
    frame = pd.read_csv(io.BytesIO(data), dtype=dtypes, na_filter=False)
    frame["terminated"] = np.array([cell == "true" for cell in frame["terminated"].tolist()])
    frame["success"] = np.array([SUCCESSES[cell] for cell in frame["success"].tolist()], np.int8)
    frame["return"] = np.array([float(cell) for cell in frame["return"].tolist()])  # exact in every pandas
    return frame


def read_log(path: Path) -> pd.DataFrame:
    """The rows of a run's log, as :func:`log_frame`.

    Raises:
        BenchError: the file cannot be read, or a line, which is named, is not one of a log.
    """
    try:
        return log_frame(layout.read_regular(path, layout.max_bytes(layout.LOG)))
    except TableError as error:
        hint = "Restore the file, or remove the files of this run and train it again."
        raise BenchError("bad-log", error.message, f"{path}, line {error.line}", hint) from None
    except OSError as error:
        message = f"The file cannot be read: {error.strerror or type(error).__name__}."
        raise BenchError("bad-log", message, str(path), "Add read permission, or copy it again.") from error


def _first_error(data: bytes) -> TableError:
    header, *rows = data.split(b"\n")
    if header != HEADER.encode():
        is_marked = "a byte order mark (EF BB BF) and " if data.startswith(BOM) else ""
        stated = f"{is_marked}{_quoted(header.removeprefix(BOM))}"
        hint = f" {layout.CLONE}" if header.endswith(b"\r") else ""
        return TableError(1, f"The header is {stated}; expected {HEADER}.{hint}")
    if not any(rows):
        return TableError(1, "The file has a header but no rows.")
    for number, row in enumerate(rows if rows[-1] else rows[:-1], 2):
        if error := _row_error(row):
            return TableError(number, error)
    return TableError(len(rows) + 1, f"The last line, {_quoted(rows[-1])}, has no line end.")


def _row_error(row: bytes) -> str:
    if len(row) > MAX_ROW:
        return f"The row has more than {MAX_ROW} characters."
    if foreign := FOREIGN.search(row):
        character = row[foreign.start() : foreign.start() + 4].decode("utf-8", "backslashreplace")[:1]
        return f"The row contains the character {character!r}."
    cells = row.decode("ascii").split(",")
    if len(cells) != len(LOG_COLUMNS):
        return f"The row has {problem.count(len(cells), 'cell')}; expected {len(LOG_COLUMNS)}."
    for name, cell in zip(LOG_COLUMNS, cells, strict=True):
        expression, kind = CELLS[name]
        if not re.fullmatch(expression, cell):
            return f"Column `{name}` is {cell[:40]!r}; expected {kind}."
    return ""


def _quoted(line: bytes) -> str:
    return repr(line[:80].decode("ascii", "backslashreplace"))


def log_of(frames: Mapping[int, pd.DataFrame], protocol: str, group: TaskGroup) -> Log:
    """The log of the runs of a group and protocol, of which ``frames`` has the rows; at least one."""
    import pandas as pd

    rows = pd.concat([frames[run].assign(run=run) for run in sorted(frames)], ignore_index=True)
    positions = {task: position for position, task in enumerate(group.task_ids)}
    rows["position"] = np.array([positions.get(task, -1) for task in rows["task"].tolist()], dtype=np.int64)
    return Log(protocol, group, rows)
