"""Attacks by pull request, played with git; those of the gate's own tests are among them."""

from __future__ import annotations

from ...curation.gate.plays import PLAYS, index
from ...curation.repositories import make_crossed
from ..attack import NOT_DETECTED, REPLAYED, Attack
from ..forgeries.pulls import (
    edited_line,
    fast_forward,
    foreign_line,
    forged_report,
    linked,
    loose_line,
    orphan,
    outdated,
    own_level,
    request,
    withdrawn,
    write,
)

SEVERAL = {
    "a submission that also edits a workflow": "code-and-data, path-characters",
    "a file that is renamed from another entry": "copied-log, renamed-file, several-entries",
    "a file of another entry that is deleted": "deleted-file, several-entries",
    "the ledger deleted": "deleted-file, several-entries",
}
"""Rules of plays that break more than the one that the gate's test names."""

GATE = tuple(
    Attack(f"A pull request has {name}.", request(play, "entry"), f"check-pr: {SEVERAL.get(name, rule)}")
    for name, (rule, _, play) in PLAYS.items()
)
OWNER = "check-pr: review"
ATTACKS = (
    *GATE,
    Attack(
        "A pull request edits the results of another's entry.",
        request(write("submissions/old/README.md", "Worse.\n")),
        OWNER,
    ),
    Attack(
        "A pull request edits the scorer alone.",
        request(write("scoring/rank.py", "rank = 9\n")),
        "check-pr: not-judged",
    ),
    Attack(
        "A pull request makes its author an owner of all entries.",
        request(write(".github/CODEOWNERS", "* @mallory\n")),
        "check-pr: not-judged",
    ),
    Attack(
        "A pull request replaces an entry by a link.",
        request(linked),
        "check-pr: deleted-file, stray-file, symbolic-link",
    ),
    Attack(
        "A pull request has no common ancestor with the base.", request(orphan), "check-pr: unrelated-history"
    ),
    Attack(
        "A pull request merges both sides of an old merge, so that its merge reverts what the base changed.",
        request(make_crossed),
        "check-pr: crossed-history",
    ),
    Attack(
        "The README of an entry is edited, so that another salt draws the sample of the same logs.",
        request(write("submissions/old/README.md", "A typo.\n")),
        OWNER,
    ),
    Attack(
        "A new entry brings the record of its own repetition.",
        request(write("scoring/repetitions/new.json", "{}\n"), "entry"),
        "check-pr: code-and-data",
    ),
    Attack("An old edit of an entry overwrites a newer one.", request(outdated), "check-pr: outdated-entry"),
    Attack(
        "A new entry differs from another in letter case.",
        request(lambda folder: index(folder, ("100644", "x", "submissions/Old/submission.toml"))),
        "check-pr: case-collision",
    ),
    Attack(
        "An old line of the ledger is edited, with a whole chain after it.",
        request(edited_line),
        "check-pr: ledger-edited",
    ),
    Attack(
        "A line of the ledger is about files that do not exist.",
        request(foreign_line),
        "check-pr: ledger-entry",
    ),
    Attack(
        "A line of the ledger does not continue the chain.", request(loose_line), "check-pr: ledger-chain"
    ),
    Attack("A line of the ledger states the level reproduced without a proof.", request(own_level), OWNER),
    Attack("A line of the ledger withdraws a rival.", request(withdrawn), OWNER),
    Attack(
        "A challenge is about an entry that does not exist.",
        request(write("challenges/none/a.txt", "Doubt.\n")),
        "check-pr: unknown-entry",
    ),
    Attack(
        "A challenge has control sequences.",
        request(write("challenges/old/a.txt", "\x1b[2J\n")),
        "check-pr: challenge-text",
    ),
    Attack("Many challenges doubt a rival.", request(write("challenges/old/a.txt", "Doubt.\n")), OWNER),
    Attack("The report of the gate has markup.", forged_report, "comment: malformed-report"),
    Attack(
        "The author's own commit is merged by fast-forward, so that the author knows the salt.",
        fast_forward,
        NOT_DETECTED,
        REPLAYED,
        REPLAYED,
        "Merges by the code host, which always make a new commit; or a public beacon (`--value`).",
    ),
)
