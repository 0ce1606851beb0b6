"""Reads the CSV files of a submission that this package wrote."""

from __future__ import annotations

import csv
from pathlib import Path

from gym_extensions.rollouts.episodes import CurvePoint, Episode, EvaluationPoint


def read_episodes(path: Path) -> list[Episode]:
    """The rows of a log that the recorder wrote, empty if the file does not exist."""
    if not path.exists():
        return []
    with path.open(newline="", encoding="utf-8") as file:
        return [
            Episode(
                *(int(row["run"]), int(row["stage"]), row["task"], int(row["episode"]), int(row["seed"])),
                *(int(row["length"]), float(row["return"]), row["terminated"] == "true"),
                *(
                    {"true": True, "false": False}.get(row["success"]),
                    row["fingerprint"],
                    row.get("trace", ""),
                ),
            )
            for row in csv.DictReader(file)
        ]


def logged_runs(path: Path) -> set[int]:
    """The runs of a log, none if the file does not exist."""
    return {row.run for row in read_episodes(path)}


def missing_runs(path: Path) -> list[int]:
    """The numbers below the highest run of a log that the log does not have; scoring accepts no gaps."""
    runs = logged_runs(path)
    return sorted(set(range(max(runs, default=0))) - runs)


def read_curves(path: Path) -> list[CurvePoint]:
    """The points of a curves file that the recorder wrote, empty if the file does not exist."""
    if not path.exists():
        return []
    with path.open(newline="", encoding="utf-8") as file:
        return [
            CurvePoint(row["protocol"], int(row["run"]), row["task"], int(row["step"]), float(row["return"]))
            for row in csv.DictReader(file)
        ]


def read_evaluations(path: Path) -> list[EvaluationPoint]:
    """The rows of an evaluations file that the recorder wrote, empty if the file does not exist."""
    if not path.exists():
        return []
    with path.open(newline="", encoding="utf-8") as file:
        return [
            EvaluationPoint(
                *(row["protocol"], int(row["run"]), int(row["stage"]), row["task"], int(row["step"])),
                *(int(row["episodes"]), float(row["return"])),
            )
            for row in csv.DictReader(file)
        ]
