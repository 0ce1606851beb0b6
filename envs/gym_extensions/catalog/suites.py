"""Suites are lists of groups that are scored together."""

from __future__ import annotations

BODIES = ("hopper", "walker2d", "halfcheetah", "humanoid")

SUITES: dict[str, tuple[str, ...]] = {
    "gravity": tuple(f"{body}-gravity-v0" for body in BODIES),
    "body": tuple(f"{body}-body-v0" for body in BODIES),
    "wall": tuple(f"{body}-wall-v0" for body in BODIES),
    "humanoid": ("humanoid-standup-run-v0", "humanoid-standup-run-wall-v0"),
    "arm": ("striker-v0", "pusher-v0"),
    "navigation": tuple(
        f"nav-{family}-v0" for family in ("state", "state-goal", "range", "range-known", "image")
    ),
}
"""The ids of the groups of every suite."""

SUITES["all"] = tuple(group for groups in SUITES.values() for group in groups)
