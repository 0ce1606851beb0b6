"""Logs the runs of a submission again, from stored policies.

It is for runs of the first arithmetic (docs/rollout-log.md#arithmetic). The log of a run is replaced, and in
its document the digest of the log and the arithmetic; all that it says of the training stays. A run is
written when it is finished, so an interrupted command goes on. Afterwards the submission is verified anew.
"""

from collections.abc import Sequence
from pathlib import Path
from statistics import fmean

import msgspec

from gym_extensions.errors import BenchError, reports_mistakes
from gym_extensions.files import write_bytes
from gym_extensions.submissions import layout, run as documents
from gym_extensions.submissions.fetch import Fetcher, cache_folder
from gym_extensions.submissions.log import Episode, write_log
from gym_extensions.submissions.problem import refuse_problems
from gym_extensions.submissions.reader import read
from gym_extensions.verification.episodes import Player
from gym_extensions.verification.logged_run import LoggedRun, logged_runs
from tools import argument_parser


def record_again(run: LoggedRun, cache: Path) -> str:
    """Logs a run again, and returns what changed in words. Raises ``BenchError`` if its policies fail."""
    if run.document.policies is None:
        return "has no policies; train it again"
    request = run.request(run.prescribed_cells, Fetcher(cache / "policies"))
    (found,) = Player(cache / "verify").play([request])
    if found.problem:
        raise BenchError("bad-policies", found.problem, run.name)
    group, episodes, changes = run.log.group, list[Episode](), list[float]()
    for cell, outcomes in zip(request.cells, found.outcomes, strict=True):
        logged = run.logged[cell.stage, cell.task]
        changes.append(fmean(new.return_ - old.return_ for new, old in zip(outcomes, logged, strict=True)))
        for number, (seed, outcome) in enumerate(zip(cell.seeds, outcomes, strict=True)):
            episodes.append(Episode(cell.stage, group.task_ids[cell.task], number, seed, *outcome))
    path = run.submission.path / layout.run_file(group.name, run.log.protocol, run.document.run, layout.LOG)
    before = path.read_bytes()
    try:
        write_log(path, episodes, group.task_ids)
        new = {"log": documents.file_sha256(path), "arithmetic": documents.ARITHMETIC}
        document = msgspec.structs.replace(run.document, **new)
        documents.write_run(path.with_suffix(layout.DOCUMENT), document)
    except BaseException:  # a full disk, Ctrl-C
        write_bytes(path, before)
        raise
    return f"largest change of a cell's mean return {max(changes, key=abs):+.4g}"


@reports_mistakes
def main(argv: Sequence[str] | None = None) -> int:
    """Logs all runs of the first arithmetic again."""
    command = argument_parser("tools.record_again", __doc__)
    command.add_argument("submission", type=Path, help="the folder of a submission")
    command.add_argument("--runs", nargs="+", metavar="NAME", help="such as hopper-gravity/sequential/run0")
    command.add_argument("--cache", type=Path, default=cache_folder(), metavar="DIR")
    options = command.parse_args(argv)
    submission = read(options.submission)
    refuse_problems(submission.path, submission.problems)
    for name, run in logged_runs(submission).items():
        if run.is_first_arithmetic and (not options.runs or name in options.runs):
            print(f"{name}: {record_again(run, options.cache)}", flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
