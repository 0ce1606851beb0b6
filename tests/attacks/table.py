"""The table of all attacks, as docs/security.md has it."""

from __future__ import annotations

from .attack import NOT_DETECTED, Attack
from .families import invented

FAMILIES = {
    "Invented returns": invented.ATTACKS,
}
ATTACKS = tuple(attack for attacks in FAMILIES.values() for attack in attacks)
