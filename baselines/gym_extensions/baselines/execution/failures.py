"""Jobs that fail: the cause as text, and the error that names all failed jobs at the end of a call."""

from __future__ import annotations

import errno
import traceback
from collections.abc import Mapping
from dataclasses import dataclass, field

from gym_extensions.errors import BenchError

JOBS_FAILED = "jobs-failed"
"""The code of the error that ``train`` raises after the other jobs have finished."""
OTHER_RUN = ("other-run-unfinished", "other-version")
"""The codes of errors with which a command refuses an unfinished run."""
DISK_FULL = (errno.ENOSPC, errno.EDQUOT)
WORKER_DIED = "The worker process ended unexpectedly. If memory ran out, use fewer --jobs or --num-envs."


@dataclass(frozen=True)
class Failure:
    """Why a job failed.

    Args:
        cause: the error in one sentence.
        traceback: the text of the traceback; empty if there is none.
        error: the exception, if the job ran in this process.
        can_repeat: whether the same command may succeed later; not if its settings or versions are other than
            those of the unfinished run.
    """

    cause: str
    traceback: str = ""
    error: BaseException | None = field(default=None, compare=False)
    can_repeat: bool = True


def failure_of(error: BaseException, *, in_this_process: bool = False) -> Failure:
    """The failure of a job that raised an exception, as text, because not every exception pickles."""
    if isinstance(error, BenchError):
        cause = str(error)
    elif isinstance(error, OSError) and error.errno in DISK_FULL:
        cause = f"The disk is full: {error.strerror}. Free some disk space."
    else:
        cause = f"{type(error).__name__}: {error}".rstrip(": ")
    text = "".join(traceback.format_exception(error))
    can_repeat = not (isinstance(error, BenchError) and error.code in OTHER_RUN)
    return Failure(cause, text, error if in_this_process else None, can_repeat)


def jobs_failed(failures: Mapping[str, Failure], total: int, hint: str) -> BenchError:
    """The error that names every failed job with its cause.

    Args:
        failures: by the title of the job.
        total: number of jobs of the call.
        hint: what to do.
    """
    jobs = "1 job" if total == 1 else f"{total} jobs"
    lines = [
        f"{len(failures)} of {jobs} failed.",
        *(f"  {title}: {failures[title].cause}" for title in failures),
    ]
    return BenchError(JOBS_FAILED, "\n".join([*lines, ""]), hint=hint)
