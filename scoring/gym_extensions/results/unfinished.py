"""The training curves of unfinished runs as a data frame."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from gym_extensions.errors import BenchError
from gym_extensions.results.columns import CURVE_DTYPES
from gym_extensions.rollouts.episodes import CURVE_COLUMNS
from gym_extensions.rollouts.layout import PROGRESS, UNFINISHED_CURVES


def unfinished_curves(folder: str | Path) -> pd.DataFrame:
    """The training curves of unfinished runs, up to now, also while they train.

    ===========  =======  ==========================================================================
    column       dtype    value
    ===========  =======  ==========================================================================
    submission   str      name of the submission's folder
    group        str      name of the group's folder
    protocol     str      ``sequential``, ``single`` or ``joint``
    run          int64    training seed
    task         str      task id
    step         int64    training steps since the stage began; in joint runs since the run began
    return       float64  mean return of the training episodes that ended since the point before
    ===========  =======  ==========================================================================

    A run is unfinished until its log is written. A last line that is being written is left out.

    Args:
        folder: the folder in which ``train`` writes the submission.

    Raises:
        BenchError: the folder does not exist.
    """
    path = Path(folder)
    if not path.is_dir():
        raise BenchError("no-folder", "The folder does not exist.", str(folder), "Name the folder of --out.")
    rows = [
        (path.resolve().name, curve.parent.parent.name, *cells)
        for curve in sorted((path / PROGRESS).glob(UNFINISHED_CURVES))
        for cells in _complete_rows(curve)
    ]
    return pd.DataFrame(rows, columns=list(CURVE_DTYPES)).astype(CURVE_DTYPES)


def _complete_rows(curve: Path) -> list[list[str]]:
    try:
        lines = curve.read_text(encoding="utf-8").split("\n")[1:-1]
    except FileNotFoundError:  # its run was finished in the meantime
        return []
    return [cells for cells in (line.split(",") for line in lines) if len(cells) == len(CURVE_COLUMNS)]
