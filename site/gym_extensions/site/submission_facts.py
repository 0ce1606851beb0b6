"""Facts of a submission in words: its level, how it was verified, and what its manifest states."""

from gym_extensions.scoring.ranking.boards import is_verified
from gym_extensions.scoring.scorecard import NO_RUNS, Scorecard
from gym_extensions.site.text import count, grouped
from gym_extensions.submissions.review import CLAIMED, REPORTED, TRAINED_HERE, VERIFIED

LEVELS = {
    REPORTED: "Published elsewhere without logs, so nothing can be checked.",
    CLAIMED: (
        "The files keep to every rule. Nothing else is known: the runs publish no policies, nobody has "
        "verified them yet, or a verification did not pass."
    ),
    VERIFIED: (
        "The board’s own machine ran the policies of every run on seeds that did not exist when they were "
        "submitted, and their returns agree with the log. The page of the submission says how many logged "
        "episodes were repeated bit for bit. How the policies were made is the author’s statement; a run "
        "that was trained again from its seed and agrees is marked as reproduced."
    ),
    TRAINED_HERE: (
        "The project trained the runs itself, from the author’s code, on seeds that followed from the merge. "
        "Nobody could choose among runs, train longer, or see the seeds."
    ),
}
"""What each level of a submission means, from the lowest."""
NOT_STATED = "not stated"


def task_label(card: Scorecard) -> str:
    """When the agent receives the task label: ``none``, ``training``, ``evaluation`` or both."""
    if card.manifest is None:
        return NOT_STATED
    observes = card.manifest.observes
    times = {"training": observes.task_in_training, "evaluation": observes.task_in_evaluation}
    return " and ".join(name for name, received in times.items() if received) or "none"


def stored(card: Scorecard) -> str:
    """The maximum number of transitions that the agent stores."""
    memory = card.manifest.memory if card.manifest else None
    return NOT_STATED if memory is None else grouped(memory.stored_steps)


def dated(card: Scorecard) -> str:
    """When a submission was accepted, or else last verified, YYYY-MM-DD; empty without either."""
    return card.accepted or next((found.date for found in reversed(card.verifications)), "")


def has_policies(card: Scorecard) -> bool:
    """Whether a run of a whole scorecard publishes its policies."""
    scores = [score for protocols in card.groups.values() for score in protocols.values()]
    return is_verified(card.level) or any(made.policies for score in scores for made in score.provenance)


def checked(card: Scorecard) -> str:
    """How a submission was verified, in a sentence or two; what its level means if it was not."""
    if card.level == CLAIMED:
        reasons = (log.why_claimed for protocols in card.groups.values() for log in protocols.values())
        why = next(filter(None, reasons), "Not verified yet." if card.groups else NO_RUNS)
        return f"Claimed: the files keep to every rule. {why}"
    if not is_verified(card.level) or card.level == TRAINED_HERE:
        return LEVELS[card.level] if card.level else ""
    passed = [found for found in card.verifications if found.passed and found.current]
    runs, episodes, repeated = (
        sum(getattr(found, name) for found in passed) for name in ("current", "episodes", "repeated")
    )
    text = f"Verified: the policies of {count(runs, 'run')} were run on new seeds and agree with the logs"
    if episodes:
        text += f"; {grouped(repeated)} of {grouped(episodes)} logged episodes were repeated bit for bit"
    if card.arithmetic == 1:
        text += " on the type of processor that logged them (first arithmetic)"
    if episodes > repeated:
        text += f", the other {grouped(episodes - repeated)} differ"
    again = any(found.retrained for found in passed)
    return text + (". A run was trained again and agrees." if again else ".")


def parameters(card: Scorecard) -> str:
    """At the end of training, in the core and in the largest group; at the start, too, if it differs.

    Runs state the largest network of their submission, which need not be that of their own group.
    """
    if card.manifest is None or not (memory := card.manifest.memory):
        return NOT_STATED
    on_core, largest = card.core.cost.parameters if card.core else None, memory.parameters_last
    if on_core is None or on_core == largest:
        return " → ".join(map(grouped, dict.fromkeys((memory.parameters_first, largest))))
    return f"{grouped(on_core)} on the core, {grouped(largest)} in the largest group"


def facts(card: Scorecard) -> list[tuple[str, str]]:
    """What the manifest states on training and evaluation, as (label, value)."""
    if (manifest := card.manifest) is None:
        return []
    tuning = NOT_STATED
    if spent := manifest.tuning:  # the steps for choosing the settings
        on = f" on {', '.join(spent.tasks)}" if spent.tasks else ""
        tuning = f"{grouped(spent.steps)} steps{on}" if spent.steps else "none declared"
    return [
        ("Algorithm", manifest.protocol.algorithm),
        ("Actions in evaluation", manifest.protocol.evaluation),
        ("Training steps", "counted by the training loop" if card.steps_counted else "claimed"),
        ("Task label", task_label(card)),
        ("Task boundaries", "observed" if manifest.observes.boundaries else "not observed"),
        ("Batch or replay buffer", stored(card)),
        ("Parameters", parameters(card)),
        ("Tuning", tuning),
    ]
