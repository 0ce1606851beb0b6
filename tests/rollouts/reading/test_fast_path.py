"""A log is known by its bytes or else read cell by cell: the same log either way, and never half of one."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from gym_extensions.catalog.groups import group
from gym_extensions.rollouts.episodes import EPISODE_COLUMNS
from gym_extensions.rollouts.reader import read
from gym_extensions.rollouts.reading import evaluation_log as rows
from gym_extensions.rollouts.reading.csv_lines import Text, columns
from gym_extensions.rollouts.reading.evaluation_log import Cells, Log
from gym_extensions.rollouts.reading.fast_path import HEADER, prescribed_log
from gym_extensions.scoring.pipeline.score import score_folder
from gym_extensions.scoring.references import References

HOPPER = group("hopper-gravity")
PATH = "hopper-gravity/sequential.csv"
PROTOCOLS = ("sequential", "single")


def by_bytes(data: bytes, protocol: str = "sequential") -> Log | None:
    return prescribed_log(PATH, data, protocol, HOPPER)


def by_cells(data: bytes, protocol: str) -> Log:
    return rows.log(Cells(PATH, columns(Text(PATH, EPISODE_COLUMNS, data))), protocol, HOPPER)


def with_return(data: bytes, return_: bytes) -> bytes:
    """The log with another return in its first row."""
    header, row, rest = data.split(b"\n", 2)
    cells = row.split(b",")
    cells[EPISODE_COLUMNS.index("return")] = return_
    return b"\n".join([header, b",".join(cells), rest])


def same(one: Log, other: Log) -> bool:
    pairs = [(getattr(one, field.name), getattr(other, field.name)) for field in fields(Log)]
    return all(
        np.array_equal(a, b) and a.dtype == b.dtype if isinstance(a, np.ndarray) else a == b for a, b in pairs
    )


@pytest.fixture
def log(submission: Callable[..., Path]) -> bytes:
    """A good log of runs 2, 7 and 11, whose cells have all lengths."""
    return (submission(runs=(2, 7, 11)) / PATH).read_bytes()


@pytest.mark.parametrize("protocol", PROTOCOLS)
def test_the_bytes_and_the_cells_give_the_same_log(submission: Callable[..., Path], protocol: str) -> None:
    data = (submission(runs=(2, 7, 11)) / "hopper-gravity" / f"{protocol}.csv").read_bytes()
    known = by_bytes(data, protocol)
    assert known is not None
    assert known.runs == (2, 7, 11)
    assert same(known, by_cells(data, protocol))


HARD_TO_ROUND = [
    # Next to the middle between two doubles, below, at and above it.
    b"9007199254740992.999999999999999999999999999",
    b"9007199254740993.0",
    b"9007199254740993.000000000000000000000000001",
    b"1.00000000000000011102230246251565404236316680908203125",
    b"1.00000000000000011102230246251565404236316680908203124",
    b"1.00000000000000011102230246251565404236316680908203126",
    # The smallest doubles and the largest.
    b"-0.0",
    b"5e-324",
    b"2.4703282292062327208e-324",
    b"2.4703282292062327209e-324",
    b"2.2250738585072011e-308",
    b"1.7976931348623157e308",
    b"-1.7976931348623158e+308",
    b"6929495644600919.5",
    b"3.2E-7",
]


@pytest.mark.parametrize("cell", HARD_TO_ROUND)
def test_a_return_is_the_double_that_python_reads(log: bytes, cell: bytes) -> None:
    known = by_bytes(with_return(log, cell))
    assert known is not None
    assert repr(known.return_.tolist()[0]) == repr(float(cell))


def test_returns_of_any_size_are_the_doubles_that_python_reads(log: bytes) -> None:
    chosen = random.Random(0)
    rows = [row.split(b",") for row in log.splitlines()[1:]]
    place = EPISODE_COLUMNS.index("return")
    for cells in rows:
        digits = "".join(chosen.choices("0123456789", k=chosen.randint(1, 25)))
        cells[place] = f"{chosen.choice(['', '-'])}{chosen.randint(0, 9)}.{digits}".encode()
        cells[place] += chosen.choice([b"", f"e{chosen.randint(-320, 290)}".encode()])
    known = by_bytes(HEADER + b"\n".join([b",".join(cells) for cells in rows] + [b""]))
    assert known is not None
    assert known.return_.tolist() == [float(cells[place]) for cells in rows]


def test_any_other_byte_outside_the_measured_cells_is_noticed(log: bytes) -> None:
    body = log.decode().splitlines()[1:]
    chosen = random.Random(0)
    for _ in range(300):
        number, changed = chosen.randrange(len(body)), list(body)
        cells = body[number].split(",")
        place = chosen.choice([0, 1, 2, 3, 4, 8])
        at = chosen.randrange(len(cells[place]))
        other = chosen.choice([c for c in "0123456789abz./,\n" if c != cells[place][at]])
        cells[place] = cells[place][:at] + other + cells[place][at + 1 :]
        changed[number] = ",".join(cells)
        assert by_bytes(HEADER + "\n".join([*changed, ""]).encode()) is None, changed[number]


@pytest.mark.parametrize(
    "change",
    [
        lambda data: b"",
        lambda data: HEADER,
        lambda data: data[:-1],
        lambda data: data + b"\n",
        lambda data: data + data.splitlines(keepends=True)[-1],
        lambda data: data.replace(b"\n", b"\r\n"),
        lambda data: data.replace(b"length,return", b"return,length", 1),
        lambda data: b"".join(data.splitlines(keepends=True)[:-1]),
        lambda data: b"".join([HEADER, *sorted(data.splitlines(keepends=True)[1:])]),
        # A comma too many in one row and one too few in the next.
        lambda data: data.replace(b",false,", b",false,,", 1).replace(b",1000,", b"", 1),
        lambda data: data.replace(b",1000,", b",1 000,", 1),
        lambda data: data.replace(b",1000,", b",1_000,", 1),
        lambda data: data.replace(b",1000,", b",,", 1),
        lambda data: data.replace(b",1000,", b",99999999999999999999,", 1),
        lambda data: data.replace(b",false,", b",False,", 1),
        # Cells that are something in JSON, but not what their column holds.
        lambda data: with_return(data, b"12"),
        lambda data: with_return(data, b"true"),
        lambda data: with_return(data, b"null"),
        lambda data: with_return(data, b"NaN"),
        lambda data: with_return(data, b"1e400"),
        lambda data: data.replace(b",1000,", b",1000.0,", 1),
        lambda data: data.replace(b",1000,", b",01000,", 1),
        lambda data: data.replace(b",false,", b",0,", 1),
        # As many commas in all, and none in the last row; a run of more digits than Python reads.
        lambda data: b"".join([*data.splitlines(keepends=True)[:-1], b"," * 16 + b"\n", b"x\n"]),
        lambda data: data.replace(b"\n2,0,", b"\n" + b"9" * 5000 + b",0,", 1),
        # A line end inside the measured cells, with one fewer elsewhere.
        lambda data: data.replace(b",1000,", b",10\n0,", 1).replace(b"\n2,0,", b"2,0,", 1),
    ],
)
def test_a_file_of_another_form_is_left_to_the_cells(log: bytes, change: Callable[[bytes], bytes]) -> None:
    assert by_bytes(log) is not None
    assert by_bytes(change(log)) is None


def test_runs_that_do_not_grow_are_left_to_the_cells(submission: Callable[..., Path]) -> None:
    data = (submission(runs=(0, 1)) / PATH).read_bytes()
    lines = data.splitlines(keepends=True)
    size = (len(lines) - 1) // 2
    assert by_bytes(b"".join([lines[0], *lines[1 + size :], *lines[1 : 1 + size]])) is None
    assert by_bytes(b"".join([lines[0], *lines[1 : 1 + size], *lines[1 : 1 + size]])) is None


@pytest.mark.parametrize(
    ("written", "also"),
    [("\n0,0,", "\n+0,0,"), (",0,315912130,", ",00,315912130,"), (",315912130,", ",0315912130,")],
)
def test_a_number_spelled_in_another_way_is_the_same_number(
    submission: Callable[..., Path], references: References, written: str, also: str
) -> None:
    folder = submission()
    before = score_folder(folder, references)
    log = (folder / PATH).read_text()
    assert written in log
    (folder / PATH).write_text(log.replace(written, also, 1))
    assert not read(folder).problems
    assert score_folder(folder, references) == before
