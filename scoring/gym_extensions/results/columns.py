"""The columns of frames: which there are, and the choice that every function offers."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import pandas as pd

from gym_extensions.errors import BenchError, did_you_mean

CURVE_DTYPES = {
    "submission": "str",
    "group": "str",
    "protocol": "str",
    "run": "int64",
    "task": "str",
    "step": "int64",
    "return": "float64",
}
"""The columns of training curves, of finished and of unfinished runs."""


def check_columns(columns: Sequence[str] | None, available: Collection[str]) -> None:
    """Raises BenchError if a column is not available; the hint names the closest."""
    if isinstance(columns, str):
        hint = f"Give a list: [{columns!r}]."
        raise BenchError("bad-columns", f"Expected a list of columns, got {columns!r}.", "columns", hint)
    for name in columns or ():
        if name not in available:
            hint = did_you_mean(str(name), available)
            raise BenchError("unknown-column", f"There is no column {name!r}.", "columns", hint)


def select_columns(frame: pd.DataFrame, columns: Sequence[str] | None) -> pd.DataFrame:
    """The frame with these columns, in this order; with all columns if None."""
    return frame if columns is None else frame[list(columns)]


def concat(frames: Sequence[pd.DataFrame], dtypes: Mapping[str, str]) -> pd.DataFrame:
    """The frames below each other, with these dtypes also without rows."""
    empty = pd.DataFrame(columns=list(dtypes))
    frame = pd.concat(frames, ignore_index=True) if frames else empty
    return frame.astype(dtypes)
