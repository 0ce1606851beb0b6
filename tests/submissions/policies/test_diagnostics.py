"""Norms, ranks, inactive units and divergences, from networks that can be computed by hand."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gym_extensions import policies
from gym_extensions.errors import BenchError
from gym_extensions.submissions.policies.diagnostics import diagnose, inactive_share, stable_rank
from gym_extensions.submissions.policies.mlp import Policy, hidden_outputs

SUBMISSIONS = Path(__file__).resolve().parents[3] / "submissions"
SEEN = np.random.default_rng(0).normal(size=(50, 2))


def network(shift: float = 0.0, log_sigma: float = 0.0, activation: str = "tanh") -> Policy:
    """Two inputs, three hidden units, one action."""
    first, second = np.array([[1.0, 0.0, 2.0], [0.0, 1.0, 0.0]]), np.array([[3.0], [0.0], [4.0]])
    return Policy(
        action_offset=np.zeros(1),
        action_scale=np.ones(1),
        weights=(first, second),
        biases=(np.zeros(3), np.array([shift])),
        activation=activation,
        log_sigma=np.array([log_sigma]),
        observation_dtype="float64",
    )


def test_a_network_has_its_size_its_norms_and_the_outputs_of_its_hidden_layers() -> None:
    (found,) = diagnose([network()], [SEEN])
    assert found.parameters == 6 + 3 + 3 + 1 + 1
    assert found.norms == pytest.approx((6**0.5, 5.0))
    (hidden,) = hidden_outputs(network(), SEEN)
    assert hidden == pytest.approx(np.tanh(SEEN @ network().weights[0]), abs=1e-12)
    assert found.ranks == pytest.approx((stable_rank(hidden),))
    assert (found.distances, found.kl, found.drift) == ((), None, ())


def test_a_rank_is_a_mean_over_tasks_of_the_network_that_acts_in_each() -> None:
    second = network().weights[0][:, ::-1] * (1.0, 3.0, 0.5)
    both = replace(network(), weights=(np.stack([network().weights[0], second]), network().weights[1]))
    alone = [replace(network(), weights=(first, network().weights[1])) for first in both.weights[0]]
    ranks = [diagnose([each], [SEEN])[0].ranks or () for each in alone]
    assert diagnose([both], [SEEN, SEEN])[0].ranks == pytest.approx(np.mean(ranks, axis=0))


def test_masked_weights_have_no_norm_and_make_no_distance() -> None:
    masks = (np.ones((2, 3), np.bool_), np.array([[True], [True], [False]]))
    first, second = diagnose([replace(network(), masks=masks), network()], [SEEN])
    assert first.norms == pytest.approx((6**0.5, 3.0))
    assert second.distances == pytest.approx((4.0,))


def test_the_stable_rank_is_that_of_the_directions_in_which_outputs_vary() -> None:
    orthogonal = np.kron(np.eye(4), np.array([[1.0], [-1.0]]))
    assert stable_rank(orthogonal) == pytest.approx(4.0)
    assert stable_rank(orthogonal * (2.0, 1.0, 1.0, 1.0)) == pytest.approx(7 / 4)
    assert stable_rank(orthogonal[:, :1] * (1.0, 5.0) + 100.0) == pytest.approx(1.0), "a constant adds none"
    assert stable_rank(np.ones((5, 3))) == 1.0


def test_outputs_of_tanh_saturate_and_other_units_lie_dormant() -> None:
    outputs = np.array([[0.95, 0.1, -0.99, 0.0], [0.2, 0.1, -0.9, 0.0]])
    assert inactive_share(outputs, "tanh") == 3 / 8
    assert inactive_share(outputs, "relu") == 1 / 4
    assert inactive_share(np.zeros((2, 4)), "relu") == 1.0


def test_the_divergence_is_that_of_gaussians_on_the_observations_of_each_task() -> None:
    stages = [network(), network(shift=1.0), network(shift=1.0, log_sigma=1.0), network(shift=3.0)]
    found = diagnose(stages, [SEEN, SEEN[:5]])
    assert found[1].kl == pytest.approx((0.5, 0.5)), "(Δμ)² / 2σ²"
    narrower = 1.0 + (1.0) / (2 * math.exp(2)) - 0.5
    assert found[2].kl == pytest.approx((narrower, narrower))
    assert found[3].drift == pytest.approx((2.0, -1.0 + (math.exp(2) + 4) / 2 - 0.5))
    assert [each.distances for each in found] == [(), (0.0,), (0.0, 0.0), (0.0, 0.0, 0.0)]


def test_the_drift_follows_the_order_of_training() -> None:
    weights = tuple(np.stack([each, each]) for each in network().weights)
    biases = [(np.zeros((2, 3)), np.array([[0.0], [second]])) for second in (0.0, 0.0, 1.0)]  # by stage
    stages = [replace(network(), weights=weights, biases=each) for each in biases]
    assert diagnose(stages, [SEEN, SEEN])[2].drift == (0.0,)
    assert diagnose(stages, [SEEN, SEEN], (1, 0))[2].drift == (0.5,)


def test_without_a_stated_deviation_there_is_no_divergence() -> None:
    found = diagnose([network(), replace(network(), log_sigma=None)], [SEEN])
    assert (found[1].kl, found[1].distances) == (None, (0.0,))


def test_observations_that_do_not_fit_are_one_sentence() -> None:
    with pytest.raises(BenchError, match=r"The observations have 5 values; the policy has 2 inputs\."):
        diagnose([network()], [np.zeros((3, 5))])
    with pytest.raises(BenchError, match="No observations of nav-image are published"):
        policies.diagnose([network()], "nav-image")
    for wrong in ([], [network()] * 4, network()):
        with pytest.raises(BenchError, match=r"observations of 2 tasks\. Pass a list: the untrained policy"):
            policies.diagnose(wrong, [SEEN, SEEN])  # type: ignore[arg-type]
    with pytest.raises(BenchError, match=r"A task has no observations"):
        policies.diagnose([network()], [SEEN, SEEN[:0]])


@pytest.mark.committed
def test_packnet_does_not_change_what_it_learned() -> None:
    """Its weights of earlier tasks are frozen, and its heads are those of a task."""
    source = SUBMISSIONS / "ppo-packnet-tuned"
    stages = [policies.load(source, "hopper-gravity", stage=stage) for stage in range(6)]
    found = policies.diagnose(stages, "hopper-gravity")
    assert found[5].drift == (0.0,) * 4
    assert found[5].kl is not None
    assert found[5].kl[:4] == (0.0,) * 4
    assert found[5].kl[4] > 1.0
