"""A complete log, known by its bytes: without the measured cells, they are what the protocol prescribes.

Nearly every log is as ``log.write_episodes`` writes it. Comparing its bytes is much faster than cutting them
into cells; a log that differs in one byte is cut into cells (rows.py), which comes to the same log or to
problems.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from string import ascii_letters, digits
from typing import Any

import numpy as np
import orjson

from gym_extensions.catalog.fingerprints import published
from gym_extensions.catalog.groups import TaskGroup, group
from gym_extensions.catalog.protocol import EVALUATION_EPISODES, evaluation_seed, per_run, stages
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.episodes import EPISODE_COLUMNS
from gym_extensions.rollouts.reading.evaluation_log import Log, Whole

HEADER = (",".join(EPISODE_COLUMNS) + "\n").encode()
MEASURED = {"length": int, "return": float, "terminated": bool}
"""The measured columns, and what each of their cells is as a value of JSON."""
FIRST = EPISODE_COLUMNS.index(next(iter(MEASURED)))
COMMAS = len(EPISODE_COLUMNS) - 1
RUN = b"\0"
"""Stands for the run in the prescribed rows."""
LONGEST = 16
"""More bytes than a run's number has."""
KEYS = ("stage", "position", "episode", "seed")
PLAIN = (ascii_letters + digits + ",.+-").encode()


@dataclass(frozen=True)
class Prescribed:
    """One run's rows without the measured cells: as bytes with ``RUN`` for the run, and by column.

    ``first`` is how the first row goes on after the run.
    """

    rows: bytes
    first: bytes
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
        rows[0].rpartition(",")[0].encode(),
        [ids[position] for _, position, _ in keys],
        [fingerprints[position] for _, position, _ in keys],
        {name: np.array(column, dtype=np.int64) for name, column in numbers.items()},
    )


def _places(data: bytes, wanted: bytes) -> Iterator[int]:
    """Where in the data the wanted bytes begin."""
    place = data.find(wanted)
    while place >= 0:
        yield place
        place = data.find(wanted, place + 1)


def _by_run(data: bytes, first: bytes) -> dict[int, memoryview] | None:
    """The rows of every run, which begins with this text behind its number; None where runs do not grow.

    A run's rows at a time fit into a processor's cache.
    """
    marks = list(_places(data, first))
    starts = [data.rfind(b"\n", max(0, mark - LONGEST), mark) + 1 for mark in marks]
    cells = [data[start:mark] for start, mark in zip(starts, marks, strict=True)]
    if not all(len(cell) < LONGEST and cell.isdigit() and b"%d" % int(cell) == cell for cell in cells):
        return None
    runs = list(map(int, cells))
    if not runs or starts[0] != len(HEADER) or runs != sorted(set(runs)):
        return None
    ends = [*starts[1:], len(data)]
    return {run: memoryview(data)[start:end] for run, start, end in zip(runs, starts, ends, strict=True)}


def _measured(rows: memoryview, expected: bytes) -> bytes | None:
    """The measured cells with their commas; None where the other bytes are not the expected ones."""
    values = np.frombuffer(rows, dtype=np.uint8)
    commas = np.flatnonzero(values == ord(","))
    if commas.size % COMMAS:
        return None
    edges = commas.reshape(-1, COMMAS)[:, [FIRST - 1, FIRST - 1 + len(MEASURED)]].ravel() + 1
    lengths = np.diff(edges, prepend=0, append=values.size)
    inside = np.repeat(np.arange(lengths.size) % 2 == 1, lengths)
    return values[inside].tobytes() if values[~inside].tobytes() == expected else None


def _columns(measured: bytes) -> list[list[Any]] | None:
    """The measured cells as values, by column; None where one is written in another way than its column's.

    Numbers and truth values are written in a log as in JSON, and orjson rounds them as ``float`` does.
    """
    if measured.translate(None, PLAIN):
        return None
    try:
        values = orjson.loads(b"[%s]" % measured.removesuffix(b","))
    except orjson.JSONDecodeError:
        return None
    columns = [values[place :: len(MEASURED)] for place in range(len(MEASURED))]
    kinds = zip(columns, MEASURED.values(), strict=True)
    return columns if all(set(map(type, column)) == {kind} for column, kind in kinds) else None


def prescribed_log(path: str, data: bytes, protocol: str, group: TaskGroup) -> Log | None:
    """The log in a file's bytes; None where it is not exactly as prescribed, or a measured cell is odd.

    Args:
        path: the file, inside the submission.
        data: its bytes.
        protocol: sequential, single or joint.
        group: whose log it is.
    """
    once = _prescribed(protocol, group.id)
    if once is None or not data.startswith(HEADER):
        return None
    rows = _by_run(data, once.first)
    if rows is None:
        return None
    found = [_measured(own, once.rows.replace(RUN, b"%d" % run)) for run, own in rows.items()]
    if None in found or (columns := _columns(b"".join(filter(None, found)))) is None:
        return None
    runs, size = tuple(rows), per_run(protocol, group)
    length, return_, ended = columns
    stage, position, episode, seed = (np.tile(once.numbers[key], len(runs)) for key in KEYS)
    try:
        return Log(
            path=path,
            protocol=protocol,
            group=group,
            runs=runs,
            run=np.repeat(np.array(runs, dtype=np.int64), size),
            task=once.task * len(runs),
            length=np.array(length, dtype=np.int64),
            return_=np.array(return_, dtype=np.float64),
            terminated=np.array(ended, dtype=np.bool_),
            fingerprint=once.fingerprint * len(runs),
            stage=stage,
            position=position,
            episode=episode,
            seed=seed,
        )
    except OverflowError:
        return None
