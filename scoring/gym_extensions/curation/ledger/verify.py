"""Checks a ledger against the folders of its entries, and proves its levels of trust anew."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from gym_extensions.curation.digest import digest_of, folder_hashes
from gym_extensions.curation.evidence import prove
from gym_extensions.curation.ledger.chain import EntryState, read, states
from gym_extensions.curation.reevaluation import require_reevaluation
from gym_extensions.curation.salt import derive_salt
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.auditing.submission_digest import digest_without_traces
from gym_extensions.rollouts.problem import Problem

RULES = {
    "ledger-entry": "Every entry that the ledger accepts has a folder with the accepted digest.",
    "ledger-salt": "The salt of a line follows from its value and from the files without the traces.",
    "ledger-evidence": "Replay gives the level of trust and the number of episodes that the ledger states. "
    "An entry of the level re-evaluated has a record of that salt.",
}
"""The rules that are checked, by name."""


def active_states(folder: Path) -> dict[str, EntryState]:
    """The entries of a folder of submissions that its ledger accepts, by name, sorted.

    Raises:
        BenchError: the ledger is broken.
    """
    return {name: state for name, state in sorted(states(read(folder)).items()) if state.active}


def check_folders(folder: Path) -> tuple[Problem, ...]:
    """One problem per accepted entry whose folder, salt or record of a re-evaluation is absent or another."""
    problems = []
    for name, state in active_states(folder).items():
        path = folder / name
        hashes = folder_hashes(path) if path.is_dir() else {}
        value, salt = state.last.value, state.last.salt
        if not hashes or digest_of(hashes) != state.last.digest:
            message = "The files are not the accepted ones." if hashes else "The folder is absent."
            hint = "Restore the files, or append lines with `gym-extensions ledger record`."
            problems.append(Problem("ledger-entry", name, message, hint))
        elif value and derive_salt(digest_without_traces(hashes), value) != salt:
            message = "The salt of its line does not follow from the value and the files."
            hint = "Append a line with `gym-extensions ledger add rescored`."
            problems.append(Problem("ledger-salt", name, message, hint))
        elif state.last.level == "re-evaluated":
            try:
                require_reevaluation(path, digest_without_traces(hashes), salt)
            except BenchError as error:
                problems.append(Problem("ledger-evidence", name, error.message, error.hint))
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
