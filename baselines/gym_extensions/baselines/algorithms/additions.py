"""Additions to the actor of a Stable-Baselines3 model: reset, snapshots, cloning, online EWC and PackNet.

The model trains as it is. An addition sees the parameters, the gradients and stored observations of its
:class:`Actor`, not the learner: hooks around the steps of torch's optimizer add the gradient of a penalty, or
mask gradients and restore values; a callback collects observations. So the same addition fits PPO, SAC and
every algorithm whose actor is a Gaussian perceptron. Only the actor is held; critics, entropy coefficient and
replay buffer belong to the learner. TRPO has its own form of a penalty (``continual``), because its step
needs the curvature; both read the same formulas.
"""

import math
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import replace
from typing import Any, ClassVar, cast

import numpy as np
import torch
from torch.distributions import Normal, kl_divergence

from gym_extensions.baselines.adapters import sb3_policy
from gym_extensions.baselines.adapters.sb3 import Sb3Agent, Sb3Factory
from gym_extensions.baselines.agent import Array, Card, Context, Setting, VectorEnv
from gym_extensions.baselines.algorithms import continual, multi_head, packnet
from gym_extensions.baselines.generators import spawn_seeds
from gym_extensions.baselines.trust_region.policy import layers
from gym_extensions.errors import BenchError, require_known
from gym_extensions.submissions.manifest import Observes
from gym_extensions.submissions.policies.mlp import Policy, by_task

STATES_PER_STEP = 256  # stored states that ``cloning`` draws for each step of the optimizer


def flat(tensors: Iterable[torch.Tensor]) -> Array:
    """Tensors as one vector, weights as (in, out): the order of :mod:`.trust_region.policy`."""
    return np.concatenate([each.detach().t().numpy().ravel() for each in tensors])


def write(values: Array, tensors: Iterable[torch.Tensor]) -> None:
    """Sets tensors to the values of such a vector."""
    start = 0
    for each in tensors:
        part = torch.as_tensor(values[start : start + each.numel()])
        each.detach().t().copy_(part.view(each.t().shape))
        start += each.numel()


class Actor:
    """The Gaussian policy of an agent's model: hidden layers, and a head of the layer of the mean and log σ.

    ``parameters`` are those of the hidden layers, then those of the head; ``sizes`` are the widths of all
    layers.

    Raises ``BenchError`` (``no-actor``) if the model has no such policy; it names agent and algorithm.
    """

    def __init__(self, agent: Sb3Agent) -> None:
        model, plain = agent._model, dict[str, Any]()
        self.policy: Any = model.policy
        self.normalizer = agent._normalizer
        with suppress(*sb3_policy.NOT_PLAIN):
            plain = sb3_policy.plain_parts(model)
        is_other = hasattr(self.policy, "actor_state") or getattr(model, "use_sde", False)
        if "log_sigma" not in plain or is_other:
            message = f"{type(model).__name__} has no actor that is a Gaussian perceptron of PyTorch."
            hint = "Use PPO, A2C or SAC of Stable-Baselines3 with MlpPolicy, without use_sde, or no addition."
            raise BenchError("no-actor", message, agent._options.card.algorithm, hint)
        owner: Any = self.policy.actor if self.policy.squash_output else self.policy
        if self.policy.squash_output:  # SAC and TQC
            hidden, head = owner.latent_pi, [*owner.mu.parameters(), *owner.log_std.parameters()]
        else:
            hidden, head = owner.mlp_extractor.policy_net, [*owner.action_net.parameters(), owner.log_std]
        self.parameters: list[torch.Tensor] = [*hidden.parameters(), *head]
        self.optimizer: torch.optim.Optimizer = owner.optimizer  # that of PPO and A2C has the critic, too
        self.num_hidden = sum(each.numel() for each in hidden.parameters())
        self.sizes = (len(plain["weights"][0]), *(weights.shape[1] for weights in plain["weights"]))

    @property
    def theta(self) -> Array:
        """The parameters (p,)."""
        return flat(self.parameters)

    @property
    def gradients(self) -> list[torch.Tensor]:
        """Those of the parameters, in a step of the optimizer."""
        return [each.grad for each in self.parameters if each.grad is not None]

    def gaussian(self, observations: Array) -> Normal:
        """The distributions of the actions for observations (n, o), with their present statistics.

        SAC's are those before its tanh, which changes neither KL nor Fisher matrix.
        """
        if self.normalizer is not None:
            observations = np.asarray(self.normalizer.normalize_obs(observations))
        inputs = torch.as_tensor(observations, dtype=torch.float32)
        if not self.policy.squash_output:
            return self.policy.get_distribution(inputs).distribution
        mean, log_sigma, _ = self.policy.actor.get_action_dist_params(inputs)
        return Normal(mean, log_sigma.exp())

    def fisher(self, observations: Array) -> Array:
        """The diagonal of the Fisher matrix (p,), a mean over observations (n, o), exact over actions.

        It is Σₐ (∂μₐ/∂θᵢ)² / σₐ² + 2 (∂ log σₐ/∂θᵢ)², as of ``continual.diagonal_fisher``.
        """
        total = np.zeros(len(self.theta))
        for state in observations:
            normal = self.gaussian(state[None])
            scaled = torch.cat([normal.mean / normal.stddev.detach(), math.sqrt(2) * normal.stddev.log()], 1)
            for each in scaled[0]:
                slope = torch.autograd.grad(each, self.parameters, retain_graph=True, materialize_grads=True)
                total += flat(slope) ** 2
        return total / len(observations)


class Addition(Sb3Agent):
    """An SB3 agent whose actor has an addition. Subclasses override the methods that theirs needs."""

    name = title = description = ""
    settings: ClassVar[dict[str, Setting]] = {}  # the defaults
    observed: ClassVar[Observes] = Observes(boundaries=True)

    def __init__(self, spaces: Any, seed: int, options: Sb3Factory) -> None:
        super().__init__(spaces, seed, options)
        self.observes, self._method = self.observed, dict[str, Any](options.method)
        self._stored, self._most_stored = dict[str, Array](), 0
        self._draws = np.random.default_rng(self._seed)
        Actor(self)  # refused before training

    def _train(self, steps: int, *callbacks: Callable[..., bool]) -> None:
        actor = Actor(self)
        sample = continual.StateSample(self._method.get("states_per_task", 0), steps)

        def watch(local: dict[str, Any], _: object) -> bool:
            seen = self._normalizer.get_original_obs() if self._normalizer else local["new_obs"]
            sample.add(np.asarray(seen))
            self._after_env_step(actor, sample.seen)
            return True

        hooks = (  # a saved optimizer has none, so every stage sets its own
            actor.optimizer.register_step_pre_hook(lambda *_: self._before_optimizer_step(actor)),
            actor.optimizer.register_step_post_hook(lambda *_: self._after_optimizer_step(actor)),
        )
        try:
            super()._train(steps, watch, *callbacks)
        finally:
            for hook in hooks:
                hook.remove()
        held = len(sample.observations) + len(self._stored.get("observations", ()))
        self._most_stored = max(self._most_stored, held)
        self._end_of_task(actor, sample.observations)

    def _after_env_step(self, actor: Actor, taken: int) -> None:
        """After each step of the environments; ``taken`` is the number of steps of the task so far."""

    def _before_optimizer_step(self, actor: Actor) -> None:
        """Before a step of the optimizer: adds the gradient of the penalty, after SB3 clipped its own."""
        if self._method.get("coefficient") and self._stored:
            write(flat(actor.gradients) + self._penalty_gradient(actor), actor.gradients)

    def _penalty_gradient(self, actor: Actor) -> Array:
        """The gradient of the penalty (p,), for additions with a coefficient."""
        raise NotImplementedError

    def _after_optimizer_step(self, actor: Actor) -> None:
        """After a step of the optimizer: changes the parameters."""

    def _end_of_task(self, actor: Actor, observations: Array) -> None:
        """The end of a task, of which these observations (n, o) were sampled."""

    def card(self) -> Card:
        card = super().card()
        return replace(card, stored_steps=card.stored_steps + self._most_stored)


class Reset(Addition):
    """A fresh model for every task after the first, with its critics, statistics and replay buffer."""

    name, title, description = "reset", "reset", "a fresh model for every task: no transfer and no memory"

    def learn(self, env: VectorEnv, steps: int) -> None:
        if self._trained:
            fresh = Sb3Agent(self._spaces, spawn_seeds(self._seed, 1)[0], self._options)
            kept = {name: getattr(self, name) for name in ("_acting", "observes")}
            vars(self).update(vars(fresh) | kept)
        super().learn(env, steps)


class Cloning(Addition):
    """Penalty c · mean KL(old ‖ new) over stored states of earlier tasks, of which each step draws some."""

    name, title = "cloning", "behavioral cloning"
    description = "a penalty on KL(old ‖ new policy) in stored states of each task"
    settings: ClassVar[dict[str, Setting]] = {
        "coefficient": 0.1,  # that of trpo, whose surrogate has the same scale as PPO's
        "states_per_task": continual.STATES_PER_TASK,
    }

    def _penalty_gradient(self, actor: Actor) -> Array:
        rows = self._draws.integers(len(self._stored["observations"]), size=STATES_PER_STEP)
        means, sigmas = (torch.as_tensor(self._stored[name][rows]) for name in ("means", "sigmas"))
        old, new = Normal(means, sigmas), actor.gaussian(self._stored["observations"][rows])
        penalty = self._method["coefficient"] * kl_divergence(old, new).sum(1).mean()
        return flat(torch.autograd.grad(penalty, actor.parameters))

    def _end_of_task(self, actor: Actor, observations: Array) -> None:
        with torch.no_grad():
            policy = actor.gaussian(observations)
        new = {"means": policy.mean.numpy(), "sigmas": policy.stddev.numpy(), "observations": observations}
        self._stored = continual.appended(self._stored, new)


class OnlineEwc(Addition):
    """Penalty c/2 · Σᵢ ωᵢ (θᵢ − θ*ᵢ)² of ``online-ewc``."""

    name, title = "online-ewc", "online EWC"
    description = "online elastic weight consolidation of its actor"
    settings: ClassVar[dict[str, Setting]] = Cloning.settings | {"decay": continual.OnlineEwc.decay}

    def _penalty_gradient(self, actor: Actor) -> Array:
        stored = self._stored["importance"], self._stored["anchor"]
        return continual.Quadratic(self._method["coefficient"], *stored).gradient(actor.theta)

    def _end_of_task(self, actor: Actor, observations: Array) -> None:
        before = self._stored.get("importance")
        importance = continual.accumulated(actor.fisher(observations), before, self._method["decay"])
        self._stored = {"anchor": actor.theta, "importance": importance}


class Snapshots(Addition):
    """A copy of the policy per task. It learns as its base does; the task label picks the copy."""

    name, title = "snapshots", "snapshots"
    description = "a copy of its policy per learned task; it observes the task"
    observed = multi_head.MultiHead.observes
    shares_hidden_layers = False

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._task, self._kept = 0, dict[int, Policy]()
        self._samples = np.random.default_rng(self._seed + 1)  # of actions in earlier tasks

    def learn(self, env: VectorEnv, steps: int) -> None:
        """Learns one task. Raises ``BenchError`` if the environments run several tasks."""
        self._task = multi_head.single_task(env, self._options.card.algorithm)
        self._num_tasks = int(env.num_tasks)  # type: ignore[attr-defined]  # of the training environments
        super().learn(env, steps)
        self._kept[self._task] = self._present()

    def _present(self) -> Policy:
        """The model's policy, which is plain, because the model has an ``Actor``."""
        return cast(Policy, super().policy())

    def _policy_of(self, task: int) -> Policy:
        """The policy in a finished task."""
        return self._kept[task]

    def policy(self) -> Policy:
        """The policy as plain arrays, with a row per task as that of ``multi-head``."""
        if not self._kept:
            return self._present()
        kept = {task: self._policy_of(task) for task in self._kept}
        rows = multi_head.rows_of(kept, self._task, self._num_tasks)
        return by_task(rows, len(rows[0].weights) - 1 if self.shares_hidden_layers else 0)

    def act(self, observations: Array, context: Context | None = None) -> Array:
        """Acts as in the context's task; without a context, as in the present one."""
        if context is not None and context.task in self._kept:
            return self._policy_of(context.task).act(observations, self._samples)
        return super().act(observations, context)

    def card(self) -> Card:
        """The card with the parameters of all copies."""
        card, actor = super().card(), Actor(self)
        copied = len(actor.theta) - (actor.num_hidden if self.shares_hidden_layers else 0)
        return replace(card, parameters=card.parameters + max(len(self._kept) - 1, 0) * copied)


class PackNet(Snapshots):
    """The schedule and the ownership of weights of ``packnet``, in the hidden layers of the actor.

    A task has its own head, the layer of the mean and log σ (SAC's layer of it), which starts as in a new
    model, and its own statistics of the observations. The critics have no heads and no owners, as the value
    function of ``packnet``. When a task begins or prunes, the optimizer's moments of the actor are those of
    other weights, so they start anew. After each step, what is not trainable gets its value back.
    """

    name, title = "packnet", "PackNet"
    description = "PackNet: tasks own weights of its actor and a head; it observes the task"
    settings: ClassVar[dict[str, Setting]] = {"retrain_share": packnet.RETRAIN_SHARE}
    shares_hidden_layers = True

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._owners, self._number = packnet.no_owners(Actor(self).sizes), 0
        self._numbers: dict[int, int] = {}  # by task: 1 for the one that was learned first

    def _train(self, steps: int, *callbacks: Callable[..., bool]) -> None:
        actor, number = Actor(self), self._number + 1
        self._number = self._numbers[self._task] = number
        self._left = self._num_tasks - number
        self._prune_at = (1 - self._method["retrain_share"]) * steps if self._left else math.inf
        if number > 1:
            fresh = Sb3Agent(self._spaces, spawn_seeds(self._seed, number)[-1], self._options)
            whole = actor.theta[: actor.num_hidden], Actor(fresh).theta[actor.num_hidden :]
            write(np.concatenate(whole), actor.parameters)
        self._train_only(actor, pruned=False)
        super()._train(steps, *callbacks)
        if not self._pruned:
            self._prune(actor)

    def _train_only(self, actor: Actor, pruned: bool) -> None:
        """What a task may train before or after it prunes; the optimizer forgets its moments."""
        own = packnet.trainable(self._owners, self._number, pruned)
        head = np.ones(len(actor.theta) - actor.num_hidden, bool)
        self._pruned, self._trainable = pruned, np.concatenate([own, head])
        for each in actor.parameters:
            actor.optimizer.state.pop(each, None)

    def _after_env_step(self, actor: Actor, taken: int) -> None:
        # In the first step of a rollout: the update before it used what was collected.
        if taken > self._prune_at and not self._pruned:
            self._prune(actor)

    def _prune(self, actor: Actor) -> None:
        theta = actor.theta
        hidden = theta[: actor.num_hidden]
        self._owners = packnet.claimed(actor.sizes, self._owners, hidden, self._number, self._num_tasks)
        hidden[self._owners == packnet.FREE] = 0
        write(theta, actor.parameters)
        self._train_only(actor, pruned=True)

    def _before_optimizer_step(self, actor: Actor) -> None:
        self._before = actor.theta
        write(flat(actor.gradients) * self._trainable, actor.gradients)

    def _after_optimizer_step(self, actor: Actor) -> None:
        write(np.where(self._trainable, actor.theta, self._before), actor.parameters)

    def _policy_of(self, task: int) -> Policy:
        """The head of the task on the present hidden layers, without the weights of later tasks."""
        own, present = self._kept[task], self._present()
        mask = packnet.visible(self._owners, self._numbers[task])
        return replace(
            own,
            weights=(*present.weights[:-1], own.weights[-1]),
            biases=(*present.biases[:-1], own.biases[-1]),
            masks=(*(weights for weights, _ in layers(Actor(self).sizes[:-1], mask)), None),
        )


KINDS: list[type[Addition]] = [Reset, Snapshots, Cloning, OnlineEwc, PackNet]
ADDITIONS = {kind.name: kind for kind in KINDS}


def with_addition(base: Sb3Factory, addition: str, **settings: Setting) -> Sb3Factory:
    """The factory of the same agents with an addition to their actor.

    ``base`` is that of ``ppo`` or ``sac64``, or your own of :func:`gym_extensions.baselines.sb3`.
    ``addition`` is a key of ``ADDITIONS``; ``settings`` change the defaults of its class.

    Raises ``BenchError`` if there is no such addition or setting, or ``base`` has an addition. The factory
    raises it (``no-actor``) if the algorithm has no actor that the addition can see.
    """
    require_known("addition", addition, ADDITIONS, "with_addition()")
    kind, name = ADDITIONS[addition], base.card.algorithm
    if base.kind is not None:
        message, hint = f"{name} already has an addition.", "Pass the agent without it."
        raise BenchError("second-addition", message, "with_addition()", hint)
    for each in settings:
        require_known("setting", each, kind.settings, f"with_addition(), {addition}")
    card = replace(
        base.card,
        algorithm=f"{name}-{addition}",
        title=f"{base.card.title or name} + {kind.title}",
        description=f"The agent {name} with {kind.description}.",
        parent="" if kind is PackNet else name,  # the first task's weights are pruned
    )
    return replace(base, card=card, kind=kind, method={**kind.settings, **settings})
