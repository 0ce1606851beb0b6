"""Which boards a scorecard stands on, and what they read of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from gym_extensions.catalog.budgets import BUDGETS
from gym_extensions.catalog.protocol import PROTOCOLS
from gym_extensions.catalog.suites import SUITES

Document = dict[str, Any]


@dataclass(frozen=True, order=True)
class BoardKey:
    """Which board: a group or suite by its id, protocol, budget, and whether its agents are told the task."""

    group: str
    protocol: str
    budget: str
    told: bool

    @property
    def groups(self) -> tuple[str, ...]:
        """The groups that the board's scores are means over."""
        return SUITES.get(self.group, (self.group,))


def place(card: Document, key: BoardKey) -> Document | None:
    """The entry's part of the scorecard on that board, whatever its budget; None without one."""
    there = (card["suites"] if key.group in SUITES else card["groups"]).get(key.group, {}).get(key.protocol)
    found: Document | None = there
    return found


def told(card: Document) -> bool:
    """Whether the agent is told the task in evaluation: such entries have boards of their own."""
    return bool(((card["manifest"] or {}).get("observes") or {}).get("task_in_evaluation"))


def slim(card: Document) -> Document:
    """What a board reads of a scorecard, so that a board of many entries fits in memory."""
    parts = {
        part: {
            name: {
                protocol: {key: found[key] for key in ("budget", "runs", "metrics") if key in found}
                for protocol, found in protocols.items()
            }
            for name, protocols in card[part].items()
        }
        for part in ("groups", "suites")
    }
    return {key: card[key] for key in ("name", "title", "trust", "manifest")} | parts


def part(card: Document, key: BoardKey) -> Document:
    """What one board reads of a slim scorecard: its own groups alone."""
    groups = {name: card["groups"][name] for name in key.groups if name in card["groups"]}
    suites = {name: found for name, found in card["suites"].items() if name == key.group}
    return card | {"groups": groups, "suites": suites}


def board_keys(cards: Sequence[Document]) -> list[BoardKey]:
    """Every board that the scorecards have an entry for, groups before suites, sorted."""
    keys = set()
    for card in cards:
        for part in ("groups", "suites"):
            for name, protocols in card[part].items():
                for protocol, found in protocols.items():
                    if BUDGETS[found["budget"]].on_boards:
                        keys.add(BoardKey(name, protocol, found["budget"], told(card)))
    budgets, protocols = list(BUDGETS), list(PROTOCOLS)
    return sorted(
        keys,
        key=lambda key: (
            key.group in SUITES,
            key.group,
            protocols.index(key.protocol),
            budgets.index(key.budget),
            key.told,
        ),
    )
