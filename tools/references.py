"""Writes the published references from floors, cards of experts and the planner, or measures them again.

    python -m tools.references [--out FILE]
    python -m tools.references --check [FILE] [--quick] [--groups pusher]

``gym-extensions maintain references`` measures those of custom groups.
"""

import math
from collections.abc import Iterable
from pathlib import Path

from gym_extensions.baselines import references as measuring
from gym_extensions.baselines.cli import parse_names
from gym_extensions.baselines.training.jobs import parse_groups
from gym_extensions.catalog.tasks import TASKS, Task
from gym_extensions.envs.fingerprinting import require_published_engine
from gym_extensions.errors import BenchError, reports_mistakes, whole_number
from gym_extensions.references import Expert, File, Floor, FloorAgent, Reference, experts, path_of
from gym_extensions.references.experts import EPISODES
from tools import argument_parser
from tools.experts.candidates import QUICK
from tools.experts.published import measured_again

FIRST = "1"
"""The version whose floors and planner later versions take over."""
ROUNDING = 1e-9
"""Relative difference of mean returns on another processor."""


def with_expert(task: Task, floor: Floor, folder: Path = experts.DATA) -> Reference:
    """A published MuJoCo task, from its floor and the card of its expert; open without a clear expert.

    Raises ``BenchError`` if the card is of another definition of the task, or the policy is not the one of
    the card.
    """
    if task.bare_name not in experts.names(folder):
        return Reference(floor, None)
    card = experts.card(task, folder)
    experts.load(task, folder)  # raises if the policy is another
    mean, error, count = card.measurement.mean, card.measurement.standard_error, card.measurement.episodes
    expert = Expert(mean, error, count, "expert", card.policy, provisional=card.provisional)
    return (
        Reference(floor, expert) if measuring.is_above(floor, mean, error) else Reference(floor, None, expert)
    )


def published(out: Path, jobs: int, folder: Path = experts.DATA, tasks: Iterable[Task] = ()) -> File:
    """The references of the published tasks: floors, the cards of the experts, and the planner.

    Floors in ``out``, whose stem is the version, stay; others come from version 1, or are measured from their
    seeds in ``jobs`` processes. ``folder`` has the experts' files. Without ``tasks``, all published ones.

    Raises:
        BenchError: ``out`` is not a references file or has another definition of a task, or an expert is
            refused.
    """
    chosen = list(tasks) or list(TASKS.values())
    first, found = (measuring.read_file(path, chosen) for path in (path_of(FIRST), out))
    floors = {name: each.floor for name, each in (first | found).items()}
    floors |= measuring.measured_floors([task for task in chosen if task.id not in floors], jobs)
    content = {}
    for task in chosen:
        floor = floors[task.id]
        if task.base != "Navigation":
            content[task.id] = with_expert(task, floor, folder)
        else:
            planned = first[task.id].expert
            assert planned is not None, f"version {FIRST} has a planner of every navigation task"
            expert = Expert(planned.mean, planned.standard_error, planned.episodes, measuring.PLANNER)
            content[task.id] = Reference(floor, expert)
    return File(2, out.stem, content)


def differences(tasks: Iterable[Task], path: Path, jobs: int, episodes: int = EPISODES) -> list[str]:
    """Measures floors and experts again, from seeds and files, and compares them with a references file.

    Floors and the planner follow from their seeds, but for rounding. Chaotic episodes of a policy differ
    with the version of MuJoCo and from those of the first arithmetic, so that its mean may differ by three
    standard errors; so may everything if less than all episodes are measured.

    Of every agent the first ``episodes`` of 1,000 are used. Returns a sentence for each that differs.

    Raises ``BenchError`` if the file does not have a task, or has another definition of one.
    """
    chosen = list(tasks)
    found = measuring.read_file(path, chosen)
    if missing := [task.id for task in chosen if task.id not in found]:
        hint = "Choose other --groups, or another file."
        raise BenchError("no-reference", f"The file has no reference of {missing[0]}.", str(path), hint)
    measurements = [each for task in chosen for each in measuring.floor_measurements(task, episodes)]
    measurements += [
        measuring.Measurement(task, measuring.PLANNER, episodes)
        for task in chosen
        if task.base == "Navigation"
    ]
    sentences = []
    for each, returns in zip(measurements, measuring.measure(measurements, jobs), strict=True):
        row, again = found[each.task.id], measuring.summary(returns)
        stated: FloorAgent | Expert | None = row.floor.agents.get(each.agent)
        if each.agent == measuring.PLANNER:
            stated = row.expert
        if stated is None:
            continue
        std = stated.standard_error * EPISODES**0.5
        spread = 3 * std / each.episodes**0.5 if each.episodes < EPISODES else 0.0
        if not math.isclose(again.mean, stated.mean, rel_tol=ROUNDING, abs_tol=spread):
            numbers = f"{again.mean:.6g}, not {stated.mean:.6g}"
            sentences.append(f"{each.task.name}: {each.agent} returns {numbers}")
    for task in chosen:
        expert = found[task.id].expert or found[task.id].attempts or None
        if expert is None or not expert.policy:
            continue
        card, (mean, known, differs) = experts.card(task), measured_again(task, episodes)
        if (card.policy, card.measurement.mean) != (expert.policy, expert.mean):
            sentences.append(f"{task.name}: the expert is not the one of its card")
        if differs:
            sentences.append(f"{task.name}: the expert returns {mean:.6g}, not {known:.6g}")
    return sentences


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Writes the references file, or checks one; returns the exit status."""
    parser = argument_parser("tools.references", __doc__)
    target = parser.add_mutually_exclusive_group()
    file = (
        "the file to write; its name without .json is the version, and floors in it stay "
        "(default: the current references)"
    )
    target.add_argument("--out", type=Path, default=path_of(), help=file)
    again = "measure floors and experts in this file again (default: the current references)"
    target.add_argument("--check", type=Path, metavar="FILE", nargs="?", const=path_of(), help=again)
    groups = "comma-separated: the groups to check (default: all published tasks)"
    parser.add_argument("--groups", default="", help=groups)
    parser.add_argument("--quick", action="store_true", help=f"check on the first {QUICK} episodes")
    parser.add_argument("--jobs", type=int, default=1, help="worker processes (default: 1)")
    options = parser.parse_args(argv)
    whole_number("jobs", options.jobs, "bad-jobs", "--jobs")
    require_published_engine()
    if not options.check:
        measuring.write_file(published(options.out, options.jobs), options.out)
        return 0
    if not options.check.exists():
        raise BenchError("no-file", "The file does not exist.", str(options.check), "Name another file.")
    tasks = list(TASKS.values())
    if options.groups:
        chosen = parse_groups(parse_names(options.groups))
        tasks = list(dict.fromkeys(task for group in chosen for task in group.tasks))
    different = differences(tasks, options.check, options.jobs, QUICK if options.quick else EPISODES)
    print(f"{len(tasks)} tasks were measured again; {len(different)} numbers differ.")
    for sentence in different:
        print(f"  {sentence}")
    return 1 if different else 0


if __name__ == "__main__":
    raise SystemExit(main())
