"""Assembles a submission of ``snapshots`` from the stages that another one stored, without simulating.

    python -m tools.snapshots submissions/trpo --groups core --runs 0-9 --out submissions/snapshots
    python -m tools.snapshots submissions/ppo-tuned --out submissions/ppo-snapshots-tuned \\
        --groups hopper-gravity,halfcheetah-gravity,walker2d-wall

After stage s, a task that was learned has the policy that the source stored right after learning it; every
other task has the source's present policy. That is what the agent ``snapshots`` has after it learned as the
source did. Its policies are deterministic and its evaluation episodes start from the same seeds after every
stage, so that these episodes are already in the source's log: those of stage j for a learned task j, those
of stage s for another one. ``gym-extensions verify`` runs the policies and compares. Where the source has no
runs of its author, they are those that were trained here.
"""

import hashlib
from collections.abc import Sequence
from itertools import product
from pathlib import Path
from typing import Any

import msgspec
import tomli_w

from gym_extensions.baselines.cli import parse_runs
from gym_extensions.baselines.training.jobs import parse_groups
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.catalog.protocol import EVALUATION_EPISODES
from gym_extensions.errors import BenchError, reports_mistakes
from gym_extensions.files import write_text
from gym_extensions.policies import Policy, load
from gym_extensions.submissions.layout import DOCUMENT, LOG, MANIFEST, POLICIES, README, run_file
from gym_extensions.submissions.manifest import parse
from gym_extensions.submissions.policies.files import (
    AnyPolicy,
    Key,
    content_sha256,
    run_arrays,
    write_policies,
)
from gym_extensions.submissions.policies.mlp import by_task
from gym_extensions.submissions.run import PolicyFile, read_run, write_run
from gym_extensions.submissions.submission import runs_folder
from tools import argument_parser

ASSEMBLED = (
    "Its author's runs were not trained: they are assembled from stages that the submission {} stored.\n"
)


def assembled_log(text: str, tasks: int) -> str:
    """The log of the snapshots, from the log of their source: rows by stage, task and episode."""
    header, *rows = text.splitlines()
    lines = [header]
    for stage, task in product(range(tasks + 1), range(1, tasks + 1)):
        acts = task if task <= stage else stage  # the stage whose policy acts in the task
        at = (acts * tasks + task - 1) * EVALUATION_EPISODES
        lines += [f"{stage},{row.partition(',')[2]}" for row in rows[at : at + EVALUATION_EPISODES]]
    return "\n".join([*lines, ""])


def write_run_of(source: Path, group: TaskGroup, run: int, out: Path) -> None:
    """Writes the policies, the document and, last, the log of a run."""
    tasks = len(group.tasks)
    stored = [load(source, group, run=run, stage=stage) for stage in range(tasks + 1)]
    plain = [policy for policy in stored if isinstance(policy, Policy)]
    if len(plain) < len(stored):
        message = f"Only plain policies can be stacked, and {group.name} has networks."
        raise BenchError("not-plain", message, str(source))
    policies: dict[Key, AnyPolicy] = {
        (stage, None): by_task(plain[1 : stage + 1]) if stage else plain[0] for stage in range(tasks + 1)
    }

    def place(folder: Path, suffix: str) -> Path:
        return folder / run_file(group.name, "sequential", run, suffix)

    runs = runs_folder(source, group.name, "sequential")
    document = read_run(place(runs, DOCUMENT))
    copy = sum(array.size for array in (*plain[0].weights, *plain[0].biases)) + plain[0].num_actions
    parameters = document.memory.parameters_first + (tasks - 1) * copy
    log = assembled_log(place(runs, LOG).read_text("ascii"), tasks)
    write_policies(place(out, POLICIES), policies)
    digest, size = content_sha256(run_arrays(policies)), place(out, POLICIES).stat().st_size
    document = msgspec.structs.replace(
        document,
        command=f"python -m tools.snapshots {source} --groups {group.name} --runs {run}",
        steps_counted=False,
        memory=msgspec.structs.replace(document.memory, parameters_last=parameters),
        log=hashlib.sha256(log.encode()).hexdigest(),
        policies=PolicyFile(sha256=digest, size=size),
    )
    write_run(place(out, DOCUMENT), document)
    write_text(place(out, LOG), log)


def manifest_from(tables: dict[str, Any]) -> dict[str, Any]:
    """The manifest of the snapshots of a submission, from its own, with its settings and its tuning."""
    protocol, title = tables["protocol"], tables["title"]
    algorithm = "snapshots" if protocol["algorithm"] == "trpo" else f"{protocol['algorithm']}-snapshots"
    if protocol["evaluation"] != "deterministic":
        message = "Sampled actions differ between stages: such episodes have to be simulated."
        raise BenchError("sampled-actions", message)
    return {key: table for key, table in tables.items() if key != "agent"} | {
        "title": f"{title} + snapshots",
        "description": f"{title} with a copy of its policy per learned task, picked by the task label.",
        "protocol": protocol | {"algorithm": algorithm, "parent": protocol["algorithm"]},
        "observes": {"task_in_training": True, "task_in_evaluation": True, "boundaries": True},
    }


@reports_mistakes
def main(argv: Sequence[str] | None = None) -> int:
    """Writes the manifest and the runs of every group, and prints a line for each."""
    parser = argument_parser("tools.snapshots", __doc__)
    parser.add_argument("source", type=Path, help="the submission that stored the policies")
    parser.add_argument("--groups", default="core")
    parser.add_argument("--runs", default="0-9")
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args(argv)
    tables = manifest_from(parse((options.source / MANIFEST).read_bytes()))
    write_text(options.out / MANIFEST, tomli_w.dumps(tables))
    write_text(options.out / README, ASSEMBLED.format(options.source.name))
    for run in parse_runs(options.runs):
        for group in parse_groups(options.groups.split(",")):
            write_run_of(options.source, group, run, options.out)
            print(f"{group.name}, run {run}: assembled", flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
