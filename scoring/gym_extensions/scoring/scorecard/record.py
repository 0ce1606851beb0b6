"""What the ledger says of a submission, as its scorecard shows it (docs/ledger.md)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from gym_extensions.scoring.documents import about

Event = Literal["pending", "accepted", "rescored", "challenged", "superseded", "withdrawn"]
Level = Literal["reported", "validated", "replayed", "re-evaluated", "reproduced"]
ON_BOARDS = ("pending", "accepted", "rescored", "challenged")
"""Events after which a submission is on the boards."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LedgerRecord:
    """The last line of the ledger about a submission; ``pending`` if no line has the digest of its files."""

    event: Annotated[
        Event,
        about(
            "`accepted`, `rescored`, `challenged`, `superseded` or `withdrawn`; `pending` if the ledger does "
            "not have the digest: the entry is not accepted yet, and the keys below except `digest` are empty"
        ),
    ]
    digest: Annotated[str, about("digest of the submission's files")]
    date: Annotated[str, about("date of that line, YYYY-MM-DD")] = ""
    accepted: Annotated[str, about("date on which these files were accepted, YYYY-MM-DD")] = ""
    reason: Annotated[str, about("reason for that line")] = ""
    level: Annotated[Level | None, about("level of trust that was reached; null if pending")] = None
    replayed: Annotated[
        int, about("number of episodes that were replayed from traces or repeated with policies")
    ] = 0
    episodes: Annotated[int, about("number of episodes in the logs")] = 0
    scorer: Annotated[str, about("version of gym-extensions that verified it")] = ""
    salt: Annotated[str, about("salt of the audit sample, 64 hexadecimal digits; empty without one")] = ""

    @property
    def on_boards(self) -> bool:
        """Whether the submission is on the boards; a withdrawn or superseded one is not."""
        return self.event in ON_BOARDS

    @property
    def is_pending(self) -> bool:
        """Whether the ledger does not have these files, so that the submission is not accepted yet."""
        return self.event == "pending"

    @property
    def is_complete(self) -> bool:
        """Whether every episode of the logs was replayed: from its trace, or with the stored policy."""
        return 0 < self.replayed == self.episodes

    @property
    def trust(self) -> str:
        """The level of trust in the form of the scorecard."""
        if self.level is None or not self.replayed:
            return self.level or "validated"
        if self.is_complete:
            return f"{self.level} (all)"
        sample = "salted sample" if self.salt else "unsalted sample"
        return f"{self.level} ({sample}: {self.replayed} of {self.episodes} episodes)"


@dataclass(frozen=True, slots=True)
class Challenge:
    """A doubt about an entry, as it was submitted."""

    file: Annotated[str, about("path of the file in the repository")]
    text: Annotated[str, about("its text, plain and never markup")]
