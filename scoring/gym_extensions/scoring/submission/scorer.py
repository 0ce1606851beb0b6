"""One submission -> its scorecard: every group and protocol, and the suites."""

import hashlib
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import msgspec

from gym_extensions.catalog.groups import group
from gym_extensions.catalog.protocol import IN_ORDER, task_order
from gym_extensions.documents import filled
from gym_extensions.metrics.formulas import FINAL, JOINT_GAP, METRICS, NEEDS, NormalizedRun, iqm, profile
from gym_extensions.metrics.order_effects import order_effects
from gym_extensions.metrics.values import MetricValue, joint_gap, over_runs
from gym_extensions.references import References
from gym_extensions.scoring import scorecard
from gym_extensions.scoring.group_score import (
    SKETCH_SIZE,
    GroupScore,
    ReferenceValue,
    RunProvenance,
    Sketch,
    TrainingCurve,
)
from gym_extensions.scoring.submission import normalization, reported_tables, suites
from gym_extensions.scoring.submission.core_score import core_score, run_cost
from gym_extensions.scoring.submission.stages import with_stages
from gym_extensions.scoring.submission.suites import Scores
from gym_extensions.submissions import review as reviews, submission as submissions
from gym_extensions.submissions.log import Log
from gym_extensions.submissions.manifest import SETTINGS, Manifest
from gym_extensions.submissions.review import CLAIMED, LEVELS, REPORTED, TRAINED_HERE, Level
from gym_extensions.submissions.run import ARITHMETIC

NO_POLICIES = (
    "No policies of run {}. A rank requires them: "
    "give the agent a method policy() (docs/agents.md) and train into a new folder."
)


def score(
    submission: submissions.Submission, references: References, only: Collection[str] = ()
) -> scorecard.Scorecard:
    """The scorecard of one submission. With problems, it has neither a level nor groups.

    It depends on the submission and the references alone. ``only`` names the groups of a reported submission
    that are scored; all if empty.
    """
    manifest, of_code = submission.manifest, submission.trained
    groups, own, level = Scores(), dict[str, GroupScore](), None
    scored = dict[str, submissions.SubmittedGroup]()
    if manifest and not submission.problems:
        if manifest.reported:
            reported = reported_tables.reported_groups(manifest.reported, manifest.protocol.budget)
            groups = {id_: each for id_, each in reported.items() if not only or group(id_).name in only}
        scored = {id_: submissions.scored_group(each) for id_, each in submission.groups.items()}
        groups |= author_logs(scored, submission.review, manifest, references)
        for name, logs in trained_logs(of_code, references).items() if of_code else ():
            known = groups.get(name, {})
            if "sequential" in known and "sequential" in logs:
                own[name] = known["sequential"]
            groups[name] = known | logs
        levels = [each.level for protocols in groups.values() for each in protocols.values()]
        least = None if only else REPORTED if manifest.reported else CLAIMED
        level = min(levels, key=LEVELS.index, default=least)
    settings = manifest.digest if manifest else ""
    digests = {run for each in scored.values() for log in each.logs for run in each.digests(log).items()}
    runs_documented = submission.documents.values()
    is_repeated = reviews.is_verified(level) and not submission.is_sampled
    card = scorecard.Scorecard(
        name=submission.name,
        title=manifest.title if manifest else submission.name,
        level=level,
        arithmetic=min((run.arithmetic for run in runs_documented if is_repeated), default=ARITHMETIC),
        steps_counted=level != REPORTED and all(run.steps_counted for run in runs_documented),
        problems=submission.problems,
        manifest=manifest_summary(submission),
        training=filled(
            scorecard.TrainingSummary,
            of_code.training,
            attempts=of_code.version,
            finished=max((run.date or "" for run in of_code.runs.documents.values()), default=""),
            outdated=of_code.training.agent != submission.code,
        )
        if of_code
        else None,
        own=own,
        readme=submission.readme,
        notes=tuple(f"{name}: {note}" for name, submitted in scored.items() for note in submitted.notes),
        verifications=tuple(
            filled(
                scorecard.VerificationSummary,
                part,
                logs=tuple(sorted({key.rpartition("/")[0] for key in part.runs})),
                runs=len(part.runs),
                current=len(digests & part.runs.items()) if part.settings == settings else 0,
                retrained=tuple(part.retrained),
            )
            for part in submission.review.verifications
        ),
        decisions=tuple(submission.review.decisions),
        groups=groups,
        suites={} if level == REPORTED else suites.suite_scores(groups),
    )
    return completed(card)


def author_logs(
    groups: Mapping[str, submissions.SubmittedGroup],
    review: reviews.Review,
    manifest: Manifest,
    references: References,
) -> Scores:
    """The scores of the author's own runs."""
    found, settings, budget = Scores(), manifest.digest, manifest.protocol.budget
    for name, submitted in groups.items():
        returns = normalization.group_returns(submitted, budget)
        found[name] = {}
        for protocol, runs in returns.runs.items():
            documents = [submitted.runs[protocol][run] for run in runs]
            digests = submitted.digests(protocol)
            again = reviews.reproduced(review, settings, digests)
            claims = (reviews.why_claimed(review, settings, {key: digests[key]}) for key in digests)
            without = ", ".join(str(each.run) for each in documents if each.policies is None)
            why = NO_POLICIES.format(without) if without else reviews.why_claimed(review, settings, digests)
            found[name][protocol] = score_group(
                *(returns, references, protocol, budget),
                level=reviews.level(review, settings, digests),
                why=why,
                unverified=tuple(run for run, claim in zip(runs, claims, strict=True) if claim),
                provenance=[
                    RunProvenance.of(document, key in again)
                    for document, key in zip(documents, digests, strict=True)
                ],
                sketches=run_sketches(submitted, protocol) if protocol in IN_ORDER else (),
            )
    return found


def manifest_summary(submission: submissions.Submission) -> scorecard.ManifestSummary | None:
    """What the scorecard says of a manifest. Of trained code, the author states only what tuning cost."""
    if (manifest := submission.manifest) is None:
        return None
    trained, memory = submission.trained, submission.memory
    if trained and trained.runs.manifest:
        told = {name: getattr(trained.runs.manifest, name) for name in SETTINGS if name != "tuning"}
        manifest = msgspec.structs.replace(manifest, **told)
        memory = memory or trained.runs.memory
    return filled(scorecard.ManifestSummary, manifest, memory=memory)


def trained_logs(trained: submissions.Trained, references: References) -> Scores:
    """The scores of the runs that the project trained. Failed ones count as the floor."""
    runs, found = trained.runs, Scores()
    if runs.manifest is None:  # no run has finished yet
        return found
    budget = runs.manifest.protocol.budget
    for name, each in runs.groups.items():
        submitted = submissions.scored_group(each)
        returns = normalization.group_returns(submitted, budget)
        for protocol, numbers in returns.runs.items():
            keys = submitted.digests(protocol)
            is_recorded = keys.items() <= trained.training.runs.items()
            sketches = zip(keys, run_sketches(submitted, protocol), strict=True)
            documents = [submitted.runs[protocol][run] for run in numbers]
            found.setdefault(name, {})[protocol] = score_group(
                *(returns, references, protocol, budget),
                level=TRAINED_HERE if is_recorded else CLAIMED,
                why="" if is_recorded else "The record of its training has other runs.",
                provenance=list(map(RunProvenance.of, documents)),
                sketches=tuple(() if key in trained.training.failed else each for key, each in sketches),
            )
    return found


def completed(card: scorecard.Scorecard) -> scorecard.Scorecard:
    """The scorecard with all that follows from the rest of it: stages of tasks, the core score, the cost."""
    groups = {
        name: {protocol: with_stages(each, protocol, logs.get("single")) for protocol, each in logs.items()}
        for name, logs in card.groups.items()
    }
    own = {
        name: with_stages(each, "sequential", groups[name].get("single")) for name, each in card.own.items()
    }
    card = replace(card, groups=groups, own=own)
    card = replace(card, core=core_score(card))
    return replace(card, cost=run_cost(card))


def score_group(
    results: normalization.GroupReturns,
    references: References,
    protocol: str,
    budget: str,
    *,
    level: Level = CLAIMED,
    why: str = "",
    unverified: tuple[int, ...] = (),
    provenance: Sequence[RunProvenance] = (),
    sketches: tuple[Sketch, ...] = (),
) -> GroupScore:
    """Scores one group and protocol, with metrics, the paper's table, references and raw returns."""
    tasks = results.group.task_ids
    runs = [] if references.missing(tasks) else normalization.normalized_runs(results, references, protocol)
    final = [[run.p(run.T, j) for j in run.scored] for run in runs]
    rows, total = reported_tables.paper_table(results) if protocol == "sequential" else ((), None)
    return GroupScore(
        published=results.group.published,
        level=level,
        why_claimed=why if level == CLAIMED else "",
        unverified=unverified,
        provenance=tuple(provenance),
        budget=budget,
        runs=tuple(results.runs[protocol]),
        tasks=tasks,
        metrics=metric_values(results, references, protocol, runs),
        profile=profile(final),
        iqm=iqm(final),
        reference={task: ReferenceValue.of(references.tasks.get(task)) for task in tasks},
        return_matrix=tuple(tuple(map(tuple, run)) for run in results.means[protocol]),
        success_rates=results.success_rates(protocol),
        curves=tuple(
            TrainingCurve(run, task, tuple(zip(steps, values, strict=True)))
            for (name, run, task), (steps, values) in results.curves.items()
            if name == protocol and run in results.runs[protocol]
        ),
        episode_sketches=sketches,
        paper_table=rows,
        paper_total=total,
        order_effects=order_effects(runs) if protocol == "balanced" else {},
    )


def metric_values(
    results: normalization.GroupReturns, references: References, protocol: str, runs: Sequence[NormalizedRun]
) -> dict[str, MetricValue]:
    """The value of every metric of a protocol by its name, in the order of the metrics' table.

    A metric that compares runs of two protocols is over the training seeds that have both.
    ``runs`` are the protocol's normalized runs, empty where a task of the group has no reference.
    """
    ids = results.group.task_ids
    if missing := references.missing(ids):
        why = f"{len(missing)} of {len(ids)} tasks have no floor and expert in version {references.version} "
        value = MetricValue(why=f"{why}of the references, {missing[0]} among them.")
        return {metric.name: value for metric in METRICS[protocol]}
    experts = [references.tasks[task].expert_error for task in ids]
    present = {*results.runs, *(["curves"] if results.curves else [])}
    values: dict[str, MetricValue] = {}
    for metric in METRICS[protocol]:
        if lacking := [NEEDS[name] for name in metric.needs if name in NEEDS and name not in present]:
            value = MetricValue(why=f"It needs {' and '.join(lacking)}: there are none with these runs.")
        elif metric is JOINT_GAP:
            joint = over_runs(FINAL, normalization.normalized_runs(results, references, "joint"), experts)
            value = joint_gap(values[FINAL.name], joint, experts)
        else:
            partners = [set(results.runs[name]) for name in metric.needs if name in results.runs]
            numbered = zip(results.runs[protocol], runs, strict=True)
            paired = [run for number, run in numbered if all(number in each for each in partners)]
            value = over_runs(metric, paired, experts)
        values[metric.name] = value
    return values


def run_sketches(submitted: submissions.SubmittedGroup, protocol: str) -> tuple[Sketch, ...]:
    """What two equal runs have in common: the sketch of the last episodes of each run of a log.

    In navigation, returns are whole numbers, and different agents that stand still have equal episodes.
    Episodes cannot show a copy there. A run's sketch is the digest of its policies instead, and is empty
    without them.
    """
    log = submitted.logs[protocol]
    if any(task.body.family != "navigation" for task in submitted.group.tasks):
        return episode_sketches(log)
    policies = [submitted.runs[protocol][run].policies for run in log.runs]
    return tuple((each.sha256,) if each else () for each in policies)


def episode_sketches(log: Log) -> tuple[Sketch, ...]:
    """The sketch of each run: the 16 smallest digests of its episodes after the last stage, sorted.

    Where there are several tasks, the one that was trained last does not count: methods that only differ in
    what they keep of earlier tasks rightly have equal episodes on it. An episode's digest is the first eight
    hexadecimal digits of the SHA-256 of its task's index, number, length, return (five significant digits,
    so that little noise changes few digests) and end. Two sketches estimate the Jaccard index of the
    episodes of two runs: the number of common ones per episode that either has.

    Source: E. Cohen and H. Kaplan, Summarizing data using bottom-k sketches, PODC 2007.
    """
    digests: dict[int, set[str]] = {run: set() for run in log.runs}
    last = log.rows[log.rows["stage"] == log.rows["stage"].max()]
    ends = {run: task_order(log.protocol, run, len(log.group.tasks))[-1] for run in log.runs}
    earlier = last[last["position"] != last["run"].map(ends)]
    last = earlier if len(earlier) else last
    columns = ("run", "position", "episode", "length", "return", "terminated")
    for run, *key, return_, terminated in zip(*(last[name].tolist() for name in columns), strict=True):
        episode = (*key, f"{return_:.4e}", terminated)
        digests[run].add(hashlib.sha256(repr(episode).encode()).hexdigest()[:8])
    return tuple(tuple(sorted(digests[run])[:SKETCH_SIZE]) for run in log.runs)
