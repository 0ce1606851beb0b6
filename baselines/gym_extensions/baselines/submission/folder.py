"""Checks of the output folder, made before training starts."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from gym_extensions.catalog.groups import GROUPS, TaskGroup
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.layout import LOGS, MANIFEST, NAME, PROGRESS

ANOTHER = "Choose another --out."


def validate(out: Path, groups: Iterable[TaskGroup] = ()) -> None:
    """Checks that ``out`` is, or can become, the folder of a submission. Changes nothing.

    Args:
        out: the folder.
        groups: the groups that will be trained, which may be custom groups.

    Raises:
        BenchError: the name is not allowed, ``out`` is a file or not accessible, it contains folders that are
            not groups, or it contains logs without a manifest.
    """
    names = {*GROUPS, *(group.name for group in groups)}
    with _reports_access(out):
        name = out.resolve().name
        if not NAME.fullmatch(name):
            hint = (
                "Use at most 64 letters, digits, dots, dashes and underscores; start with a letter or digit."
            )
            raise BenchError("bad-out", f"{name!r} is not a valid submission name.", str(out), hint)
        if not out.exists():
            return
        if not out.is_dir():
            raise BenchError("bad-out", "A submission is a folder, and this is a file.", str(out), ANOTHER)
        folders = sorted(path.name for path in out.iterdir() if path.is_dir())
        unexpected = [folder for folder in folders if folder not in names and folder != PROGRESS]
        if unexpected:
            message = f"Unexpected folder {unexpected[0]!r}: a submission contains only group folders."
            hint = f"Use a folder for this submission alone, such as {out / 'mine'}."
            raise BenchError("bad-out", message, str(out), hint)
        _require_manifest(out, sorted(names))


def prepare(out: Path) -> None:
    """Creates the folder. Raises ``BenchError`` if it is not writable."""
    with _reports_access(out):
        out.mkdir(parents=True, exist_ok=True)
        probe = out / f"{PROGRESS}.probe"
        probe.touch()
        probe.unlink(missing_ok=True)


def _require_manifest(out: Path, groups: Iterable[str]) -> None:
    if (out / MANIFEST).exists():
        return
    for group_name in groups:
        for log in LOGS:
            if (out / group_name / log).exists():
                message = f"The folder contains {group_name}/{log} but no {MANIFEST}."
                hint = f"Restore {MANIFEST}, or choose another --out."
                raise BenchError("manifest-lost", message, str(out), hint)


@contextmanager
def _reports_access(out: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        message = f"The folder is not writable: {error.strerror or error}."
        raise BenchError("bad-out", message, str(out), ANOTHER) from error
