"""Effective empowerment by contrastive learning: InfoNCE over actions and later outcomes."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Float64
from numpy.typing import ArrayLike

from habilis.checks import is_number
from habilis.empowerment.arguments import at_least_one, positive, whole_number
from habilis.estimators.actions import ActionBox, checked_actions, drawn_actions
from habilis.estimators.learned.features import Features, outcome_features, state_features
from habilis.estimators.protocol import (
    Kind,
    SensorOfSimulator,
    Simulator,
    Target,
    checked_simulator,
    checked_starts,
    checked_states,
    in_jax,
)
from habilis.estimators.rollouts import compiled_scan, in_double, roll_out
from habilis.estimators.sensors import checked_reading, reading
from habilis.extras import import_from

if TYPE_CHECKING:
    from habilis.estimators.learned.contrastive_networks import Encoders

Bits = Float64[np.ndarray, "n"]
Sample = Callable[[np.ndarray, np.random.Generator], tuple[np.ndarray, np.ndarray]]
"""From states, the first actions as inputs of the networks, and what the sensor shows later."""

_NATS = math.log(2)
_OTHERS = 2048  # outcomes that stand for the rest of a batch
_REST = 1e-3  # of the distribution of lags that is left out


@dataclass(frozen=True)
class Contrastive:
    """The information of one action and a later outcome under uniform actions, by InfoNCE.

        I(A_1; O_K | s) = E[log2 p(O | s, A) / p(O) - log2 p(O | s) / p(O)]

    Both ratios are inner products of learned features, phi(s, a) psi(o) and phi(s) psi(o), trained
    to tell the outcome of a state (and action) from those of the others in a batch, as ESR (Myers
    et al. 2024) and EELMA (Song, Gore and Kleiman-Weiner 2025) do. The target is effective
    empowerment, not the capacity. Neither ratio can be larger than the size of the batch: where
    state and action tell more than log2(batch) bits about the outcome, the estimate saturates, and
    no training helps. It is a difference of two bounds, hence no bound.

    Attributes:
        discount: g; the outcome is that of K >= horizon steps, P(K = k) proportional to g^k. At 0,
            K is the horizon.
        rounds: of sampling and training, at most.
        updates: of the networks in each round.
        batch: samples of an update, and outcomes that one is compared with.
        width: of hidden layers.
        features: length of the features.
        learning_rate: of Adam.
        patience: rounds without larger bounds on new samples after which training stops.
        samples: rolled out for each state asked about.
        states: float[m, d], states to train on, drawn from uniformly; by default the simulator's
            `random_states`. Where the sensor changes in few states only, give those: random ones
            hardly ever show it.
        folder: where progress is kept, and found again by the same settings, seed and simulator.
        show_progress: whether to draw a progress bar on standard error.

    Raises:
        ValueError: a setting is out of its range.

    Example:
        >>> from habilis import TabularMDP, empowerment
        >>> ring = TabularMDP.deterministic([[(s - 1) % 5, (s + 1) % 5] for s in range(5)])
        >>> method = Contrastive(rounds=40, width=32)
        >>> empowerment(ring, 1, states=[0, 1], method=method).round(1)
        array([1., 1.])
    """

    discount: float = 0.0
    rounds: int = 100
    updates: int = 16
    batch: int = 256
    width: int = 64
    features: int = 32
    learning_rate: float = 1e-2
    patience: int = 15
    samples: int = 512
    states: Any = field(default=None, repr=False, compare=False)
    folder: str | Path | None = field(default=None, repr=False)
    show_progress: bool = field(default=False, repr=False)

    def __post_init__(self) -> None:
        names = ("rounds", "updates", "batch", "width", "features", "patience", "samples")
        for name in names:
            object.__setattr__(self, name, at_least_one(name, getattr(self, name)))
        object.__setattr__(self, "learning_rate", positive("learning_rate", self.learning_rate))
        object.__setattr__(self, "states", checked_starts(self.states))
        if not is_number(self.discount) or not 0 <= self.discount < 1:
            raise ValueError(f"discount is {self.discount!r}; give a number from 0 up to but not 1")
        if self.batch < 2:
            raise ValueError("batch is 1; give at least 2, to compare outcomes with others")

    def fit(
        self,
        simulator: Simulator,
        horizon: int,
        sensor: SensorOfSimulator = "state",
        *,
        seed: int = 0,
    ) -> "FittedContrastive":
        """Learns the features from `states`, or the simulator's `random_states`.

        Args:
            simulator: one with `random_states`, unless `states` are given.
            horizon: the least number of steps until the outcome, 1 or more.
            sensor: see `habilis.estimators.sensors`.
            seed: of the networks and all draws.

        Returns:
            Estimates on request.

        Raises:
            ValueError: an argument is none of its kind, or training diverges.
            MissingExtraError: JAX, Equinox or Optax are not installed.
        """
        jax = import_from("jax", "robots")
        networks = import_from("habilis.estimators.learned.contrastive_networks", "robots")
        layers = import_from("habilis.estimators.learned.networks", "robots")
        training = import_from("habilis.estimators.learned.training", "robots")
        horizon, seed = at_least_one("horizon", horizon), whole_number("seed", seed)
        seen = in_double(checked_simulator(simulator), reading(simulator, sensor))
        path = training.checkpoint_path(self.folder, self, simulator, seen, horizon, seed)
        sample = _sampler(simulator, horizon, self.discount, seen)
        count = self.batch * self.updates
        generator = np.random.default_rng([seed, 2**20])
        starts = training.random_starts(simulator, count, generator, self.states)
        actions, some = sample(starts, generator)
        of_state = state_features(simulator, starts)
        of_outcome = outcome_features(simulator, seen, sensor, of_state, starts, some, False)
        others = of_outcome.of((starts, some))[:_OTHERS]
        known: Any = checked_actions(simulator.actions)
        number = 0 if isinstance(known, ActionBox) else len(known)
        sizes = of_state.size, number or actions.shape[1], of_outcome.size
        first = networks.Encoders(sizes, self.width, self.features, jax.random.key(seed))
        improve = networks.improve_with(self.learning_rate, self.batch)

        def one_round(now: Any, number: int) -> tuple[Any, float]:
            generator = np.random.default_rng([seed, number])
            starts = training.random_starts(simulator, count, generator, self.states)
            actions, found = sample(starts, generator)
            shown = of_outcome.of((starts, found))
            now, bound = improve(now, of_state.of(starts), actions, shown)
            return now, float(bound) / _NATS

        memory = layers.optimiser(self.learning_rate).init(layers.arrays(first))
        rounds = self.rounds, self.patience, path, self.show_progress
        found = training.train((first, memory), one_round, *rounds)
        given = of_state, of_outcome, others, sample, self.samples, self.batch, seed
        return FittedContrastive(found.best[0], *given, found.bounds)


@dataclass(frozen=True, eq=False)
class FittedContrastive:
    """`Contrastive` of one simulator, horizon and sensor.

    Attributes:
        encoders: of pairs, states and outcomes.
        of_state, of_outcome: their inputs.
        others: outcomes from random states, as inputs, that an outcome is compared with.
        sample: rolls out.
        samples: of each state.
        batch: that each is compared with.
        seed: of the samples.
        bounds: float64[rounds], the sum of both InfoNCE bounds as it was trained, in bits.
        kind: "approximation".
        target: "effective".
    """

    encoders: "Encoders"
    of_state: Features
    of_outcome: Features
    others: Any
    sample: Sample
    samples: int
    batch: int
    seed: int
    bounds: Float64[np.ndarray, "rounds"]
    kind: Kind = "approximation"
    target: Target = "effective"

    def bits(self, states: ArrayLike) -> Bits:
        """The estimates for states.

        Args:
            states: float[n, d].

        Returns:
            float64[n], each the mean over its samples; one may be below 0.
        """
        networks = import_from("habilis.estimators.learned.contrastive_networks", "robots")
        found = []
        for state in checked_states(states):
            generator = np.random.default_rng([self.seed, 2**21])
            starts = np.repeat(state[None], self.samples, axis=0)
            actions, later = self.sample(starts, generator)
            shown = self.of_outcome.of((starts, later))
            given = self.of_state.of(starts), actions, shown, self.others, self.batch
            found.append(float(np.asarray(networks.gains(self.encoders, *given)).mean()) / _NATS)
        return np.array(found, np.float64)


def _sampler(simulator: Simulator, horizon: int, discount: float, seen: Any) -> Sample:
    """Draws uniform actions, and what the sensor shows after them.

    Raises:
        ValueError: actions are unbounded.
    """
    actions = checked_actions(simulator.actions)
    compiled = compiled_scan(simulator) if in_jax(simulator) else None
    longest = math.ceil(math.log(_REST) / math.log(discount)) if discount else 0

    def sample(states: np.ndarray, generator: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
        drawn = drawn_actions(actions, (len(states), horizon), generator)
        last = roll_out(simulator, states, drawn, int(generator.integers(2**31)), compiled)
        lags = np.minimum(generator.geometric(1 - discount, len(states)) - 1, longest)
        for step in range(longest):
            one = drawn_actions(actions, (len(states), 1), generator)
            then = roll_out(simulator, last, one, int(generator.integers(2**31)), compiled)
            last = np.where((lags > step)[:, None], then, last)
        first = drawn[:, 0]
        if isinstance(actions, ActionBox):
            middle, half = (actions.high + actions.low) / 2, (actions.high - actions.low) / 2
            inputs = ((first - middle) / half).astype(np.float32)
        else:
            same = (first[:, None] == actions).all(axis=2)
            inputs = same.argmax(axis=1)[:, None].astype(np.int32)
        return inputs, checked_reading(seen(last), len(last))

    return sample
