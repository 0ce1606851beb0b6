"""The log of a run: its text, and the columns of all runs."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from gym_extensions.catalog.groups import group
from gym_extensions.submissions import log as logs
from gym_extensions.submissions.rules.log import compared_rows, where

from ..conftest import refused
from .examples import HALF, LOG

TASKS = (HALF, "gym_extensions/Hopper-v0")
EPISODES = [
    logs.Episode(1, TASKS[1], 0, 7, 1000, 1.5, False, None),
    logs.Episode(0, TASKS[1], 0, 7, 12, -0.1, True, True),
    logs.Episode(0, TASKS[0], 1, 9, 1000, 1e-300, False, False),
]
TEXT = f"""stage,task,episode,seed,length,return,terminated,success
0,{TASKS[0]},1,9,1000,1e-300,false,false
0,{TASKS[1]},0,7,12,-0.1,true,true
1,{TASKS[1]},0,7,1000,1.5,false,
"""


def test_rows_are_sorted_by_stage_task_in_training_order_and_episode() -> None:
    assert logs.log_text(EPISODES, TASKS) == TEXT


def test_a_log_is_read_as_it_was_written(tmp_path: Path) -> None:
    logs.write_log(tmp_path / "run0.csv", EPISODES, TASKS)
    frame = logs.read_log(tmp_path / "run0.csv")
    assert frame["return"].tolist() == [1e-300, -0.1, 1.5]
    assert frame["terminated"].tolist() == [False, True, False]
    assert frame["success"].tolist() == [0, 1, -1]
    assert frame["seed"].dtype == np.int64


def test_every_return_is_read_to_the_last_bit() -> None:
    drawn = np.frombuffer(np.random.default_rng(0).bytes(8 * 1000))
    values = [*drawn[np.isfinite(drawn)].tolist(), 0.0, 5e-324, 1.7976931348623157e308]
    text = logs.log_text(
        [logs.Episode(1, HALF, i, 1, 1, value, False, None) for i, value in enumerate(values)], TASKS
    )
    assert logs.log_frame(text.encode())["return"].tolist() == values


@pytest.mark.parametrize("length", range(4))
def test_a_damaged_log_gives_a_line_and_nothing_else(length: int) -> None:
    data, rng = TEXT.encode(), np.random.default_rng(length)
    for position in range(len(data)):
        try:
            frame = logs.log_frame(data[:position] + rng.bytes(length) + data[position + 1 :])
        except logs.TableError as error:
            assert 1 <= error.line <= 8
        else:
            assert len(frame) <= 4


@pytest.mark.parametrize(
    ("change", "line", "fact"),
    [
        (lambda text: "\ufeff" + text, 1, "byte order mark"),
        (lambda text: text.replace(",", ";"), 1, "header"),
        (lambda text: text.replace("\n", "\r\n"), 1, "core.autocrlf"),
        (lambda text: text[:-9], 4, "cell"),
        (lambda text: text[:-1], 4, "no line end"),
        (lambda text: text.replace("1.5", "1_5"), 4, "`return`"),
        (lambda text: text.replace("1.5", '"1.5"'), 4, "character"),
        (lambda text: text.replace("-0.1", ""), 3, "`return`"),
        (lambda text: text.replace(",9,", f",{10**30},"), 2, "`seed`"),
        (lambda text: text.replace("true,true", "true,1"), 3, "`success`"),
        (lambda text: text.replace("false,false", "false,false,7"), 2, "9 cells"),
        (lambda text: text.replace("false,\n", "false,,\n"), 4, "9 cells"),
        (
            lambda text: text.replace("false,false", "false,false,7").replace("false,\n", "false\n"),
            2,
            "9 cells",
        ),
        (lambda text: text.split("\n")[0] + "\n", 1, "no rows"),
        (lambda text: text + "\n", 5, "cell"),
        (lambda text: text + "x" * 1001, 5, "1000 characters"),
    ],
)
def test_the_first_wrong_line_is_named(
    tmp_path: Path, change: Callable[[str], str], line: int, fact: str
) -> None:
    path = tmp_path / "run0.csv"
    path.write_text(change(TEXT), encoding="utf-8", newline="\n")
    with refused("bad-log", fact, where=f"{path}, line {line}"):
        logs.read_log(path)


def test_runs_follow_each_other_in_the_columns_and_rows_keep_their_lines() -> None:
    frame = logs.log_frame(TEXT.encode())
    log = logs.log_of({3: frame, 0: frame.iloc[:2]}, "sequential", group("hopper-gravity"))
    assert log.runs == (0, 3)
    assert log.rows["run"].tolist() == [0, 0, 3, 3, 3]
    assert log.rows["position"].tolist() == [0, 2, 0, 2, 2]
    assert compared_rows(log)["limit"].tolist() == [1000] * 5
    assert (where(log, 3), where(log, 1)) == (f"{LOG.replace('0', '3')}, line 3", f"{LOG}, line 3")
