"""The tables of docs/results.md have the columns of the frames."""

import pytest

from gym_extensions import results
from gym_extensions.metrics.formulas import BOARD_METRICS
from gym_extensions.results.frames import columns_of
from gym_extensions.scoring.output.board_frames import TEXT

from ..conftest import Write


def installed(dtype: str) -> str:
    """A documented dtype with the installed pandas: before version 3, texts are Python objects."""
    return TEXT if dtype == "str" else dtype


def test_the_columns_of_metrics_are_those_of_the_frame(make_submission: Write) -> None:
    frame = results.metrics(make_submission())
    documented = [(column, installed(dtype)) for column, dtype, _ in columns_of(results.metrics)]
    assert documented == [(column, str(dtype)) for column, dtype in frame.dtypes.items()]


@pytest.mark.parametrize("protocol", BOARD_METRICS)
def test_the_columns_of_a_board_are_repeated_per_metric(protocol: str, make_submission: Write) -> None:
    *first, mean, low, high = ((column, installed(dtype)) for column, dtype, _ in columns_of(results.board))
    frame = results.board("hopper-gravity", make_submission(), protocol, "smoke")
    expected = [
        (column.replace("METRIC", metric.name), dtype)
        for metric in BOARD_METRICS[protocol]
        for column, dtype in (mean, low, high)
    ]
    assert [(column, str(dtype)) for column, dtype in frame.dtypes.items()] == [*first, *expected]
