"""One submission -> its scorecard."""

from __future__ import annotations

from gym_extensions.catalog.protocol import FULL_ENTRY_RUNS
from gym_extensions.rollouts.submission import Evidence, Submission
from gym_extensions.scoring.metrics.aggregates import iqm, profile
from gym_extensions.scoring.metrics.evaluate import metric_values, no_reference
from gym_extensions.scoring.metrics.normalization import normalized_runs
from gym_extensions.scoring.metrics.paper_table import paper_table
from gym_extensions.scoring.metrics.returns import Rates, Results, results, success_rates
from gym_extensions.scoring.references import References
from gym_extensions.scoring.scorecard.manifest import summarize_manifest
from gym_extensions.scoring.scorecard.model import (
    REPORTED,
    VALIDATED,
    Curve,
    GroupScore,
    ReferenceValue,
    Scorecard,
)
from gym_extensions.scoring.scorecard.reported import reported_groups
from gym_extensions.scoring.scorecard.signs import signs
from gym_extensions.scoring.scorecard.sketches import Sketch, episode_sketches
from gym_extensions.scoring.scorecard.suites import suite_scores

NO_REFERENCE = ReferenceValue(None, None, None)


def _reference(task: str, references: References) -> ReferenceValue:
    reference = references.tasks.get(task)
    if reference is None:
        return NO_REFERENCE
    return ReferenceValue(reference.floor, reference.ceiling, reference.unsolved)


def _success_rates(results: Results, protocol: str) -> Rates:
    return success_rates(results.successes[protocol]) if protocol in results.successes else ()


def missing_for_full_entry(results: Results, protocol: str) -> tuple[str, ...]:
    """What a full entry of this group and protocol still needs, in words. A rank needs the runs alone."""
    more = FULL_ENTRY_RUNS - len(results.runs[protocol])
    runs = [f"{more} more run{'s' if more > 1 else ''}"] if more > 0 else []
    present = {*results.runs, *(["curves"] if results.curves else [])}
    needed = ("single", "joint", "curves") if protocol == "sequential" else ("sequential",)
    return (*runs, *(f"{name}.csv" for name in needed if name not in present))


def missing_evidence(evidence: Evidence) -> str:
    """Why the traces of a log do not suffice for a rank, in words; empty if they do."""
    if not evidence.sample:
        return "The log does not commit to traces."
    if evidence.missing:
        return f"{evidence.missing} of {evidence.sample} traces of the audit sample are missing."
    return ""


def score_group(
    results: Results,
    references: References,
    protocol: str,
    budget: str,
    *,
    sketches: tuple[Sketch, ...] = (),
    missing: str = "",
) -> GroupScore:
    """Scores one group and protocol, with metrics, the paper's table, references and raw returns."""
    normalized = no_reference(results, references) == ""
    runs = normalized_runs(results, references, protocol) if normalized else []
    final = [[run.p(run.T, j) for j in run.scored] for run in runs]
    rows, total = paper_table(results) if protocol == "sequential" else ((), None)
    return GroupScore(
        published=results.group.published,
        budget=budget,
        runs=tuple(results.runs[protocol]),
        tasks=results.group.task_ids,
        metrics=metric_values(results, references, protocol, runs),
        profile=profile(final),
        iqm=iqm(final),
        reference={task: _reference(task, references) for task in results.group.task_ids},
        return_matrix=tuple(tuple(map(tuple, run)) for run in results.means[protocol]),
        success_rates=_success_rates(results, protocol),
        curves=tuple(
            Curve(run, task, tuple(zip(steps, values, strict=True)))
            for (name, run, task), (steps, values) in results.curves.items()
            if name == protocol and run in results.runs[protocol]
        ),
        episode_sketches=sketches,
        missing_evidence=missing,
        missing_for_full_entry=missing_for_full_entry(results, protocol),
        paper_table=rows,
        paper_total=total,
    )


def score(submission: Submission, references: References) -> Scorecard:
    """The scorecard of one submission. With problems, it has neither trust nor groups."""
    manifest = submission.manifest
    scored = manifest is not None and not submission.problems
    trust = (REPORTED if manifest.reported else VALIDATED) if manifest and scored else None
    groups: dict[str, dict[str, GroupScore]] = {}
    patterns: list[str] = []
    if manifest and trust == REPORTED:
        groups = reported_groups(manifest.reported, manifest.protocol.budget)
    elif manifest and trust == VALIDATED:
        for name, entry in submission.groups.items():
            returns = results(entry, manifest.protocol.budget)
            groups[name] = {
                protocol: score_group(
                    *(returns, references, protocol, manifest.protocol.budget),
                    sketches=episode_sketches(entry.logs[protocol]),
                    missing=missing_evidence(entry.evidence.get(protocol, Evidence())),
                )
                for protocol in returns.runs
            }
            patterns += signs(entry, manifest.protocol.evaluation == "sampled")
    return Scorecard(
        name=submission.name,
        title=manifest.title if manifest else submission.name,
        trust=trust,
        problems=submission.problems,
        manifest=summarize_manifest(manifest) if manifest else None,
        readme=submission.readme,
        notes=tuple(f"{name}: {note}" for name, entry in submission.groups.items() for note in entry.notes),
        signs=tuple(patterns),
        groups=groups,
        suites={} if trust == REPORTED else suite_scores(groups),
    )
