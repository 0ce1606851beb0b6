"""Attacks on the ledger, the salt and the archive."""

from __future__ import annotations

from ..attack import Attack
from ..forgeries.ledger import (
    CHOSEN,
    appended,
    archive,
    attempted,
    changed_files,
    incomplete,
    last_line_cut,
    ledger,
    pending,
    removed,
    rewritten,
    salted,
    shallow,
    swapped,
    text,
    wrong_sample,
)

ATTACKS = (
    Attack(
        "A word of an old line is edited.",
        ledger(text(b"They are", b"They were")),
        "ledger verify: ledger-chain",
    ),
    Attack(
        "An old line is edited, and all later ones are written anew.",
        ledger(rewritten(reason="Better.")),
        "ledger verify: ledger-edited",
    ),
    Attack(
        "The level of an old line is raised, and all later ones are written anew.",
        ledger(rewritten(level="reproduced", replayed=3)),
        "ledger verify: ledger-edited",
    ),
    Attack("The ledger is removed and started anew.", ledger(removed), "ledger verify: ledger-removed"),
    Attack("The end of the ledger is cut off.", ledger(last_line_cut), "ledger verify: ledger-line"),
    Attack(
        "A line is spelled in another way.",
        ledger(text(b'{"date"', b'{ "date"')),
        "ledger verify: ledger-line",
    ),
    Attack("The history is hidden by a shallow clone.", ledger(shallow), "ledger verify: shallow-clone"),
    Attack(
        "The files of an accepted entry are edited.", ledger(changed_files), "ledger verify: ledger-entry"
    ),
    Attack(
        "The files of an accepted entry are edited, to keep its rank.",
        pending,
        "board: Not accepted yet: the ledger does not have its files.",
    ),
    Attack(
        "A line states more replayed episodes than there are.",
        ledger(appended(level="replayed", replayed=200)),
        "ledger verify: ledger-evidence",
    ),
    Attack(
        "A line states the level re-evaluated, without a record of new seeds.",
        ledger(appended(level="re-evaluated", replayed=1)),
        "ledger verify: ledger-evidence",
    ),
    Attack(
        "A line states a salt that does not follow from its value.",
        ledger(appended(value="e" * 40, salt=CHOSEN)),
        "ledger verify: ledger-salt",
    ),
    Attack("A line has an earlier date.", attempted(appended(date="2025-01-01")), "ledger add: ledger-date"),
    Attack(
        "A withdrawn entry is withdrawn again.",
        attempted(lambda folder: (appended(event="withdrawn")(folder), appended(event="withdrawn")(folder))),
        "ledger add: ledger-order",
    ),
    Attack(
        "The author writes a salt that suits the log.",
        salted(lambda forger: forger.write_sample(CHOSEN), "b7" * 32),
        "salted replay: other-salt",
    ),
    Attack(
        "The sample without a salt is kept after the merge.",
        salted(lambda forger: None, "b7" * 32),
        "salted replay: other-salt",
    ),
    Attack(
        "The salt is right, and the traces are those of another one.",
        salted(wrong_sample, "b7" * 32),
        "salted replay: trace-missing",
    ),
    Attack(
        "The archive has other traces than the log commits to.", archive(swapped), "archive: archive-differs"
    ),
    Attack("The archive lacks a trace.", archive(incomplete), "archive: archive-differs"),
)
