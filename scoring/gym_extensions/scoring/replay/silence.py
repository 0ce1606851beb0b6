"""Keeps MuJoCo from writing a log file."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import mujoco


@contextmanager
def no_log_file() -> Iterator[None]:
    """Stops MuJoCo from writing warnings (recorded states may be unstable) into the current folder."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda _: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(before)
