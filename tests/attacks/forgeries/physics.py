"""Makes the attacks of the table of the same name in `families`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from ..evaluate import generator, rollouts, seeds_of, uniform
from ..forger import Arrays, Forger, Row, cells
from ..judge import Make
from ..workshop import Workshop

SCALES = "gym_extensions/{}-v0".format


def recorded_on(task: str, presented: str = "") -> Make:
    """Records the episodes of one task, or of all, on another one.

    Args:
        task: the name of the task that is simulated.
        presented: the name of the task that the log states; all of the group where empty.
    """

    def make(workshop: Workshop) -> Path:
        forger = Forger(workshop.copy("random"))
        rows = forger.rows()
        for cell in cells(rows):
            if not presented or cell[0]["task"] == SCALES(presented):
                act = uniform(SCALES(task), generator(cell))
                for row, rollout in zip(cell, rollouts(SCALES(task), act, seeds_of(cell)), strict=True):
                    forger.put_rollout(row, rollout)
        forger.write(rows)
        return forger.commit()

    return make


def traces(edit: Callable[[Arrays], object], base: str = "random") -> Make:
    """Changes the arrays of every episode with two segments or more."""

    def make(workshop: Workshop) -> Path:
        forger = Forger(workshop.copy(base))
        rows = forger.rows()
        for row in rows:
            arrays = forger.arrays(row)
            if len(arrays["segment_returns"]) > 1:
                edit(arrays)
                forger.bind(row, arrays)
        forger.write(rows)
        return forger.commit()

    return make


def rows_and_traces(edit: Callable[[Row, Arrays], object], base: str = "random") -> Make:
    """Changes every row with its trace."""

    def make(workshop: Workshop) -> Path:
        forger = Forger(workshop.copy(base))
        rows = forger.rows()
        for row in rows:
            arrays = forger.arrays(row)
            edit(row, arrays)
            forger.bind(row, arrays)
        forger.write(rows)
        return forger.commit()

    return make


def shift(name: str, amount: float, index: int = -1, column: int = 0) -> Callable[[Arrays], None]:
    """Adds to a state at a seam."""

    def edit(arrays: Arrays) -> None:
        states = arrays[f"state_{name}"]
        states.reshape(len(states), -1)[index, column] += amount

    return edit


def set_action(value: float) -> Callable[[Arrays], None]:
    def edit(arrays: Arrays) -> None:
        arrays["actions"][5] = value

    return edit


def move_return(arrays: Arrays) -> None:
    arrays["segment_returns"][0] += 0.5
    arrays["segment_returns"][1] -= 0.5


def one_segment(arrays: Arrays) -> None:
    """Makes the whole episode one segment, without seams."""
    arrays["segment_steps"] = np.array(len(arrays["actions"]))
    arrays["segment_returns"] = arrays["segment_returns"].sum(keepdims=True)
    for name in [name for name in arrays if name.startswith("state_")]:
        del arrays[name]


def early_end(row: Row, arrays: Arrays) -> None:
    """Ends an episode one step before it falls."""
    length = int(row["length"]) - 1
    segments = -(-length // 10)
    row["length"] = str(length)
    arrays["actions"] = arrays["actions"][:length]
    arrays["segment_returns"] = arrays["segment_returns"][:segments]
    row["return"] = repr(float(np.sum(arrays["segment_returns"])))
    for name in [name for name in arrays if name.startswith("state_")]:
        arrays[name] = arrays[name][: segments - 1]
        if segments == 1:
            del arrays[name]


def without_noise_of_floats(arrays: Arrays) -> None:
    arrays["actions"] = arrays["actions"].astype(np.float64)


def no_fall(row: Row, arrays: Arrays) -> None:
    """Lets an episode go on after the fall, with a segment that stands."""
    arrays["segment_returns"] = np.append(arrays["segment_returns"], 10.0)
    extra = -int(row["length"]) % 10 + 10
    arrays["actions"] = np.concatenate([arrays["actions"], np.zeros((extra, 3), np.float32)])
    row["length"] = str(int(row["length"]) + extra)
    row["return"] = repr(float(row["return"]) + 10.0)
    for name in [name for name in arrays if name.startswith("state_")]:
        arrays[name] = np.concatenate([arrays[name], arrays[name][-1:]])


def success(row: Row, arrays: Arrays) -> None:
    row["success"] = "true"


def extra_state(arrays: Arrays) -> None:
    arrays["state_luck"] = np.ones((len(arrays["segment_returns"]) - 1, 1))


def without_velocities(arrays: Arrays) -> None:
    del arrays["state_qvel"]


def not_finite(arrays: Arrays) -> None:
    arrays["state_qpos"][0, 0] = np.nan
