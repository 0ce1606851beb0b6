"""Names and limits of a submission's folder."""

from __future__ import annotations

import re
from collections.abc import Sequence

from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.catalog.protocol import PROTOCOLS, stages

MANIFEST = "submission.toml"
README = "README.md"
"""An optional text about the submission, which the page of the entry shows as plain text."""
LOGS = tuple(f"{protocol}.csv" for protocol in PROTOCOLS)
CURVES = "curves.csv"
EVALUATIONS = "evaluations.csv"
CSV_FILES = (*LOGS, CURVES, EVALUATIONS)
TRACES = "traces"
SALT_FILE = "salt.txt"
"""The file beside a group's traces that states the salt which drew them."""
POLICIES = "policies"
ARRAY_FOLDERS = (TRACES, POLICIES)
PROGRESS = ".progress"
"""The recorder's folder for unfinished runs. It is not part of a submission."""
UNFINISHED_CURVES = "*/*/curve-stage*.csv"
"""The curves of unfinished runs in the folder ``PROGRESS``, one file per stage."""
RESERVED = frozenset(
    ["CON", "PRN", "AUX", "NUL", *(f"{name}{digit}" for name in ("COM", "LPT") for digit in range(10))]
)
"""Names that Windows reserves for devices, with any ending."""
MAX_DEPTH = 4
"""Folder levels that are listed."""

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,63}")
"""A submission's folder name. It becomes part of a URL."""
NUMBER = "(0|[1-9][0-9]{0,8})"
TRACE = re.compile(
    rf"({'|'.join(PROTOCOLS)})-run{NUMBER}-stage{NUMBER}-([A-Za-z0-9._-]+)-episode{NUMBER}\.npz"
)
"""A trace's file name; its groups are protocol, run, stage, task name and episode."""
POLICY = re.compile(rf"({'|'.join(PROTOCOLS)})-run{NUMBER}-stage{NUMBER}(?:-([A-Za-z0-9._-]+))?\.npz")
"""A policy's file name; its groups are protocol, run, stage and, in the single protocol, the task name."""

MEBIBYTE = 2**20
MAX_FILE_BYTES = {".md": MEBIBYTE // 16, ".toml": MEBIBYTE // 4, ".csv": 32 * MEBIBYTE, ".npz": 4 * MEBIBYTE}
"""Largest file by suffix."""
MAX_SUBMISSION_BYTES = 2048 * MEBIBYTE
MAX_CSV_BYTES = 128 * MEBIBYTE
"""Largest size of all CSV files together."""
MAX_CELLS = 3_000_000
"""Most cells of one CSV file."""
MAX_ROW = 10_000
"""Most characters of a row of a CSV file."""
MAX_RUNS = 100
"""Most runs of a log."""
MAX_FILES = 50_000
MAX_UNPACKED_BYTES = 4 * MEBIBYTE
"""Largest uncompressed size of one .npz file."""
MAX_POLICY_BYTES = 2 * MEBIBYTE
MAX_UNPACKED_POLICY_BYTES = 16 * MEBIBYTE
"""Largest policy file, and its largest uncompressed size."""
MAX_SALT_BYTES = 65
MAX_ARRAYS = 256
"""Most arrays in one .npz file."""


def is_reserved(name: str) -> bool:
    """Whether some system reserves a file name, or ignores the dot or space at its end."""
    return name.partition(".")[0].upper().rstrip() in RESERVED or name.endswith((".", " "))


def max_bytes(path: str) -> int:
    """The size limit of a file, by its folder and suffix."""
    if f"/{POLICIES}/" in path:
        return MAX_POLICY_BYTES
    if path.endswith(f"/{SALT_FILE}"):
        return MAX_SALT_BYTES
    return MAX_FILE_BYTES.get(path[path.rfind(".") :], MEBIBYTE)


def max_unpacked_bytes(path: str) -> int:
    """The limit on the uncompressed size of an .npz file, by its folder."""
    return MAX_UNPACKED_POLICY_BYTES if f"/{POLICIES}/" in path else MAX_UNPACKED_BYTES


def policy_name(protocol: str, run: int, stage: int, task_name: str) -> str:
    """The file name of the policy after a stage. Only the single protocol has one per task."""
    ending = f"-{task_name}" if protocol == "single" else ""
    return f"{protocol}-run{run}-stage{stage}{ending}.npz"


def policy_names(protocol: str, runs: Sequence[int], group: TaskGroup) -> list[str]:
    """The file names of all policies of a log: after every stage of every run."""
    task_names = [task.name for task in group.tasks] if protocol == "single" else [""]
    return [
        policy_name(protocol, run, stage, task_name)
        for run in runs
        for stage in stages(protocol, len(group.tasks))
        for task_name in task_names
    ]


def trace_name(protocol: str, run: int, stage: int, task_name: str, episode: int) -> str:
    """The file name of an episode's trace."""
    return f"{protocol}-run{run}-stage{stage}-{task_name}-episode{episode}.npz"


def unfinished_curve_name(stage: int) -> str:
    """The file name of the curve of a stage in the folder of an unfinished run."""
    return f"curve-stage{stage}.csv"
