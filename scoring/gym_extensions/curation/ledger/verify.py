"""Checks a ledger against the folders of its entries, and proves its levels of trust anew."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from gym_extensions.curation.digest import folder_digest
from gym_extensions.curation.evidence import prove
from gym_extensions.curation.ledger.chain import EntryState, read, states
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.problem import Problem

RULES = {
    "ledger-entry": "Every entry that the ledger accepts has a folder with the accepted digest.",
    "ledger-evidence": "Replay gives the level of trust and the number of episodes that the ledger states.",
}
"""The rules that are checked, by name."""


def active_states(folder: Path) -> dict[str, EntryState]:
    """The entries of a folder of submissions that its ledger accepts, by name, sorted.

    Raises:
        BenchError: the ledger is broken.
    """
    return {name: state for name, state in sorted(states(read(folder)).items()) if state.active}


def check_folders(folder: Path) -> tuple[Problem, ...]:
    """One problem per accepted entry whose folder is absent or has other content."""
    problems = []
    for name, state in active_states(folder).items():
        path = folder / name
        digest = folder_digest(path) if path.is_dir() else ""
        if digest != state.last.digest:
            message = "The files are not the accepted ones." if digest else "The folder is absent."
            hint = "Restore the files, or append lines with `gym-extensions ledger record`."
            problems.append(Problem("ledger-entry", name, message, hint))
    return tuple(problems)


def check_evidence(folder: Path) -> Iterator[tuple[str, tuple[Problem, ...]]]:
    """Replays every accepted entry with the salt of its last line.

    Yields:
        the name of the entry and its problems.
    """
    for name, state in active_states(folder).items():
        line = state.last
        try:
            evidence = prove(folder / name, line.salt)
        except BenchError as error:
            yield name, (Problem(error.code, name, error.message, error.hint),)
            continue
        measured = (evidence.replayed, evidence.episodes)
        if evidence.problems or measured == (line.replayed, line.episodes):
            yield name, evidence.problems
            continue
        message = (
            f"Replay verified {measured[0]} of {measured[1]} episodes; "
            f"the ledger states {line.replayed} of {line.episodes}."
        )
        hint = "Append a line with `gym-extensions ledger add rescored`."
        yield name, (Problem("ledger-evidence", name, message, hint),)
