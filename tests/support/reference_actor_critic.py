"""A2C and PPO in float64 NumPy, with gradients by hand: what the learners are checked against.

Written from the literature and from PyTorch's documentation, and never from the learners' code:
the A2C of Mnih et al. (2016), the clipped objective of Schulman et al. (2017), the generalised
advantage of Schulman et al. (2016, equation 16), the Adam of Kingma and Ba (2015). Names are those
of the learners' settings. Slow and plain on purpose.

    steps(parameters, [rollout], learning_rate=1e-3)            one step
    steps(parameters, [rollout, rollout], learning_rate=1e-3)   two successive steps
    ppo_steps(parameters, rollout, minibatches, clip_range=0.2)

Beside it: `reference_networks` (multilayer perceptrons) and `reference_optimizers` (optimisers,
clipping, schedules, initial weights).
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int, Shaped
from reference_networks import (
    Inputs,
    Layer,
    Parameters,
    backward,
    forward,
    log_policy,
    log_softmax,
    values,
)
from reference_optimizers import Moments, apply, clipped, decayed, linear

Batch = Float[np.ndarray, " batch"]
Steps = Float[np.ndarray, "steps envs"]


@dataclass(frozen=True)
class Rollout:
    """The environments' outputs.

    Attributes:
        inputs: whole numbers are the rows of the first weight that are 1 (a one-hot factor each),
            numbers with a point the inputs themselves.
        cut_values: the value of the state that a step led to (before any reset). Only read where
            an episode was truncated and at the last step; elsewhere it is the next state's value.
        cut_inputs: that state's inputs, instead of its value.
        mask: which steps count; None: all. Once a step does not count, none after it does.
        available: which actions there are; None: all.
        count: what the schedules count when the update happens.
    """

    inputs: Shaped[np.ndarray, "steps envs features"]
    actions: Int[np.ndarray, "steps envs"]
    rewards: Steps
    terminated: Bool[np.ndarray, "steps envs"]
    truncated: Bool[np.ndarray, "steps envs"]
    cut_values: Steps | None = None
    cut_inputs: Shaped[np.ndarray, "steps envs features"] | None = None
    mask: Bool[np.ndarray, "steps envs"] | None = None
    available: Bool[np.ndarray, "steps envs actions"] | None = None
    count: float = 0

    def __post_init__(self) -> None:
        for name in ("inputs", "actions", "cut_inputs"):
            self._convert(name, None)
        for name in ("rewards", "cut_values"):
            self._convert(name, np.float64)
        for name in ("terminated", "truncated", "mask", "available"):
            self._convert(name, np.bool_)

    def _convert(self, name: str, dtype: type | None) -> None:
        if getattr(self, name) is not None:
            object.__setattr__(self, name, np.asarray(getattr(self, name), dtype))


@dataclass(frozen=True)
class Settings:
    """As those of the learners, without what only the environments need."""

    networks: str = "shared"
    activation: str = "tanh"
    optimizer: str = "adam"
    learning_rate: float = 1e-3
    learning_rate_end: float = 0.0
    learning_rate_steps: float = 0
    learning_rate_decay: float = 1.0
    learning_rate_every: float = 0
    clip: float = 0.0
    clip_epsilon: float = 0.0  # PyTorch's clip_grad_norm_ adds 1e-6 to the norm
    clip_range: float = 0.2
    entropy: float = 0.0
    entropy_end: float = 0.0
    entropy_steps: float = 0
    entropy_hold: float = 0
    value: float = 0.5
    discount: float = 0.99
    gae_lambda: float = 1.0
    normalise: bool = False
    normalise_over: str = "rollout"  # PPO only: or "minibatch"
    unbiased: bool = False
    reward_scale: float = 1.0
    limit_is_terminal: bool = False


class Loss(NamedTuple):
    """A loss and its parts; `total` is policy - entropy's weight * entropy + value's * value."""

    total: float
    policy: float
    entropy: float
    value: float


class Step(NamedTuple):
    """One step of the optimiser."""

    loss: Loss
    gradients: Parameters
    clipped: Parameters
    parameters: Parameters
    moments: Moments


class Batches(NamedTuple):
    """The steps that count, in one row."""

    inputs: Inputs
    actions: Int[np.ndarray, " batch"]
    available: Bool[np.ndarray, "batch actions"] | None
    advantages: Batch
    targets: Batch
    old_log_probs: Batch | None


# Advantages.


def generalised_advantages(
    rewards: Steps,
    values: Steps,
    next_values: Steps,
    terminated: Bool[np.ndarray, "steps envs"],
    truncated: Bool[np.ndarray, "steps envs"],
    discount: float,
    gae_lambda: float,
) -> Steps:
    """Sums over l of (gamma lambda)^l delta(t + l), up to the end of the episode or the rollout.

    delta(t) = r(t) + gamma V(next state) - V(s(t)), the value of a terminal state being 0.
    """
    found = np.zeros(rewards.shape)
    for start, env in np.ndindex(rewards.shape):
        for t in range(start, len(rewards)):
            later = 0.0 if terminated[t, env] else next_values[t, env]
            delta = rewards[t, env] + discount * later - values[t, env]
            found[start, env] += (discount * gae_lambda) ** (t - start) * delta
            if terminated[t, env] or truncated[t, env]:
                break
    return found


def standardised(x: Batch, *, unbiased: bool) -> Batch:
    """Less the mean, by the deviation + 1e-8; unbiased: the sum of squares by n - 1, not n."""
    centred = x - x.sum() / x.size
    variance = (centred**2).sum() / (x.size - 1 if unbiased else x.size)
    return centred / (np.sqrt(variance) + 1e-8)


def advantages_and_targets(
    parameters: Parameters, rollout: Rollout, settings: Settings
) -> tuple[Steps, Steps]:
    """The advantages, not standardised, and what the values are to become: V + advantage."""
    shape = rollout.rewards.shape

    def valued(x: np.ndarray) -> Steps:
        flat = values(parameters, x.reshape(-1, x.shape[-1]), settings.activation)
        return flat.reshape(shape)

    ends = rollout.terminated | rollout.truncated
    counts = _counts(rollout)
    if (counts[:-1] & ~counts[1:] & ~ends[:-1]).any() or (~counts[:-1] & counts[1:]).any():
        raise ValueError("mask: steps stop counting only where an episode ends, and for good")
    now = valued(rollout.inputs)
    if (rollout.cut_values is None) == (rollout.cut_inputs is None):
        raise ValueError("give either cut_values or cut_inputs")
    cut = valued(rollout.cut_inputs) if rollout.cut_inputs is not None else rollout.cut_values
    assert cut is not None
    later = np.where(rollout.truncated[:-1], cut[:-1], now[1:])
    limit = rollout.truncated & settings.limit_is_terminal
    found = generalised_advantages(
        rollout.rewards * settings.reward_scale,
        now,
        np.concatenate([later, cut[-1:]]),
        rollout.terminated | limit,
        rollout.truncated & ~rollout.terminated & ~limit,
        settings.discount,
        settings.gae_lambda,
    )
    return found, now + found


def _counts(rollout: Rollout) -> Bool[np.ndarray, "steps envs"]:
    everything = np.ones(rollout.rewards.shape, bool)
    return everything if rollout.mask is None else rollout.mask


def batched(
    parameters: Parameters, rollout: Rollout, settings: Settings, *, old_policy: bool = False
) -> Batches:
    """The steps that count, step by step and each step's environments together."""
    advantages, targets = advantages_and_targets(parameters, rollout, settings)
    counts = _counts(rollout)
    inputs, actions = rollout.inputs[counts], rollout.actions[counts]
    available = None if rollout.available is None else rollout.available[counts]
    rows = advantages[counts]
    if settings.normalise and settings.normalise_over == "rollout":
        rows = standardised(rows, unbiased=settings.unbiased)
    old = None
    if old_policy:
        log_probs = log_policy(parameters, inputs, settings.activation, available)
        old = log_probs[np.arange(len(actions)), actions]
    return Batches(inputs, actions, available, rows, targets[counts], old)


# Loss and gradient.


def loss_and_gradients(
    parameters: Parameters, batch: Batches, settings: Settings, entropy_weight: float
) -> tuple[Loss, Parameters]:
    """The mean loss over the batch and its gradient; advantages, targets, old policy constant.

    policy term: -log pi(a|s) A (A2C), or -min(rho A, clip(rho) A), rho = pi(a|s) / pi_old(a|s)
    (PPO, when the batch has old_log_probs); value term: (V(s) - target)^2.
    """
    n = len(batch.actions)
    name = settings.activation
    trunk, through_trunk = forward(parameters.trunk, batch.inputs, name, linear_end=False)
    logits, through_policy = forward(parameters.policy, trunk, name, linear_end=True)
    estimates, through_value = forward(parameters.value, trunk, name, linear_end=True)

    log_probs = log_softmax(logits, batch.available)
    probs = np.exp(log_probs)
    taken = np.zeros(probs.shape)
    taken[np.arange(n), batch.actions] = 1
    log_taken = log_probs[np.arange(n), batch.actions]
    finite = np.where(probs > 0, log_probs, 0)
    entropies = -(probs * finite).sum(axis=1)
    errors = estimates[:, 0] - batch.targets

    if batch.old_log_probs is None:
        policy_terms = -log_taken * batch.advantages
        by_log_prob = -batch.advantages
    else:
        ratio = np.exp(log_taken - batch.old_log_probs)
        low, high = 1 - settings.clip_range, 1 + settings.clip_range
        plain, bounded = (
            ratio * batch.advantages,
            np.clip(ratio, low, high) * batch.advantages,
        )
        policy_terms = -np.minimum(plain, bounded)
        by_log_prob = np.where(plain <= bounded, -plain, 0)  # else the bound holds: constant

    policy, entropy, value = policy_terms.mean(), entropies.mean(), (errors**2).mean()
    total = policy - entropy_weight * entropy + settings.value * value

    by_logits = by_log_prob[:, None] * (taken - probs)
    by_logits += entropy_weight * probs * (finite + entropies[:, None])
    by_estimates = 2 * settings.value * errors[:, None]
    of_policy, from_policy = backward(
        parameters.policy, through_policy, by_logits / n, name, linear_end=True
    )
    of_value, from_value = backward(
        parameters.value, through_value, by_estimates / n, name, linear_end=True
    )
    of_trunk: list[Layer] = []
    if parameters.trunk:
        of_trunk, _ = backward(
            parameters.trunk, through_trunk, from_policy + from_value, name, linear_end=False
        )
    loss = Loss(float(total), float(policy), float(entropy), float(value))
    return loss, Parameters(of_policy, of_value, of_trunk)


# Steps.


def steps(parameters: Parameters, rollouts: Iterable[Rollout], **settings: object) -> list[Step]:
    """A2C: one step on each rollout in turn, from fresh moments."""
    found = Settings(**settings)  # pyright: ignore[reportArgumentType]
    return _several(
        parameters, ((rollout.count, _once(rollout, found)) for rollout in rollouts), found
    )


def ppo_steps(
    parameters: Parameters,
    rollout: Rollout,
    minibatches: Iterable[Int[np.ndarray, " batch"]],
    moments: Moments | None = None,
    **settings: object,
) -> list[Step]:
    """PPO: one step on each minibatch in turn, from these moments, or fresh ones.

    Advantages, targets and the old policy are those of the parameters at the start.

    Args:
        minibatches: places among the steps that count, those of a step's environments together:
            with no mask, step * envs + env.
    """
    found = Settings(**settings)  # pyright: ignore[reportArgumentType]
    whole = batched(parameters, rollout, found, old_policy=True)

    def part(places: Int[np.ndarray, " batch"]) -> Callable[[Parameters], Batches]:
        chosen = Batches(
            whole.inputs[places],
            whole.actions[places],
            None if whole.available is None else whole.available[places],
            whole.advantages[places],
            whole.targets[places],
            None if whole.old_log_probs is None else whole.old_log_probs[places],
        )
        if found.normalise and found.normalise_over == "minibatch":
            advantages = standardised(chosen.advantages, unbiased=found.unbiased)
            chosen = chosen._replace(advantages=advantages)
        return lambda _: chosen

    batches = ((rollout.count, part(places)) for places in minibatches)
    return _several(parameters, batches, found, moments)


def _once(rollout: Rollout, settings: Settings) -> Callable[[Parameters], Batches]:
    return lambda parameters: batched(parameters, rollout, settings)


def _several(
    parameters: Parameters,
    batches: Iterable[tuple[float, Callable[[Parameters], Batches]]],
    settings: Settings,
    moments: Moments | None = None,
) -> list[Step]:
    if settings.networks == "separate" and parameters.trunk:
        raise ValueError("separate networks have no trunk")
    moments = Moments.fresh(parameters.arrays()) if moments is None else moments
    found = []
    for count, batch_of in batches:
        weight = linear(
            settings.entropy,
            settings.entropy_end,
            settings.entropy_steps,
            count - settings.entropy_hold,
        )
        rate = linear(
            settings.learning_rate,
            settings.learning_rate_end,
            settings.learning_rate_steps,
            count,
        ) * decayed(settings.learning_rate_decay, settings.learning_rate_every, count)
        loss, gradients = loss_and_gradients(parameters, batch_of(parameters), settings, weight)
        small = gradients.arrays()
        split = 2 * len(parameters.policy) if settings.networks == "separate" else len(small)
        small = [
            array
            for network in (small[:split], small[split:])
            for array in clipped(network, settings.clip, settings.clip_epsilon)
        ]
        arrays, moments = apply(settings.optimizer, parameters.arrays(), small, moments, rate)
        after = parameters.replaced(arrays)
        found.append(Step(loss, gradients, parameters.replaced(small), after, moments))
        parameters = after
    return found
