"""Evaluation logs: parsed cells, and keys that are compared with the prescribed ones."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gym_extensions.catalog.groups import group
from gym_extensions.rollouts.episodes import UNBOUND_COLUMNS
from gym_extensions.rollouts.reader import read
from gym_extensions.rollouts.reading.csv_lines import Text, columns
from gym_extensions.rollouts.reading.evaluation_log import (
    Cells,
    Log,
    has_prescribed_keys,
    is_integer,
    is_number,
    log,
)
from gym_extensions.scoring.pipeline.score import score_folder
from gym_extensions.scoring.references import References

HOPPER = group("hopper-gravity")
PATH = "hopper-gravity/sequential.csv"


def parse(data: bytes, protocol: str = "sequential") -> Log:
    return log(Cells(PATH, columns(Text(PATH, UNBOUND_COLUMNS, data))), protocol, HOPPER)


@pytest.fixture
def data(submission: Callable[..., Path]) -> bytes:
    """The bytes of a valid sequential log of runs 2, 7 and 11."""
    return (submission(runs=(2, 7, 11)) / PATH).read_bytes()


@pytest.mark.parametrize("protocol", ["sequential", "single", "joint"])
def test_a_valid_log_has_the_prescribed_keys(submission: Callable[..., Path], protocol: str) -> None:
    folder = submission(runs=(2, 7, 11), protocols=(protocol,))
    parsed = parse((folder / "hopper-gravity" / f"{protocol}.csv").read_bytes(), protocol)
    assert parsed.runs == (2, 7, 11)
    assert has_prescribed_keys(parsed)


def test_rows_are_parsed_column_by_column(data: bytes) -> None:
    parsed = parse(data)
    assert parsed.episode_keys[0] == (2, 0, "gym_extensions/HopperGravityHalf-v0", 0)
    assert parsed.seed[0] == 315912130
    assert (parsed.length[0], parsed.return_[0], parsed.terminated[0]) == (1000, 12.0, False)
    assert set(parsed.success.tolist()) == {-1}
    assert parsed.max_steps.tolist() == [1000] * 1800


@pytest.mark.parametrize("column", ["run", "stage", "position", "episode", "seed"])
@pytest.mark.parametrize("row", [0, 900, 1799])
def test_a_changed_key_is_noticed(data: bytes, column: str, row: int) -> None:
    parsed = parse(data)
    getattr(parsed, column)[row] += 1
    assert not has_prescribed_keys(parsed)


def test_a_changed_fingerprint_is_noticed(data: bytes) -> None:
    parsed = parse(data)
    parsed.fingerprint[900] = "0123456789abcdef"
    assert not has_prescribed_keys(parsed)


def test_a_missing_an_added_and_an_exchanged_row_are_noticed(data: bytes) -> None:
    header, *rows = data.splitlines(keepends=True)
    assert not has_prescribed_keys(parse(b"".join([header, *rows[:-1]])))
    assert not has_prescribed_keys(parse(b"".join([header, *rows, rows[-1]])))
    assert not has_prescribed_keys(parse(b"".join([header, rows[1], rows[0], *rows[2:]])))


def test_runs_in_another_order_are_noticed(data: bytes) -> None:
    header, *rows = data.splitlines(keepends=True)
    assert not has_prescribed_keys(parse(b"".join([header, *rows[600:], *rows[:600]])))


def test_measured_cells_are_not_keys(data: bytes) -> None:
    parsed = parse(data)
    changed = replace(
        parsed, length=parsed.length + 1, return_=-parsed.return_, terminated=~parsed.terminated
    )
    assert has_prescribed_keys(changed)


def test_a_task_without_a_published_fingerprint_has_no_prescribed_keys(data: bytes) -> None:
    parsed = parse(data)
    unpublished = replace(HOPPER.tasks[0], name="HopperOnTheMoon")
    moon = replace(HOPPER, tasks=(unpublished, *HOPPER.tasks[1:]))
    assert not has_prescribed_keys(replace(parsed, group=moon))


@pytest.mark.parametrize("cell", ["0", "-5", "007", "123456789012345"])
def test_integers(cell: str) -> None:
    assert is_integer(cell)


@pytest.mark.parametrize("cell", ["", "-", "1.0", "1e3", "+1", "1_000", " 1", "1234567890123456"])
def test_other_cells_are_not_integers(cell: str) -> None:
    assert not is_integer(cell)


@pytest.mark.parametrize("cell", ["0", "-0.5", "1e300", "nan", "-inf"])
def test_numbers(cell: str) -> None:
    assert is_number(cell)


@pytest.mark.parametrize("cell", ["", "1_000", "one", "1,5"])
def test_other_cells_are_not_numbers(cell: str) -> None:
    assert not is_number(cell)


@pytest.mark.parametrize(
    ("old", "new"),
    [("\n0,0,", "\n00,0,"), (",0,315912130,", ",00,315912130,"), (",315912130,", ",0315912130,")],
)
def test_a_number_with_leading_zeros_is_the_same_number(
    submission: Callable[..., Path], references: References, old: str, new: str
) -> None:
    folder = submission()
    before = score_folder(folder, references)
    content = (folder / PATH).read_text()
    assert old in content
    (folder / PATH).write_text(content.replace(old, new, 1))
    assert not read(folder).problems
    assert score_folder(folder, references) == before


def test_returns_are_parsed_exactly() -> None:
    cells = ["9007199254740993.0", "5e-324", "1.7976931348623157e308", "-0.0"]
    row = "0,0,gym_extensions/Hopper-v0,0,1,10,{},false,,f\n"
    header = ",".join(UNBOUND_COLUMNS) + "\n"
    parsed = parse((header + "".join(map(row.format, cells))).encode())
    assert list(map(repr, parsed.return_.tolist())) == [repr(float(cell)) for cell in cells]
    assert np.signbit(parsed.return_[-1])
