"""Measures how long many synthetic submissions take: five groups of five runs, with training curves.

    python tests/benchmarks/measure_speed.py [--submissions 1000] [--different 1000] [--workers N]

``--different`` submissions are written and linked in turn under ``--submissions`` names, then scored with
synthetic references into scorecards and boards.
(A thousand different ones need 2 GB of temporary files and some minutes to write.)
"""

from __future__ import annotations

import argparse
import os
import random
import resource
import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from itertools import product
from pathlib import Path

from gym_extensions.atomic import write_text
from gym_extensions.catalog.budgets import BUDGETS
from gym_extensions.catalog.fingerprints import published
from gym_extensions.catalog.groups import GROUPS, TaskGroup
from gym_extensions.catalog.protocol import EVALUATION_EPISODES, evaluation_seed
from gym_extensions.rollouts.episodes import CurvePoint, Episode, write_curves, write_episodes
from gym_extensions.scoring.pipeline.publish import Publisher
from gym_extensions.scoring.pipeline.score import Scorer, scorecards
from gym_extensions.scoring.references import Reference, References

NAMES = ("hopper-gravity", "walker2d-gravity", "halfcheetah-gravity", "humanoid-gravity", "hopper-body")
RUNS = range(5)
MANIFEST = """format = 1
title = "Synthetic"
authors = []
description = ""
[code]
url = ""
commit = ""
[protocol]
budget = "100k"
algorithm = "none"
evaluation = "sampled"
[knows]
task_in_training = false
task_in_evaluation = false
boundaries = false
[memory]
stored_steps = 0
parameters_first = 1
parameters_last = 1
[versions]
gym_extensions = ""
gymnasium = ""
mujoco = ""
numpy = ""
python = ""
platform = ""
"""


def _episodes(group: TaskGroup, protocol: str, level: float, rng: random.Random) -> list[Episode]:
    stages = range(len(group.tasks) + 1) if protocol == "sequential" else (1,)
    shift = [rng.gauss(level, 50) for _ in RUNS]
    return [
        Episode(
            run,
            stage,
            task.id,
            episode,
            evaluation_seed(group.id, task.id, episode),
            task.max_steps,
            shift[run] + rng.gauss(0, 100),
            False,
            published(task.id),
        )
        for run, stage, task, episode in product(RUNS, stages, group.tasks, range(EVALUATION_EPISODES))
    ]


def write(folder: Path, seed: int) -> None:
    """Writes one synthetic submission."""
    rng = random.Random(seed)
    level = rng.gauss(400, 100)
    write_text(folder / "submission.toml", MANIFEST)
    for name in NAMES:
        group, steps = GROUPS[name], BUDGETS["100k"].steps_for(name)
        for protocol in ("sequential", "single"):
            rows = _episodes(group, protocol, level, rng)
            write_episodes(folder / name / f"{protocol}.csv", rows, group.task_ids)
        points = [
            CurvePoint(protocol, run, task, steps * point // 10, rng.gauss(level, 50))
            for protocol, run, task, point in product(
                ("sequential", "single"), RUNS, group.task_ids, range(1, 11)
            )
        ]
        write_curves(folder / name / "curves.csv", points, group.task_ids)


def link(source: Path, target: Path) -> None:
    """The same submission under another name, by hard links."""
    for path in source.rglob("*"):
        if path.is_file():
            place = target / path.relative_to(source)
            place.parent.mkdir(parents=True, exist_ok=True)
            os.link(path, place)


def _processor() -> float:
    spent = os.times()
    return spent.user + spent.system + spent.children_user + spent.children_system


def run(
    folders: Sequence[Path], references: References, workers: int | None, out: Path
) -> tuple[float, float, float]:
    """Seconds to score the folders into scorecards, seconds for the boards, and processor time of both."""
    start, before, published = time.perf_counter(), _processor(), Publisher(out, references)
    for card in scorecards(folders, Scorer(references), workers):
        if card.problems:
            raise ValueError(card.problems[0])
        published.add(card)
    scored = time.perf_counter()
    published.finish()
    return scored - start, time.perf_counter() - scored, _processor() - before


def main() -> None:
    """Prints the measurements."""
    options = argparse.ArgumentParser(description=__doc__.partition("\n")[0] if __doc__ else "")
    options.add_argument("--submissions", type=int, default=1000)
    options.add_argument("--different", type=int, default=1000)
    options.add_argument("--workers", type=int, help="as score's --jobs")
    given = options.parse_args()
    tasks = {task: Reference(0.0, 1000.0, False) for name in NAMES for task in GROUPS[name].task_ids}
    references = References("synthetic", True, tasks, "0" * 64)
    with tempfile.TemporaryDirectory() as made:
        root = Path(made)
        different = min(given.different, given.submissions)
        with ProcessPoolExecutor(given.workers) as pool:
            list(
                pool.map(write, (root / "sources" / str(seed) for seed in range(different)), range(different))
            )
        folders = [root / "submissions" / f"entry{number:04}" for number in range(given.submissions)]
        for number, folder in enumerate(folders):
            link(root / "sources" / str(number % different), folder)
        seconds, more, processor = run(folders, references, given.workers, root / "out")
        times = f"{len(folders)} submissions, {seconds:.1f} s, and their boards {more:.1f} s"
        sys.stdout.write(f"scored: {times}; {processor:.1f} s of processor time\n")
    peaks = (
        resource.getrusage(who).ru_maxrss // 1024 for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    )
    sys.stdout.write("peak memory: {} MiB here, {} MiB in the largest worker\n".format(*peaks))


if __name__ == "__main__":
    main()
