"""The command ``gym-extensions train``, which trains an agent and writes its submission."""

import argparse
import re
import shlex
import signal
import sys
from pathlib import Path
from typing import Any

from gym_extensions.baselines import algorithms, workers
from gym_extensions.baselines.agent import Factory
from gym_extensions.baselines.training.checkpoints import CONTINUES
from gym_extensions.catalog.protocol import BUDGETS, PROTOCOLS, STANDARD_BUDGET
from gym_extensions.errors import BenchError, reports_mistakes


def parser() -> argparse.ArgumentParser:
    """The command's options."""
    command = argparse.ArgumentParser(
        prog="gym-extensions train",
        description="Train an agent with an evaluation protocol and write its submission. "
        "An interrupted command can be repeated: it skips finished runs, and resumes the others "
        "after their last finished stage if the agent can be saved. A job that fails does not stop the "
        "others; the exit status is then 1.",
    )
    add = command.add_argument
    protocols, budgets = ", ".join(PROTOCOLS), ", ".join(BUDGETS)
    groups = "comma-separated: names of groups, core (its seven groups), or TOML files of custom groups"
    add("agent", help=f"{', '.join(algorithms.names())}, path/to/agent.py:factory, or module:factory")
    add("--groups", required=True, help=groups)
    add("--protocol", default="sequential", help=f"comma-separated: {protocols} (default: %(default)s)")
    add("--budget", default=STANDARD_BUDGET, help=f"steps per task: {budgets} (default: %(default)s)")
    add("--runs", default="0", help="training seeds, such as 0,1 or 0-4 (default: 0)")
    add("--out", required=True, type=Path, help="the submission's folder")
    add("--jobs", type=int, default=1, help="worker processes; 0: train in this process (default: 1)")
    add("--num-envs", type=int, help="parallel training environments (default: those of the budget)")
    add("--num-threads", type=int, default=1, help="threads per job that step environments (default: 1)")
    every = "also evaluate during training, after each number of steps (default: after each stage only)"
    add("--evaluate-every", type=int, metavar="STEPS", help=every)
    add("--evaluate-episodes", type=int, default=5, help="episodes per task of these (default: 5)")
    by = "your name, if you donate these runs to a submission of others"
    add("--by", default="", metavar="NAME", help=by)
    add("--isolated", action="store_true", help="run the agent in a box without network and files")
    seeds = "a text from which the seeds of training follow, as those of runs that the project trained"
    add("--seeds", default="", metavar="TEXT", help=seeds)
    add("--quiet", action="store_true", help="do not show the progress")
    return command


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Trains, writes the submission and returns the exit status."""
    options = parser().parse_args(argv)
    groups, protocols = parse_names(options.groups), parse_names(options.protocol)

    def interrupt(number: int, _: Any) -> None:
        signal.signal(number, signal.SIG_IGN)  # a scheduler may send it twice
        raise KeyboardInterrupt(number)

    before = signal.signal(signal.SIGTERM, interrupt)  # from a scheduler whose time limit has passed
    try:
        from gym_extensions.baselines import Monitor, Origin, Parallel, train  # loads the simulator

        agent = options.agent
        train(
            isolated(agent, groups, protocols, options.budget) if options.isolated else agent,
            groups,
            protocols,
            options.budget,
            parse_runs(options.runs),
            out=options.out,
            jobs=Parallel(options.jobs, options.num_envs, options.num_threads),
            progress=Monitor(
                progress=not options.quiet,
                evaluate_every=options.evaluate_every,
                evaluate_episodes=options.evaluate_episodes,
            ),
            origin=Origin(options.by, options.seeds),
        )
    except KeyboardInterrupt as stop:
        print(f"Interrupted. {CONTINUES}")
        return 128 + (stop.args or (signal.SIGINT,))[0]
    except OSError as error:
        if error.errno not in workers.DISK_FULL:
            raise
        hint = f"Free some disk space. {CONTINUES}"
        raise BenchError("disk-full", f"{error.strerror}.", str(options.out), hint) from error
    except BenchError as error:
        if error.code != workers.JOBS_FAILED:
            raise
        print(f"error: {error}", file=sys.stderr)
        return 1
    finally:
        signal.signal(signal.SIGTERM, before)
    files = [name for name in groups if name.endswith(".toml")]
    words = ["score", str(options.out), *(word for name in files for word in ("--groups", name))]
    print(f"The submission is in {options.out}. Score it with: {shlex.join(words)}")
    return 0


def isolated(agent: str, groups: list[str], protocols: list[str], budget: str) -> Factory:
    """The factory that starts an agent in a box, with limits for these jobs.

    Raises ``BenchError`` if the agent or a name is unknown, or no box can be started here.
    """
    from gym_extensions.baselines.isolated.box import require_possible
    from gym_extensions.baselines.isolated.confine import Limits
    from gym_extensions.baselines.isolated.proxy import IsolatedAgent
    from gym_extensions.baselines.training.jobs import jobs_of, parse_request

    require_possible()
    request = parse_request(groups, protocols, budget, 0)
    jobs = [job for log in request.logs() for job in jobs_of(*log, [0])]
    steps = [(job.group, sum(stage.steps for stage in job.stages(request.budget))) for job in jobs]
    return IsolatedAgent(agent, Limits.of(steps))


def parse_names(text: str) -> list[str]:
    """The names of a comma-separated list."""
    return [name.strip() for name in text.split(",")]


def parse_runs(text: str) -> list[int]:
    """The numbers of a list with ranges such as ``0,2,5-7``; raises ``BenchError`` for anything else."""
    runs: list[int] = []
    for part in text.split(","):
        match = re.fullmatch(r"\s*(\d{1,6})\s*(?:-\s*(\d{1,6})\s*)?", part)
        if match is None:
            hint = "Use numbers and ranges, such as 0,1 or 0-4."
            raise BenchError("bad-runs", f"{text!r} is not a list of runs.", "--runs", hint)
        first, last = int(match[1]), int(match[2] or match[1])
        if last < first:
            hint = f"Write the smaller number first: {last}-{first}."
            raise BenchError("bad-runs", f"The range {part.strip()!r} is empty.", "--runs", hint)
        runs += range(first, last + 1)
    return runs
