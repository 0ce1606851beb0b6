"""In the second edition, maintainers train what the core compares; nobody else is asked to."""

from collections.abc import Sequence
from dataclasses import replace

import msgspec

from gym_extensions.scoring.ranking.wanted import Wanted, wanted
from gym_extensions.scoring.scorecard import Scorecard, TrainingSummary
from gym_extensions.scoring.submission.core_score import core_score

from .conftest import GROUPS, OnCore, board_of, normal, trained


def wanted_of(cards: Sequence[Scorecard]) -> list[Wanted]:
    """What submissions need, of which those called trpo and other are of the project's own agents."""
    made = []
    for card in cards:
        assert card.manifest is not None
        protocol = msgspec.structs.replace(card.manifest.protocol, algorithm=card.name)
        manifest = replace(card.manifest, protocol=protocol)
        made.append(replace(card, manifest=manifest, core=core_score(card)))
    return wanted(made, board_of(made), ["trpo", "other"])


def test_maintainers_train_the_next_look_of_what_was_trained_here(on_core: OnCore) -> None:
    trpo = trained(on_core("trpo", normal(3, 0.3, runs=10)), normal(4, 0.3))
    stranger = trained(on_core("stranger", normal(3, 0.3)), normal(5, 0.3))
    part = on_core("other", {name: runs for name, runs in normal(1, 0.5).items() if name != GROUPS[0]})
    found = wanted_of([trpo, stranger, part])
    assert {each.name: each.commands() for each in found} == {
        name: [f"gym-extensions maintain train-here submissions/{name} --runs 10"]
        for name in ("trpo", "stranger")
    }
    assert all(each.trained_here and each.count == 5 * len(GROUPS) for each in found)
    changed = TrainingSummary(
        attempts=1, date="", version="", commit="", value="", agent="", failed={}, outdated=True
    )
    found = wanted_of([trpo, replace(stranger, training=changed)])
    assert [each.name for each in found] == ["trpo"], "the next training is one of other code, from run 0 on"


def test_in_the_first_edition_runs_are_donated(on_core: OnCore) -> None:
    found = {
        each.name: each for each in wanted_of([on_core(name, normal(3, 0.3)) for name in ("trpo", "foreign")])
    }
    assert list(found) == ["trpo"]
    assert found["trpo"].commands()[0].startswith("gym-extensions train trpo ")
    assert not found["trpo"].trained_here
