"""The listeners of one call of ``train``: screen, log file, chosen logs and the user's callback."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

from gym_extensions.baselines.reporting.display import open_screen
from gym_extensions.baselines.reporting.files import csv_file, log_file
from gym_extensions.baselines.reporting.tensorboard import TensorBoard, require_tensorboard
from gym_extensions.baselines.training.events import Event, Listener, TrainingStarted
from gym_extensions.baselines.training.progress import next_step
from gym_extensions.errors import BenchError, did_you_mean
from gym_extensions.rollouts.layout import PROGRESS

LOGS = ("csv", "tensorboard")
"""The logs that a user can choose."""


def parse_logs(log: str | Iterable[str] | None) -> tuple[str, ...]:
    """The chosen logs without duplicates.

    Raises:
        BenchError: an unknown name, or a package that a log needs is missing.
    """
    names: object = () if log is None else [log] if isinstance(log, str) else log
    chosen = tuple(dict.fromkeys(names)) if isinstance(names, Iterable) else (names,)
    for name in chosen:
        if name not in LOGS:
            hint = did_you_mean(str(name), LOGS)
            raise BenchError("unknown-log", f"There is no log {name!r}.", "log", hint)
    if "tensorboard" in chosen:
        require_tensorboard()
    return tuple(map(str, chosen))


def check_callback(callback: object) -> None:
    """Raises ``BenchError`` if the callback is not callable."""
    if callback is not None and not callable(callback):
        message = f"Expected a function, got a value of type {type(callback).__name__}."
        hint = "Pass a function with one argument, the event."
        raise BenchError("bad-callback", message, "callback", hint)


@contextmanager
def open_listeners(
    out: Path, *, progress: bool, logs: Sequence[str], callback: Listener | None
) -> Iterator[Listener]:
    """One listener for one call of ``train``.

    Args:
        out: the submission's folder. Log files are in its folder ``.progress``.
        progress: whether the screen shows the progress.
        logs: names of ``LOGS``.
        callback: the user's.
    """
    folder, listeners = out / PROGRESS, list[Listener]()
    with ExitStack() as stack:
        if progress:
            listeners.append(stack.enter_context(open_screen()).show)
        file_listeners = [log_file(folder)]
        if "csv" in logs:
            file_listeners.append(csv_file(folder))
        if "tensorboard" in logs:
            board = TensorBoard(folder)
            stack.callback(board.close)
            file_listeners.append(board)
        listeners += map(tolerant, file_listeners)
        if callback is not None:
            listeners.append(guarded(callback, out))

        def listen(event: Event) -> None:
            for each in listeners:
                each(event)

        yield listen


def tolerant(write: Listener) -> Listener:
    """A listener that writes a log. If it cannot, it warns once, and the training goes on."""
    has_warned = False

    def listen(event: Event) -> None:
        nonlocal has_warned
        try:
            write(event)
        except OSError as error:
            if not has_warned:
                has_warned = True
                reason = error.strerror or type(error).__name__
                message = f"A log of the training cannot be written: {reason}. The training continues."
                warnings.warn(message, RuntimeWarning, stacklevel=2)

    return listen


def guarded(callback: Listener, out: Path) -> Listener:
    """The callback, whose exceptions become a ``BenchError`` that says how to continue."""
    titles = list[str]()

    def listen(event: Event) -> None:
        if isinstance(event, TrainingStarted):
            titles.extend(job.title for job in event.jobs)
        try:
            callback(event)
        except Exception as error:
            message = f"The callback raised {type(error).__name__}: {error}".rstrip(".") + "."
            hint = f"Correct the callback. {next_step(out, titles)}"
            raise BenchError("callback-failed", message, "callback", hint) from error

    return listen
