"""Measures how long many submissions with traces take to score.

    python tests/benchmarks/measure_speed.py [--submissions 100] [--distinct 100] [--workers N] [--no-traces]

Each submission has four groups, five runs, training curves and the 300 traces of the committed TRPO entry.
Its returns are synthetic and differ between submissions; its traces are hard links. ``--distinct``
submissions are written, and linked in turn under ``--submissions`` names. They are scored with synthetic
references into scorecards and boards. A thousand distinct submissions need 2 GB of temporary files and some
minutes to write.
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
from functools import partial
from itertools import product
from pathlib import Path

from gym_extensions.atomic import write_text
from gym_extensions.catalog.budgets import BUDGETS
from gym_extensions.catalog.fingerprints import published
from gym_extensions.catalog.groups import GROUPS, TaskGroup
from gym_extensions.catalog.protocol import EVALUATION_EPISODES, evaluation_seed
from gym_extensions.rollouts.episodes import CurvePoint, Episode, write_curves, write_episodes
from gym_extensions.rollouts.layout import TRACES
from gym_extensions.scoring.pipeline.publish import Publisher
from gym_extensions.scoring.pipeline.score import Scorer, scorecards
from gym_extensions.scoring.references import Reference, References

ENTRY = Path(__file__).parents[2] / "submissions" / "trpo-2017"
"""The committed submission whose manifest and traces are used."""
GROUP_NAMES = ("hopper-gravity", "walker2d-gravity", "halfcheetah-gravity", "humanoid-gravity")
RUNS = range(5)


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
            None,
            published(task.id),
        )
        for run, stage, task, episode in product(RUNS, stages, group.tasks, range(EVALUATION_EPISODES))
    ]


def write(root: Path, with_traces: bool, seed: int) -> None:
    """Writes one submission into ``root/<seed>``."""
    rng = random.Random(seed)
    level = rng.gauss(400, 100)
    folder = root / str(seed)
    write_text(folder / "submission.toml", (ENTRY / "submission.toml").read_text(encoding="utf-8"))
    for name in GROUP_NAMES:
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
        if with_traces:
            link(root / name / TRACES, folder / name / TRACES)


def link(source: Path, target: Path) -> None:
    """The files of a folder under another path, as hard links."""
    for path in source.rglob("*"):
        if path.is_file():
            copy = target / path.relative_to(source)
            copy.parent.mkdir(parents=True, exist_ok=True)
            os.link(path, copy)


def copy_traces(root: Path) -> None:
    """Copies the traces of ``ENTRY`` once, so that they can be linked on the temporary file system."""
    for path in ENTRY.glob(f"*/{TRACES}/*.npz"):
        copy = root / path.relative_to(ENTRY)
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_bytes(path.read_bytes())


def _processor_time() -> float:
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def measure(
    folders: Sequence[Path], scorer: Scorer, workers: int | None, out: Path
) -> tuple[float, float, float]:
    """Seconds to score the folders into scorecards, seconds for the boards, and processor time of both."""
    start, before, publisher = time.perf_counter(), _processor_time(), Publisher(out, scorer.references)
    for card in scorecards(folders, scorer, workers):
        if card.problems:
            raise ValueError(card.problems[0])
        publisher.add(card)
    scored = time.perf_counter()
    publisher.finish()
    return scored - start, time.perf_counter() - scored, _processor_time() - before


def parse_args() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0] if __doc__ else "")
    parser.add_argument("--submissions", type=int, default=1000)
    parser.add_argument("--distinct", type=int, default=1000, help="submissions with different returns")
    parser.add_argument("--workers", type=int, help="worker processes, as in score --jobs")
    parser.add_argument("--no-traces", action="store_true", help="leave out the traces")
    return parser.parse_args()


def main() -> None:
    """Writes the submissions, scores them and prints the times."""
    args = parse_args()
    tasks = {task: Reference(0.0, 1000.0, False) for name in GROUP_NAMES for task in GROUPS[name].task_ids}
    references = References("synthetic", True, tasks, "0" * 64)
    with tempfile.TemporaryDirectory() as temporary:
        root = Path(temporary)
        copy_traces(root)
        distinct = min(args.distinct, args.submissions)
        with ProcessPoolExecutor(args.workers) as pool:
            list(pool.map(partial(write, root, not args.no_traces), range(distinct)))
        folders = [root / "submissions" / f"entry{number:04}" for number in range(args.submissions)]
        for number, folder in enumerate(folders):
            link(root / str(number % distinct), folder)
        scoring, boards, processor = measure(folders, Scorer(references), args.workers, root / "out")
    traces = "without traces" if args.no_traces else "with traces"
    sys.stdout.write(
        f"{len(folders)} submissions {traces}: scored in {scoring:.1f} s, boards in {boards:.1f} s, "
        f"{processor:.1f} s of processor time\n"
    )
    peaks = (
        resource.getrusage(who).ru_maxrss // 1024 for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    )
    sys.stdout.write("peak memory: {} MiB in the parent, {} MiB in the largest worker\n".format(*peaks))


if __name__ == "__main__":
    main()
