"""The choice of columns that every frame offers."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd

from gym_extensions.errors import BenchError, did_you_mean


def select_columns(frame: pd.DataFrame, columns: Sequence[str] | None) -> pd.DataFrame:
    """The frame with these columns, in this order; all of them if None.

    Raises:
        BenchError: the frame has no such column; the hint names the closest.
    """
    if columns is None:
        return frame
    if isinstance(columns, str):
        raise BenchError("bad-columns", f"columns is {columns!r}.", "columns", "Give a list of names.")
    for name in columns:
        if name not in frame.columns:
            hint = did_you_mean(str(name), map(str, frame.columns))
            raise BenchError("unknown-column", f"There is no column {name!r}.", "columns", hint)
    return frame[list(columns)]
