"""What an unfinished run keeps: its finished stages, and the agent as it was after the last of them."""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from gym_extensions.atomic import write_text
from gym_extensions.baselines.agent import Agent, Resumable
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.episodes import CurvePoint, Episode


@dataclass(frozen=True)
class Finished:
    """One finished stage: its log rows, its curve, the number of the agent's parameters before and after."""

    stage: int
    episodes: list[Episode]
    curves: list[CurvePoint]
    card: dict[str, Any]
    parameters: tuple[int, int]


class Progress:
    """The folder of one unit. A stage counts as finished when its record is there: that is written last."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def begin(self, settings: Mapping[str, Any]) -> None:
        """Notes what is being run; raises ``BenchError`` if parts of something else are here."""
        note = self.folder / "settings.json"
        text = json.dumps(settings, indent=1, sort_keys=True) + "\n"
        if not note.exists():
            write_text(note, text)
        elif note.read_text() != text:
            raise BenchError(
                "other-run-unfinished",
                f"Parts of an unfinished run with other settings are here: {note.read_text()}",
                where=str(self.folder),
                hint="Finish it with its own settings, remove the folder, or choose another --out.",
            )

    def finished(self) -> list[Finished]:
        """The records of the finished stages, in order."""
        records = sorted(self.folder.glob("stage*.json"), key=lambda path: int(path.stem[5:]))
        return [_read(path) for path in records]

    def resume(self, agent: Agent, done: list[Finished]) -> bool:
        """Puts the agent where the last finished stage left it; False if it must start again."""
        saved = self._saved(done[-1].stage)
        if not (isinstance(agent, Resumable) and saved.exists()):
            self.forget()
            return False
        agent.load(saved)
        return True

    def finish(self, record: Finished, agent: Agent, last: bool) -> None:
        """Keeps the agent, then the record, then removes the agent of the stage before."""
        saved = self._saved(record.stage)
        if isinstance(agent, Resumable) and not last:
            partial = saved.with_name(f".{saved.stem}.partial.npz")
            agent.save(partial)
            partial.replace(saved)
        write_text(self.folder / f"stage{record.stage}.json", json.dumps(asdict(record)) + "\n")
        for older in self.folder.glob("agent*.npz"):
            if older != saved:
                older.unlink()

    def forget(self) -> None:
        """Removes every finished stage, records first."""
        for path in sorted(self.folder.glob("stage*.json"), reverse=True):
            path.unlink()
        for path in self.folder.glob("agent*.npz"):
            path.unlink()

    def remove(self) -> None:
        """Removes the folder."""
        shutil.rmtree(self.folder, ignore_errors=True)

    def _saved(self, stage: int) -> Path:
        return self.folder / f"agent{stage}.npz"


def _read(path: Path) -> Finished:
    content = json.loads(path.read_text())
    return Finished(
        content["stage"],
        [Episode(**row) for row in content["episodes"]],
        [CurvePoint(**row) for row in content["curves"]],
        content["card"],
        (content["parameters"][0], content["parameters"][1]),
    )
