"""``gym-extensions maintain references``: writes the references file, or measures one again."""

from __future__ import annotations

import argparse
import shutil
from contextlib import suppress
from pathlib import Path

import msgspec

from gym_extensions.baselines import algorithms
from gym_extensions.baselines.cli import parse_names, parse_runs
from gym_extensions.baselines.experts.candidates import QUICK
from gym_extensions.baselines.references.measuring import custom, differences, published
from gym_extensions.baselines.submission import prepare
from gym_extensions.baselines.training.jobs import parse_groups
from gym_extensions.catalog.protocol import BUDGETS, FIRST_REFERENCE_RUN, STANDARD_BUDGET
from gym_extensions.catalog.tasks import TASKS, whole_number
from gym_extensions.envs.fingerprinting import require_published_engine
from gym_extensions.errors import BenchError, reports_mistakes
from gym_extensions.files import write_bytes
from gym_extensions.references import path_of
from gym_extensions.references.experts import EPISODES
from gym_extensions.submissions.layout import PROGRESS

TRAINED_AGENT = "trpo"
"""The expert of a task of a custom group."""


def parser() -> argparse.ArgumentParser:
    """The command's options."""
    command = argparse.ArgumentParser(
        prog="gym-extensions maintain references",
        description="Write the published references from floors and experts, measure those of custom groups, "
        "or measure references again.",
    )
    add = command.add_argument
    groups = (
        "comma-separated: TOML files of custom groups to measure (with --out), or groups to check; "
        "all published tasks by default"
    )
    file = (
        "the file to write; its name without .json is the name of the version. An existing file keeps its "
        "floors and its tasks of custom groups (default: the installed references)"
    )
    again = "measure the floors and experts in this file again and compare (default: the installed one)"
    steps = "training steps per task (custom groups only; default: %(default)s)"
    trained = "agent that is trained on each task (custom groups only; default: %(default)s)"
    seeds = "training seeds from 1000 on (custom groups only; default: %(default)s)"
    add("--groups", help=groups)
    add("--budget", default=STANDARD_BUDGET, choices=list(BUDGETS), help=steps)
    add("--runs", default="1000-1004", help=seeds)
    add("--agent", default=TRAINED_AGENT, choices=algorithms.names(), help=trained)
    target = command.add_mutually_exclusive_group()
    target.add_argument("--out", type=Path, help=file)
    target.add_argument("--check", type=Path, metavar="FILE", nargs="?", const=path_of(), help=again)
    add("--quick", action="store_true", help=f"check on the first {QUICK} episodes")
    add("--jobs", type=int, default=1, help="worker processes (default: 1)")
    return command


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Writes the references file, or checks one; returns the exit status."""
    options = parser().parse_args(argv)
    runs = parse_runs(options.runs)
    for run in runs:
        if run < FIRST_REFERENCE_RUN:
            hint = f"Use numbers from {FIRST_REFERENCE_RUN}; smaller ones are reserved for submissions."
            raise BenchError("bad-run", f"Run {run} is out of range.", "--runs", hint)
    whole_number("jobs", options.jobs, "bad-jobs", "--jobs")
    groups = parse_groups(parse_names(options.groups)) if options.groups else ()
    chosen = list(dict.fromkeys(task for group in groups for task in group.tasks))
    require_published_engine()
    if options.check:
        if not options.check.exists():
            raise BenchError("no-file", "The file does not exist.", str(options.check), "Name another file.")
        tasks = chosen or list(TASKS.values())
        different = differences(tasks, options.check, options.jobs, QUICK if options.quick else EPISODES)
        print(f"{len(tasks)} tasks were measured again; {len(different)} numbers differ.")
        for sentence in different:
            print(f"  {sentence}")
        return 1 if different else 0
    out = options.out or path_of()
    if out.is_dir():
        raise BenchError("bad-out", "It is a folder.", str(out), "Name a file, such as references.json.")
    if chosen and not options.out:
        hint = "Name a file, such as references.json."
        raise BenchError("bad-out", "Custom groups have a file of their own.", "--out", hint)
    if chosen and out.resolve().parent == path_of().parent:
        message = "It is one of the published references, which never change."
        raise BenchError("bad-out", message, str(out), "Name a file outside the package.")
    prepare(out.parent)
    if chosen:
        content = custom(groups, (options.agent, options.budget, runs), out, options.jobs)
    else:
        content = published(out, options.jobs)
    write_bytes(out, msgspec.json.format(msgspec.json.encode(content), indent=1) + b"\n")
    shutil.rmtree(out.parent / PROGRESS / out.stem, ignore_errors=True)
    with suppress(OSError):  # there are unfinished measurements for other files
        (out.parent / PROGRESS).rmdir()
    open_tasks = sum(each.expert is None for each in content.tasks.values())
    provisional = sum(bool(each.expert and each.expert.provisional) for each in content.tasks.values())
    counts = f"{len(content.tasks)} tasks, {open_tasks} of them open, {provisional} provisional"
    print(f"The references are in {out}: {counts}.")
    return 0
