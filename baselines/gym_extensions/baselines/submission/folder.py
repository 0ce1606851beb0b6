"""The folder that a submission is written to: its name, what lies there, whether it can be written."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from gym_extensions.catalog.groups import GROUPS
from gym_extensions.catalog.protocol import PROTOCOLS
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.layout import MANIFEST, NAME, PROGRESS

ANOTHER = "Choose another --out."


def refuse_unfit(out: Path) -> None:
    """Looks at the folder before anything is trained; changes nothing.

    Raises:
        BenchError: the name is no submission's, this is no folder, it holds folders that are no groups', or
            logs of which no manifest says whose they are.
    """
    with _told(out):
        name = out.resolve().name
        if not NAME.fullmatch(name):
            hint = "Begin with a letter or digit; then letters, digits, dots, dashes, underscores, 64 in all."
            raise BenchError("bad-out", f"{name!r} is no name of a submission.", str(out), hint)
        if not out.exists():
            return
        if not out.is_dir():
            raise BenchError("bad-out", "This is a file, and a submission is a folder.", str(out), ANOTHER)
        foreign = sorted(each.name for each in out.iterdir() if each.is_dir() and _is_foreign(each.name))
        if foreign:
            message = f"It holds the folder {foreign[0]!r}, which is no group, so it is no submission."
            hint = f"Name a folder of the submission's own, as in {out / 'mine'}."
            raise BenchError("bad-out", message, str(out), hint)
        _refuse_nobodys_logs(out)


def prepare(out: Path) -> None:
    """Makes the folder where it is missing; raises ``BenchError`` if nothing can be written there."""
    with _told(out):
        out.mkdir(parents=True, exist_ok=True)
        probe = out / f"{PROGRESS}.probe"
        probe.touch()
        probe.unlink(missing_ok=True)


def _is_foreign(name: str) -> bool:
    return name not in GROUPS and name != PROGRESS


def _refuse_nobodys_logs(out: Path) -> None:
    if (out / MANIFEST).exists():
        return
    for name in GROUPS:
        for protocol in PROTOCOLS:
            if (out / name / f"{protocol}.csv").exists():
                message = f"{name}/{protocol}.csv is here, and no {MANIFEST} says whose it is."
                hint = f"Put its {MANIFEST} back, or choose another --out."
                raise BenchError("manifest-lost", message, str(out), hint)


@contextmanager
def _told(out: Path) -> Iterator[None]:
    try:
        yield
    except OSError as refusal:
        message = f"Nothing can be written here: {refusal.strerror or refusal}."
        raise BenchError("bad-out", message, str(out), ANOTHER) from refusal
