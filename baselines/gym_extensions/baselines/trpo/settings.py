"""The hyperparameters of the TRPO agents, in one table."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from gym_extensions.baselines.agent import Setting
from gym_extensions.baselines.trpo.update import TrustRegion
from gym_extensions.baselines.trpo.value_function import ValueFit


@dataclass(frozen=True)
class TrpoSettings:
    """Hyperparameters of one agent; the comments of the two instances below name the source of each value.

    Args:
        hidden: widths of the policy's hidden layers.
        activation: name of the policy's hidden activation.
        tanh_mean: whether the mean action is squashed by a tanh.
        initial_log_sigma: initial log σ of every action component, in half-widths of the action box.
        last_layer_scale: factor on the policy's initial output weights.
        normalize_observations: whether the policy sees standardized observations.
        deterministic_evaluation: whether ``act`` returns the mean action or a sample.
        discount: γ.
        gae_lambda: λ of generalized advantage estimation.
        trust_region: limits of an update.
        default_batch: transitions per batch where the environment has no ``batch_steps``.
        value: the value function and its regression.
    """

    hidden: tuple[int, ...]
    activation: str
    tanh_mean: bool
    initial_log_sigma: float
    last_layer_scale: float
    normalize_observations: bool
    deterministic_evaluation: bool
    discount: float
    gae_lambda: float
    trust_region: TrustRegion
    default_batch: int
    value: ValueFit = field(default_factory=ValueFit)


REFERENCE = TrpoSettings(
    hidden=(64, 64),  # Schulman et al. 2017, section 6.1; the default of Stable-Baselines3
    activation="tanh",  # the same
    tanh_mean=False,  # the same
    initial_log_sigma=-1.0,  # docs/learners.md; Andrychowicz et al. 2021 recommend σ = .5, log σ = −.7
    last_layer_scale=0.01,  # Andrychowicz et al. 2021: a last layer 100 times smaller
    normalize_observations=True,  # Andrychowicz et al. 2021; RL Zoo's and OpenAI Baselines' TRPO on MuJoCo
    deterministic_evaluation=True,  # the default of Stable-Baselines3's evaluate_policy
    discount=0.995,  # docs/learners.md; RL Zoo and OpenAI Baselines use .99
    gae_lambda=0.95,  # RL Zoo's TRPO on MuJoCo
    trust_region=TrustRegion(
        max_kl=0.04,  # RL Zoo's HalfCheetah; it averages over the action's components, this is their sum
        damping=0.1,  # RL Zoo's and OpenAI Baselines' TRPO on MuJoCo
        iterations=10,  # OpenAI Baselines' TRPO on MuJoCo
        least_log_sigma=-1.0,  # docs/learners.md: the exploration noise does not fall below its initial value
    ),
    default_batch=2_000,  # the budget "100k"
)
"""``trpo``: the reference agent."""

TUNING_STEPS = 40_800_000
TUNING_TASKS = (
    "HalfCheetah",
    "Hopper",
    "Walker2d",
    "Hopper at 0.9 gravity",
    "Walker2d at 0.9 gravity",
    "HalfCheetah at 0.9 gravity",
)
"""The trials that chose the settings of ``trpo``: docs/learners.md lists them."""

HENDERSON_2017 = TrpoSettings(
    hidden=(100, 50, 25),  # Henderson et al. 2017
    activation="relu",  # the same
    tanh_mean=True,  # the same
    initial_log_sigma=0.0,  # rllab's default
    last_layer_scale=0.01,  # this project: the first mean is the middle of the action box
    normalize_observations=False,  # Henderson et al. 2017
    deterministic_evaluation=False,  # the same
    discount=0.99,  # the same
    gae_lambda=1.0,  # the same
    trust_region=TrustRegion(
        max_kl=0.01,  # the same
        damping=1e-5,  # the same
        iterations=10,  # rllab's default
    ),
    default_batch=5_000,  # the budget "1M"
)
"""``trpo-2017``: the settings of the paper; an MLP value function in place of rllab's linear baseline."""


def manifest_settings(settings: TrpoSettings) -> Mapping[str, Setting]:
    """The rows of a submission's manifest."""
    region, value = settings.trust_region, settings.value
    widths = "-".join(map(str, value.hidden))
    network = f"MLP {widths} {value.activation}"
    return {
        "hidden": list(settings.hidden),
        "activation": settings.activation,
        "tanh_mean": settings.tanh_mean,
        "initial_log_sigma": settings.initial_log_sigma,
        "least_log_sigma": "none" if math.isinf(region.least_log_sigma) else region.least_log_sigma,
        "normalize_observations": settings.normalize_observations,
        "max_kl": region.max_kl,
        "gae_lambda": settings.gae_lambda,
        "discount": settings.discount,
        "cg_damping": region.damping,
        "cg_iterations": region.iterations,
        "value_function": f"{network}, {value.epochs} epochs of Adam at {value.learning_rate:g} per batch",
    }
