"""A complete log, known by its bytes: without the measured cells, they are what the protocol prescribes.

Nearly every log is as ``log.write_episodes`` writes it. Comparing its bytes is much faster than cutting them
into cells; a log that differs in one byte is cut into cells (rows.py), which comes to the same log or to
problems.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from itertools import product
from string import ascii_letters, digits

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.errors import BenchError
from gym_extensions.catalog.fingerprints import published
from gym_extensions.catalog.groups import TaskGroup, group
from gym_extensions.catalog.protocol import EVALUATION_EPISODES, evaluation_seed
from gym_extensions.scoring.log import EPISODE_COLUMNS
from gym_extensions.scoring.rows import FLAGS, Log, Whole, per_run, stages

HEADER = (",".join(EPISODE_COLUMNS) + "\n").encode()
MEASURED = ("length", "return", "terminated")
FIRST = EPISODE_COLUMNS.index(MEASURED[0])
COMMAS = len(EPISODE_COLUMNS) - 1
RUN = b"\0"
"""Stands for the run in the prescribed rows."""
LONGEST = 16
"""More bytes than a run's number has."""
PLAIN = (ascii_letters + digits + ",.+-").encode()


@dataclass(frozen=True)
class Prescribed:
    """One run's rows without the measured cells: as bytes with ``RUN`` for the run, and by column."""

    rows: bytes
    task: list[str]
    fingerprint: list[str]
    numbers: dict[str, Whole]


@functools.lru_cache(maxsize=128)
def _prescribed(protocol: str, group_id: str) -> Prescribed | None:
    """The prescribed rows of a group; None where a task has no published fingerprint."""
    ids = group(group_id).task_ids
    try:
        fingerprints = [str(published(task)) for task in ids]
    except BenchError:
        return None
    keys = list(product(stages(protocol, len(ids)), range(len(ids)), range(EVALUATION_EPISODES)))
    numbers = {
        "stage": [stage for stage, _, _ in keys],
        "position": [position for _, position, _ in keys],
        "episode": [episode for _, _, episode in keys],
        "seed": [evaluation_seed(group_id, ids[position], episode) for _, position, episode in keys],
    }
    rows = [
        f",{stage},{ids[position]},{episode},{seed},{fingerprints[position]}\n"
        for (stage, position, episode), seed in zip(keys, numbers["seed"], strict=True)
    ]
    return Prescribed(
        b"".join(RUN + row.encode() for row in rows),
        [ids[position] for _, position, _ in keys],
        [fingerprints[position] for _, position, _ in keys],
        {name: np.array(column, dtype=np.int64) for name, column in numbers.items()},
    )


def _measured(body: bytes) -> tuple[NDArray[np.uint8], NDArray[np.bool_], NDArray[np.intp]] | None:
    """The body's bytes, which of them are measured cells with their commas, and each row's first byte."""
    values = np.frombuffer(body, dtype=np.uint8)
    ends = np.flatnonzero(values == ord("\n"))
    commas = np.flatnonzero(values == ord(","))
    if not ends.size or ends[-1] != values.size - 1 or commas.size != COMMAS * ends.size:
        return None
    edges = commas.reshape(-1, COMMAS)[:, [FIRST - 1, FIRST - 1 + len(MEASURED)]].ravel() + 1
    lengths = np.diff(edges, prepend=0, append=values.size)
    inside = np.repeat(np.arange(lengths.size) % 2 == 1, lengths)
    return values, inside, np.concatenate([[0], ends[:-1] + 1])


def _runs(body: bytes, starts: NDArray[np.intp]) -> tuple[int, ...] | None:
    """The runs that begin in these places, if each is a number and they grow."""
    cells = [body[start : start + LONGEST].split(b",")[0] for start in starts.tolist()]
    if not all(cell.isdigit() and str(int(cell)).encode() == cell for cell in cells):
        return None
    runs = tuple(map(int, cells))
    return runs if list(runs) == sorted(set(runs)) else None


def prescribed_log(path: str, data: bytes, protocol: str, group: TaskGroup) -> Log | None:
    """The log in a file's bytes; None where it is not exactly as prescribed, or a measured cell is odd.

    Args:
        path: the file, inside the submission.
        data: its bytes.
        protocol: sequential, single or joint.
        group: whose log it is.
    """
    once, size = _prescribed(protocol, group.id), per_run(protocol, group)
    body = data[len(HEADER) :]
    if once is None or not data.startswith(HEADER) or (cut := _measured(body)) is None:
        return None
    values, inside, starts = cut
    runs = _runs(body, starts[::size])
    if runs is None or starts.size != size * len(runs):
        return None
    expected = b"".join(once.rows.replace(RUN, str(run).encode()) for run in runs)
    measured = values[inside].tobytes()
    if values[~inside].tobytes() != expected or measured.translate(None, PLAIN):
        return None
    cells = measured.decode("ascii").split(",")
    try:
        length, return_, ended = (cells[place : -1 : len(MEASURED)] for place in range(len(MEASURED)))
        return Log(
            path=path,
            protocol=protocol,
            group=group,
            runs=runs,
            run=np.repeat(np.array(runs, dtype=np.int64), size),
            task=once.task * len(runs),
            length=np.array(list(map(int, length)), dtype=np.int64),
            return_=np.array(list(map(float, return_)), dtype=np.float64),
            terminated=np.array([FLAGS[cell] for cell in ended], dtype=np.bool_),
            fingerprint=once.fingerprint * len(runs),
            numbers=None,
            unread=0,
            **{name: np.tile(column, len(runs)) for name, column in once.numbers.items()},
        )
    except (ValueError, KeyError, OverflowError):
        return None
