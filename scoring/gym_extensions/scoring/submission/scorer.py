"""One submission -> its scorecard: every group and protocol, and the suites."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

from gym_extensions.catalog.groups import group
from gym_extensions.documents import filled
from gym_extensions.metrics.formulas import iqm, profile
from gym_extensions.references import References
from gym_extensions.scoring import scorecard
from gym_extensions.scoring.scorecard import GroupScore, ManifestSummary, Scorecard, VerificationSummary
from gym_extensions.scoring.submission.core_score import core_score, run_cost
from gym_extensions.scoring.submission.normalization import GroupReturns, group_returns, normalized_runs
from gym_extensions.scoring.submission.reported_tables import paper_table, reported_groups
from gym_extensions.scoring.submission.sketches import Sketch, run_sketches
from gym_extensions.scoring.submission.stages import with_stages
from gym_extensions.scoring.submission.values import metric_values, suite_scores
from gym_extensions.submissions.review import (
    CLAIMED,
    LEVELS,
    REPORTED,
    Level,
    Verification,
    level as review_level,
    why_claimed,
)
from gym_extensions.submissions.run import RunDocument
from gym_extensions.submissions.submission import Submission, scored_runs


def score(submission: Submission, references: References, only: Collection[str] = ()) -> Scorecard:
    """The scorecard of one submission. With problems, it has neither a level nor groups.

    It depends on the submission and the references alone. ``only`` names the groups of a reported submission
    that are scored; all if empty.
    """
    submission = scored_runs(submission)
    manifest, review = submission.manifest, submission.review
    groups: dict[str, dict[str, GroupScore]] = {}
    digests: dict[str, str] = {}
    level: Level | None = None
    if manifest and not submission.problems:
        budget = manifest.protocol.budget
        level = REPORTED if manifest.reported else CLAIMED
        if manifest.reported:
            reported = reported_groups(manifest.reported, budget)
            groups = {id_: each for id_, each in reported.items() if not only or group(id_).name in only}
        for name, submitted in submission.groups.items():
            returns = group_returns(submitted, budget)
            groups[name] = {}
            for protocol, runs in returns.runs.items():
                documents, found = (
                    [submitted.runs[protocol][run] for run in runs],
                    submitted.digests(protocol),
                )
                without = ", ".join(str(each.run) for each in documents if each.policies is None)
                digests |= found
                groups[name][protocol] = score_group(
                    *(returns, references, protocol, budget),
                    level=review_level(review, found),
                    why=f"No policies of run {without}." if without else why_claimed(review, found),
                    unverified=tuple(
                        run
                        for run, (key, digest) in zip(runs, found.items(), strict=True)
                        if why_claimed(review, {key: digest})
                    ),
                    documents=documents,
                    sketches=run_sketches(submitted, protocol) if protocol == "sequential" else (),
                )
        levels = [score.level for protocols in groups.values() for score in protocols.values()]
        level = min(levels, key=LEVELS.index, default=level)
    card = Scorecard(
        name=submission.name,
        title=manifest.title if manifest else submission.name,
        level=level,
        problems=submission.problems,
        manifest=filled(ManifestSummary, manifest, memory=submission.memory) if manifest else None,
        readme=submission.readme,
        notes=tuple(
            f"{name}: {note}" for name, submitted in submission.groups.items() for note in submitted.notes
        ),
        verifications=tuple(_verification(part, digests) for part in review.verifications),
        decisions=tuple(review.decisions),
        groups=groups,
        suites={} if level == REPORTED else suite_scores(groups),
    )
    return completed(card)


def completed(card: Scorecard) -> Scorecard:
    """The scorecard with all that follows from the rest of it: stages of tasks, the core score, the cost."""
    groups = {
        name: {
            protocol: with_stages(score, protocol, scores.get("single")) for protocol, score in scores.items()
        }
        for name, scores in card.groups.items()
    }
    card = replace(card, groups=groups)
    card = replace(card, core=core_score(card))
    return replace(card, cost=run_cost(card))


def _verification(part: Verification, digests: Mapping[str, str]) -> VerificationSummary:
    """What a verification found, given the digest of every run as it is now, by the run's name."""
    return filled(
        VerificationSummary,
        part,
        logs=tuple(sorted({key.rpartition("/")[0] for key in part.runs})),
        runs=len(part.runs),
        current=sum(digests.get(key) == digest for key, digest in part.runs.items()),
        retrained=tuple(part.retrained),
    )


def score_group(
    results: GroupReturns,
    references: References,
    protocol: str,
    budget: str,
    *,
    level: Level = CLAIMED,
    why: str = "",
    unverified: tuple[int, ...] = (),
    documents: Sequence[RunDocument] = (),
    sketches: tuple[Sketch, ...] = (),
) -> GroupScore:
    """Scores one group and protocol, with metrics, the paper's table, references and raw returns."""
    tasks = results.group.task_ids
    runs = [] if references.missing(tasks) else normalized_runs(results, references, protocol)
    final = [[run.p(run.T, j) for j in run.scored] for run in runs]
    rows, total = paper_table(results) if protocol == "sequential" else ((), None)
    return GroupScore(
        published=results.group.published,
        level=level,
        why_claimed=why if level == CLAIMED else "",
        unverified=unverified,
        provenance=tuple(map(scorecard.RunProvenance.of, documents)),
        budget=budget,
        runs=tuple(results.runs[protocol]),
        tasks=tasks,
        metrics=metric_values(results, references, protocol, runs),
        profile=profile(final),
        iqm=iqm(final),
        reference={task: scorecard.ReferenceValue.of(references.tasks.get(task)) for task in tasks},
        return_matrix=tuple(tuple(map(tuple, run)) for run in results.means[protocol]),
        success_rates=results.success_rates(protocol),
        curves=tuple(
            scorecard.TrainingCurve(run, task, tuple(zip(steps, values, strict=True)))
            for (name, run, task), (steps, values) in results.curves.items()
            if name == protocol and run in results.runs[protocol]
        ),
        episode_sketches=sketches,
        paper_table=rows,
        paper_total=total,
    )
