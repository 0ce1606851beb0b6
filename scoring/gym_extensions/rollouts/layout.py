"""Names and limits of a submission's folder."""

from __future__ import annotations

import re

from gym_extensions.catalog.protocol import PROTOCOLS

MANIFEST = "submission.toml"
README = "README.md"
"""An optional text about the submission, which the page of the entry shows as plain text."""
LOGS = tuple(f"{protocol}.csv" for protocol in PROTOCOLS)
CURVES = "curves.csv"
CSV_FILES = (*LOGS, CURVES)
TRACES = "traces"
POLICIES = "policies"
ARRAY_FOLDERS = (TRACES, POLICIES)
PROGRESS = ".progress"
"""The recorder's folder for unfinished runs. It is not part of a submission."""
MAX_DEPTH = 4
"""Folder levels that are listed."""

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,63}")
"""A submission's folder name. It becomes part of a URL."""
NUMBER = "(0|[1-9][0-9]{0,8})"
TRACE = re.compile(
    rf"({'|'.join(PROTOCOLS)})-run{NUMBER}-stage{NUMBER}-([A-Za-z0-9._-]+)-episode{NUMBER}\.npz"
)
"""A trace's file name; its groups are protocol, run, stage, task name and episode."""
POLICY = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,127}\.npz")

MEBIBYTE = 2**20
MAX_FILE_BYTES = {".md": MEBIBYTE // 16, ".toml": MEBIBYTE // 4, ".csv": 64 * MEBIBYTE, ".npz": 16 * MEBIBYTE}
"""Largest file by suffix."""
MAX_SUBMISSION_BYTES = 2048 * MEBIBYTE
MAX_FILES = 50_000
MAX_UNPACKED_BYTES = 256 * MEBIBYTE
"""Largest uncompressed size of one .npz file."""
MAX_ARRAYS = 256
"""Most arrays in one .npz file."""


def max_bytes(path: str) -> int:
    """The size limit of a file, by its suffix."""
    return MAX_FILE_BYTES.get(path[path.rfind(".") :], MEBIBYTE)


def trace_name(protocol: str, run: int, stage: int, task_name: str, episode: int) -> str:
    """The file name of an episode's trace."""
    return f"{protocol}-run{run}-stage{stage}-{task_name}-episode{episode}.npz"
