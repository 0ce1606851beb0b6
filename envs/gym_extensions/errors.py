"""The error that every user mistake raises, how commands report it, and how they show that they work."""

import difflib
import functools
import io
import operator
import os
import sys
from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import contextmanager
from typing import Any


class BenchError(Exception):
    """A mistake in the user's input, with what is wrong, where, and what to do.

    Args:
        code: short stable name of the kind of mistake, in kebab case (``unknown-group``).
        message: what is wrong, in one sentence.
        where: the file, row, option or argument with the mistake; may be empty.
        hint: what to do about it; may be empty.
    """

    def __init__(self, code: str, message: str, where: str = "", hint: str = "") -> None:
        self.code, self.message, self.where, self.hint = code, message, where, hint
        super().__init__(code, message, where, hint)

    def __str__(self) -> str:
        first = f"{self.where}: {self.message}" if self.where else self.message
        return f"{first}{'' if first.endswith(chr(10)) else ' '}{self.hint}".rstrip()


def did_you_mean(word: str, choices: Iterable[str]) -> str:
    """Returns a hint that names the closest choice, all choices if there are few, or nothing."""
    ordered = sorted(choices)
    lowered = {choice.lower(): choice for choice in ordered}
    close = difflib.get_close_matches(word.lower(), lowered, n=1, cutoff=0.6)
    if close:
        return f"Did you mean {lowered[close[0]]!r}?"
    return f"Choose one of: {', '.join(ordered)}." if 0 < len(ordered) <= 25 else ""


def require_known(kind: str, name: object, choices: Collection[str], where: str = "") -> None:
    """Raises ``BenchError`` if no choice has that name; the hint names the closest."""
    if name not in choices:
        hint = did_you_mean(str(name), choices)
        raise BenchError(f"unknown-{kind}", f"There is no {kind} {name!r}.", where, hint)


def whole_number(name: str, value: Any, code: str, where: str = "", least: int = 1) -> int:
    """Returns a count as an int. Raises ``BenchError`` if it is not a whole number of at least ``least``."""
    try:
        number = operator.index(value)
    except TypeError:
        number = -1
    if isinstance(value, bool) or number < least:
        raise BenchError(code, f"{name} is {value!r}.", where, f"Give a whole number from {least}.")
    return number


def reports_mistakes(main: Callable[..., int]) -> Callable[..., int]:
    """Wraps a command so that a ``BenchError`` is printed to standard error, with exit status 2.

    ``main(argv=None)`` runs a command line (``sys.argv[1:]`` if None) and returns the exit status. If the
    reader of the output is gone (``| head``), the rest is discarded and the exit status is 1. A character
    that the output's encoding lacks becomes ``?``.
    """

    @functools.wraps(main)
    def command(argv: list[str] | None = None) -> int:
        for stream in (sys.stdout, sys.stderr):
            if isinstance(stream, io.TextIOWrapper) and stream.errors in {"strict", "surrogateescape"}:
                stream.reconfigure(errors="replace")
        try:
            status = main(argv)
            print(end="", flush=True)  # noqa: T201
            return status
        except BrokenPipeError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return 1
        except BenchError as mistake:
            print(f"error: {mistake}", file=sys.stderr)  # noqa: T201
            return 2

    return command


@contextmanager
def working(text: str) -> Iterator[None]:
    """Shows a text that moves until the work is done, if standard error is a terminal.

    Inside, nothing is printed and no process is forked: a thread draws it.
    """
    if not sys.stderr.isatty():
        yield
        return
    from rich.console import Console
    from rich.text import Text

    with Console(stderr=True).status(Text(text)):
        yield
