"""The variational bound, learned: a source of action sequences, and a decoder that guesses them."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Float64
from numpy.typing import ArrayLike

from habilis.empowerment.arguments import at_least_one, positive, whole_number
from habilis.estimators.actions import checked_actions
from habilis.estimators.learned.coding import Coding, coding_of
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
    from habilis.estimators.learned.variational_networks import Networks

Bits = Float64[np.ndarray, "n"]

_NATS = math.log(2)


@dataclass(frozen=True)
class Variational:
    """The variational lower bound, with a source and a decoder that are learned for all states.

        E_h(s) >= E[log2 q(A^h | s, O) - log2 w(A^h | s)]

    with sequences A^h drawn from the source w and O what the sensor shows of where they lead. Both
    are networks, trained to raise the bound (Mohamed and Rezende 2015; Karl et al. 2017): the
    decoder q by maximum likelihood, the source by the score function, with a third network V(s) as
    its baseline. Of up to 1,024 sequences each is a symbol; of more, w and q give each action
    probabilities that depend on those before it. Sequences of an `ActionBox` are Gaussian
    vectors, which bounded ones are mapped from.

    `bits` rolls out sequences drawn at the states asked about, so that it is a lower bound but for
    sampling error. `predicted_bits` is V(s), one pass of a network: quick, and no bound.

    Attributes:
        rounds: of sampling and training, at most.
        updates: of the networks in each round.
        batch: sequences of an update.
        width: of hidden layers.
        learning_rate: of Adam.
        patience: rounds without a larger bound after which training stops. The bound is that of a
            round's sequences before they are trained on; the networks with the largest are used.
        samples: sequences rolled out for each state asked about.
        power: the bound on E ||(a_1 ... a_h)||^2 of unbounded actions.
        states: float[m, d], states to train on, drawn from uniformly; by default the simulator's
            `random_states`. Where the sensor changes in few states only, give those: random ones
            hardly ever show it.
        folder: where progress is kept, and found again by the same settings, seed and simulator.
        show_progress: whether to draw a progress bar on standard error.

    Raises:
        ValueError: a setting is out of its range.

    Example:
        >>> from habilis import TabularMDP, empowerment
        >>> noisy = TabularMDP.deterministic([[0, 1], [1, 0]]).slippery(0.2)
        >>> method = Variational(rounds=30, width=16, samples=4000)
        >>> bound, exact = empowerment(noisy, 1, method=method), empowerment(noisy, 1)
        >>> bool((abs(bound - exact) < 0.1).all())
        True
    """

    rounds: int = 100
    updates: int = 32
    batch: int = 128
    width: int = 64
    learning_rate: float = 5e-3
    patience: int = 15
    samples: int = 1000
    power: float | None = None
    states: Any = field(default=None, repr=False, compare=False)
    folder: str | Path | None = field(default=None, repr=False)
    show_progress: bool = field(default=False, repr=False)

    def __post_init__(self) -> None:
        for name in ("rounds", "updates", "batch", "width", "patience", "samples"):
            object.__setattr__(self, name, at_least_one(name, getattr(self, name)))
        object.__setattr__(self, "learning_rate", positive("learning_rate", self.learning_rate))
        object.__setattr__(self, "states", checked_starts(self.states))
        if self.power is not None:
            object.__setattr__(self, "power", positive("power", self.power))

    def fit(
        self,
        simulator: Simulator,
        horizon: int,
        sensor: SensorOfSimulator = "state",
        *,
        seed: int = 0,
    ) -> "FittedVariational":
        """Learns source, decoder and baseline from `states`, or the simulator's `random_states`.

        Args:
            simulator: one with `random_states`, unless `states` are given.
            horizon: h, how many actions, 1 or more.
            sensor: see `habilis.estimators.sensors`.
            seed: of the networks and all draws.

        Returns:
            Bounds on request.

        Raises:
            ValueError: an argument is none of its kind, or training diverges.
            MissingExtraError: JAX, Equinox or Optax are not installed.
        """
        jax = import_from("jax", "robots")
        networks = import_from("habilis.estimators.learned.variational_networks", "robots")
        layers = import_from("habilis.estimators.learned.networks", "robots")
        training = import_from("habilis.estimators.learned.training", "robots")
        horizon, seed = at_least_one("horizon", horizon), whole_number("seed", seed)
        actions = checked_actions(checked_simulator(simulator).actions)
        coding = coding_of(actions, horizon, self.power)
        seen = in_double(simulator, reading(simulator, sensor))
        path = training.checkpoint_path(self.folder, self, simulator, seen, horizon, seed)
        compiled = compiled_scan(simulator) if in_jax(simulator) else None

        def outcomes(states: np.ndarray, coded: np.ndarray, draws: int) -> np.ndarray:
            last = roll_out(simulator, states, coding.sequences(coded), draws, compiled)
            return checked_reading(seen(last), len(last))

        def draws_of(*round: int) -> tuple[np.random.Generator, Any, int]:
            generator = np.random.default_rng([seed, *round])
            key = jax.random.fold_in(jax.random.key(seed), round[0])
            return generator, key, int(generator.integers(2**31))

        count = self.batch * self.updates
        generator, key, draws = draws_of(2**20)
        starts = training.random_starts(simulator, count, generator, self.states)
        of_state = state_features(simulator, starts)
        begun = networks.first_codes(coding, count, self.power, key)
        some = outcomes(starts, np.asarray(begun), draws)
        of_outcome = outcome_features(simulator, seen, sensor, of_state, starts, some)
        sizes = of_state.size, of_outcome.size
        first = networks.begin(sizes, coding, self.width, self.power, key)
        rate = self.learning_rate
        improve = networks.improve_with(rate, self.batch)

        def one_round(now: Any, number: int) -> tuple[Any, float]:
            generator, key, draws = draws_of(number)
            starts = training.random_starts(simulator, count, generator, self.states)
            states = of_state.of(starts)
            coded = np.asarray(networks.draw(now[0], states, key))
            shown = of_outcome.of((starts, outcomes(starts, coded, draws)))
            now, bound = improve(now, states, shown, coded)
            return now, float(bound) / _NATS

        state = first, layers.optimiser(rate).init(layers.arrays(first))
        rounds = self.rounds, self.patience, path, self.show_progress
        found = training.train(state, one_round, *rounds)
        some = of_state, of_outcome, outcomes, self.samples, seed
        return FittedVariational(found.best[0], coding, *some, found.bounds)


@dataclass(frozen=True, eq=False)
class FittedVariational:
    """`Variational` of one simulator, horizon and sensor.

    Attributes:
        networks: source, decoder and baseline.
        coding: of sequences.
        of_state, of_outcome: the inputs of the networks.
        outcomes: what the sensor shows after coded sequences.
        samples: of each state.
        seed: of the sequences.
        bounds: float64[rounds], the bound as it was trained, in the mean over random states.
        kind: "lower bound": the expectation of `bits` is never above the truth.
        target: "capacity".
    """

    networks: "Networks"
    coding: Coding
    of_state: Features
    of_outcome: Features
    outcomes: Callable[[np.ndarray, np.ndarray, int], np.ndarray]
    samples: int
    seed: int
    bounds: Float64[np.ndarray, "rounds"]
    kind: Kind = "lower bound"
    target: Target = "capacity"

    def bits(self, states: ArrayLike) -> Bits:
        """The bounds at states, each the mean over its sampled sequences.

        Args:
            states: float[n, d].

        Returns:
            float64[n].
        """
        return self.with_errors(states)[0]

    def with_errors(self, states: ArrayLike) -> tuple[Bits, Bits]:
        """The bounds at states, with the standard errors of their sampling.

        Args:
            states: float[n, d].

        Returns:
            float64[n] and float64[n], in bits.
        """
        jax = import_from("jax", "robots")
        networks = import_from("habilis.estimators.learned.variational_networks", "robots")
        key = jax.random.fold_in(jax.random.key(self.seed), 2**21)
        bits, errors = [], []
        for state in checked_states(states):
            starts = np.repeat(state[None], self.samples, axis=0)
            given = self.of_state.of(starts)
            coded = np.asarray(networks.draw(self.networks, given, key))
            shown = self.of_outcome.of((starts, self.outcomes(starts, coded, self.seed)))
            gained = np.asarray(networks.gains(self.networks, given, shown, coded)) / _NATS
            bits.append(gained.mean(dtype=np.float64))
            errors.append(gained.std(dtype=np.float64) / np.sqrt(len(gained)))
        return np.array(bits, np.float64), np.array(errors, np.float64)

    def predicted_bits(self, states: ArrayLike) -> Bits:
        """What the baseline says of states, without a step of the simulator.

        Args:
            states: float[n, d].

        Returns:
            float64[n].
        """
        networks = import_from("habilis.estimators.learned.variational_networks", "robots")
        given = self.of_state.of(checked_states(states))
        return np.asarray(networks.predicted(self.networks, given), np.float64) / _NATS
