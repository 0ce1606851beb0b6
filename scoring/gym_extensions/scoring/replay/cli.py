"""``gym-extensions watch``: replays audited episodes and writes their poses for the pages of entries."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from gym_extensions.envs.fingerprint import require_published_engine
from gym_extensions.errors import BenchError, reports_mistakes
from gym_extensions.rollouts.folder import Folder, scan
from gym_extensions.rollouts.reader import read
from gym_extensions.rollouts.reading.evaluation_log import Log
from gym_extensions.scoring.poses.files import FOLDER, load, path_of, write
from gym_extensions.scoring.poses.model import Poses
from gym_extensions.scoring.replay.poses import episode_of, poses_of, shown_episodes


def parser() -> argparse.ArgumentParser:
    """The command's arguments."""
    options = argparse.ArgumentParser(
        prog="gym-extensions watch",
        description="Replay audited episodes of submissions and write their poses, which the site shows.",
        epilog="Exit status: 0 success, 1 a submission has problems, 2 wrong usage or a replay that differs.",
    )
    options.add_argument("submissions", nargs="+", type=Path, metavar="FOLDER", help="submission folders")
    options.add_argument(
        "--out", type=Path, default=FOLDER, help="folder of the poses (default: %(default)s)"
    )
    options.add_argument("--again", action="store_true", help="replay even where the poses are up to date")
    return options


def is_current(poses: Poses | None, log: Log, folder: Folder) -> bool:
    """Whether poses show the audited episodes of this log, with its returns."""
    if poses is None or poses.run != log.runs[0]:
        return False
    clips = {
        (clip.stage, task.task, clip.episode): clip
        for task in poses.tasks
        for clip in (task.after, task.end)
        if clip
    }
    shown = {
        (stage, task_id, episode_of(request))
        for (stage, task_id), request in shown_episodes(folder, log).items()
    }
    if shown != set(clips):
        return False
    returns = dict(zip(log.episode_keys, log.return_.tolist(), strict=True))
    return all(
        round(returns[poses.run, stage, task, episode], 2) == value
        for (stage, task, _), clip in clips.items()
        for episode, value in enumerate(clip.returns)
    )


def watch(path: Path, out: Path, again: bool = False) -> list[tuple[Path, bool]]:
    """Writes the poses of a submission's sequential logs with traces.

    Returns:
        The path of each file, and whether it was written anew.

    Raises:
        BenchError: the submission has problems, another engine is installed, or a replay differs.
    """
    submission = read(path)
    if submission.problems:
        problem = submission.problems[0]
        raise BenchError(problem.rule, problem.message, f"{submission.name}: {problem.where}", problem.hint)
    folder, files = scan(path), []
    for submitted in submission.groups.values():
        log = submitted.logs.get("sequential")
        group = submitted.group
        has_traces = any(name.startswith(f"{group.name}/traces/") for name in folder.files)
        if log is None or not has_traces or not shown_episodes(folder, log):
            continue
        file = path_of(out, submission.name, group.name)
        if not again and is_current(load(file), log, folder):
            files.append((file, False))
            continue
        require_published_engine()
        files.append((write(out, group.name, poses_of(folder, log)), True))
    return files


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Writes the poses of every named submission and prints the paths."""
    options = parser().parse_args(argv)
    for path in options.submissions:
        files = watch(path, options.out, options.again)
        for file, is_new in files:
            print(f"{file}{'' if is_new else ' (up to date)'}")
        if not files:
            print(f"{path} has no traces of the sequential protocol.", file=sys.stderr)
    return 0
