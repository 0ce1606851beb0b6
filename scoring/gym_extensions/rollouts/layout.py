"""Every name and limit of a submission's folder, stated once."""

from __future__ import annotations

import re

from gym_extensions.catalog.protocol import PROTOCOLS

MANIFEST = "submission.toml"
LOGS = tuple(f"{protocol}.csv" for protocol in PROTOCOLS)
CURVES = "curves.csv"
CSV_FILES = (*LOGS, CURVES)
ARRAY_FOLDERS = ("traces", "policies")
PROGRESS = ".progress"
"""The recorder's folder for unfinished runs; not part of a submission."""
DEEPEST = 4
"""Folder levels that are looked at."""

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,63}")
"""A submission's folder name."""
NUMBER = "(0|[1-9][0-9]{0,8})"
TRACE = re.compile(
    rf"(sequential|single|joint)-run{NUMBER}-stage{NUMBER}-([A-Za-z0-9-]+)-episode{NUMBER}\.npz"
)
POLICY = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,127}\.npz")

MEBIBYTE = 2**20
LARGEST = {".toml": MEBIBYTE // 4, ".csv": 64 * MEBIBYTE, ".npz": 16 * MEBIBYTE}
"""Largest file by suffix, bytes."""
LARGEST_SUBMISSION = 2048 * MEBIBYTE
MOST_FILES = 50_000


def largest(path: str) -> int:
    """The size limit of a file by its suffix, bytes."""
    return LARGEST.get(path[path.rfind(".") :], MEBIBYTE)


def trace_name(protocol: str, run: int, stage: int, task_name: str, episode: int) -> str:
    """The file name of an episode's trace."""
    return f"{protocol}-run{run}-stage{stage}-{task_name}-episode{episode}.npz"
