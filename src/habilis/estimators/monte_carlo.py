"""The capacity of the channel from finitely many sequences, its outcomes estimated from samples."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np
from jaxtyping import Float64
from numpy.typing import ArrayLike

from habilis.channels.capacity import certified, checked_tolerance, warn_of_gap
from habilis.empowerment.arguments import at_least_one, whole_number
from habilis.estimators.actions import Sequences, check_size, checked_actions, chosen_sequences
from habilis.estimators.noise import colored, covariance_of, log_volume, whitened
from habilis.estimators.protocol import (
    Kind,
    SensorOfSimulator,
    Simulator,
    Target,
    checked_simulator,
    checked_states,
    is_finite,
    is_linear,
    is_stochastic,
)
from habilis.estimators.rollouts import Outcomes, outcomes_of
from habilis.estimators.sensors import reading

Density = Literal["auto", "labels", "gaussian", "kernel"]

Samples = Float64[np.ndarray, "N M p"]


@dataclass(frozen=True)
class MonteCarlo:
    """The capacity of the channel from N sequences to outcomes that are sampled.

    From each state, M outcomes of each sequence i are sampled, and a density p_i is fitted to them.
    Points x_1, x_2, ... drawn from all the densities, M from each, are the outputs of a channel

        P(j | i) proportional to p_i(x_j) / sum over k of p_k(x_j)

    whose capacity is found to within `tolerance`. As M grows it tends to the capacity from these
    sequences to the outcomes of the densities (Jung, Polani and Stone 2011, who sum the same
    integrals by Blahut and Arimoto's iteration). It cannot exceed log2 N, and few samples make it
    too large: densities that are equal look different.

    Attributes:
        sequences: N, from 1 up: all there are, if these are no more; else drawn uniformly.
        samples: M, from 1 up, of each sequence; of a deterministic simulator one is made.
        outcomes: the density. "labels": outcomes are whole numbers, and their frequencies are
            counted; "gaussian": mean and covariance of the samples, of which there must be enough;
            "kernel": a Gaussian kernel on each sample, with Scott's bandwidth; "auto": labels of
            tables, else Gaussian.
        noise: of the sensor, added to Gaussians and kernels: a standard deviation, one for each of
            its p components, or a covariance float[p, p].
        tolerance: the gap of the capacity at which to stop, in bits.

    Raises:
        ValueError: a setting is out of its range.

    Example:
        >>> from habilis import TabularMDP, empowerment
        >>> noisy = TabularMDP.deterministic([[0, 1], [1, 0]]).slippery(0.2)
        >>> method = MonteCarlo(sequences=4, samples=10_000)
        >>> empowerment(noisy, 2, method=method).round(1), empowerment(noisy, 2).round(1)
        (array([0.3, 0.3]), array([0.3, 0.3]))
    """

    sequences: int = 100
    samples: int = 100
    outcomes: Density = "auto"
    noise: Any = 0.0
    tolerance: float = 1e-4

    def __post_init__(self) -> None:
        for name in ("sequences", "samples"):
            object.__setattr__(self, name, at_least_one(name, getattr(self, name)))
        if self.outcomes not in get_args(Density):
            raise ValueError(
                f"outcomes {self.outcomes!r} is unknown; use one of {', '.join(get_args(Density))}"
            )
        covariance_of(self.noise)
        object.__setattr__(self, "tolerance", checked_tolerance(self.tolerance))

    def fit(
        self,
        simulator: Simulator,
        horizon: int,
        sensor: SensorOfSimulator = "state",
        *,
        seed: int = 0,
    ) -> "FittedMonteCarlo":
        """Chooses the sequences, the same for all states.

        Args:
            simulator: any.
            horizon: h, how many actions.
            sensor: see `habilis.estimators.sensors`.
            seed: of sequences, outcomes and points.

        Returns:
            Capacities on request. Their kind is "approximation" where Gaussians are fitted to
            outcomes that may be something else; "asymptotically exact" otherwise, as sequences and
            samples grow.

        Raises:
            ValueError: an argument is none of its kind.
        """
        horizon, seed = whole_number("horizon", horizon), whole_number("seed", seed)
        actions = checked_actions(checked_simulator(simulator).actions)
        generator = np.random.default_rng(seed)
        sequences, _ = chosen_sequences(actions, horizon, self.sequences, generator)
        samples = self.samples if is_stochastic(simulator) else 1
        check_size(len(sequences) * samples, horizon, sequences.shape[2])
        density = self.outcomes
        if density == "auto":
            density = "labels" if is_finite(simulator) else "gaussian"
        right = density != "gaussian" or is_linear(simulator, sensor) or samples == 1
        kind: Kind = "asymptotically exact" if right else "approximation"
        outcomes = outcomes_of(simulator, reading(simulator, sensor))
        return FittedMonteCarlo(self, outcomes, sequences, density, samples, seed, kind)


@dataclass(frozen=True, eq=False)
class FittedMonteCarlo:
    """`MonteCarlo` of one simulator, horizon and sensor.

    Attributes:
        method: the settings.
        outcomes: of states and sequences.
        sequences: float64[N, h, k].
        density: "labels", "gaussian" or "kernel".
        samples: how many outcomes are sampled of each sequence.
        seed: of outcomes and points.
        kind: "asymptotically exact" or "approximation".
        target: "capacity".
    """

    method: MonteCarlo
    outcomes: Outcomes
    sequences: Sequences
    density: Density
    samples: int
    seed: int
    kind: Kind
    target: Target = "capacity"

    def bits(self, states: ArrayLike) -> Float64[np.ndarray, "n"]:
        """The capacities of the sampled channels.

        Args:
            states: float[n, d].

        Returns:
            float64[n].

        Raises:
            ValueError: outcomes are not finite; their noise is singular; or they are said to be
                labels, and are no whole numbers.

        Warns:
            ConvergenceWarning: a gap is above the tolerance.
        """
        from scipy.sparse import csr_array

        found = []
        for state in checked_states(states):
            outcomes = self.outcomes(state[None], self.sequences, self.seed, self.samples)[0]
            capacity = certified(csr_array(self._channel(outcomes)), self.method.tolerance)
            if capacity.gap > self.method.tolerance:
                warn_of_gap(capacity.gap, self.method.tolerance)
            found.append(capacity.bits)
        return np.array(found, np.float64)

    def _channel(self, outcomes: Samples) -> Float64[np.ndarray, "N m"]:
        if len(outcomes) == 1:
            return np.ones((1, 1))
        if self.density == "labels":
            return frequencies(outcomes)
        noise = covariance_of(self.method.noise, outcomes.shape[2])
        generator = np.random.default_rng([self.seed, 1])
        shape = len(outcomes), self.method.samples, outcomes.shape[2]
        white = generator.standard_normal(shape)
        if self.density == "gaussian":
            return channel_of_gaussians(outcomes, noise, white)
        return channel_of_kernels(outcomes, noise, white)


def frequencies(outcomes: Samples) -> Float64[np.ndarray, "N m"]:
    """How often each outcome was sampled, of outcomes that are labels.

    Raises:
        ValueError: they are no whole numbers.
    """
    if not np.array_equal(outcomes, np.rint(outcomes)):
        raise ValueError(
            "outcomes are said to be labels, but the sensor shows numbers that are not whole; use "
            "outcomes='gaussian' or 'kernel', or a sensor of labels"
        )
    count, samples, size = outcomes.shape
    _, labels = np.unique(outcomes.reshape(-1, size), axis=0, return_inverse=True)
    row = np.repeat(np.arange(count), samples)
    table = np.zeros((count, int(labels.max()) + 1))
    np.add.at(table, (row, labels.reshape(-1)), 1 / samples)
    return table / table.sum(axis=1, keepdims=True)


def channel_of_gaussians(
    outcomes: Samples, noise: Float64[np.ndarray, "p p"], white: Float64[np.ndarray, "N K p"]
) -> Float64[np.ndarray, "N m"]:
    """The channel to points drawn from a Gaussian fitted to the outcomes of each sequence.

    Args:
        outcomes: of each sequence.
        noise: the covariance of what the sensor adds.
        white: standard normal, which points are made of.

    Raises:
        ValueError: a covariance is singular.
    """
    means = outcomes.mean(axis=1)
    apart = outcomes - means[:, None]
    covariances = noise + apart.swapaxes(1, 2) @ apart / max(outcomes.shape[1] - 1, 1)
    points = _points(means, covariances, white)

    def log_density(index: int) -> np.ndarray:
        distance = whitened(covariances[index], (points - means[index]).T)
        return -(distance**2).sum(axis=0) / 2 - log_volume(covariances[index])

    return _channel_to(points, len(outcomes), log_density)


def channel_of_kernels(
    outcomes: Samples, noise: Float64[np.ndarray, "p p"], white: Float64[np.ndarray, "N K p"]
) -> Float64[np.ndarray, "N m"]:
    """The same of a mixture of Gaussian kernels on the outcomes of each sequence.

    Args:
        outcomes, noise, white: as in `channel_of_gaussians`.

    Raises:
        ValueError: a covariance is singular.
    """
    count, samples, size = outcomes.shape
    apart = outcomes - outcomes.mean(axis=1, keepdims=True)
    spread = apart.swapaxes(1, 2) @ apart / max(samples - 1, 1)
    kernels = noise + samples ** (-2 / (size + 4)) * spread  # Scott's rule
    each = np.arange(white.shape[1]) % samples
    points = _points(outcomes[:, each], kernels, white)

    def log_density(index: int) -> np.ndarray:
        at = whitened(kernels[index], points.T).T
        centres = whitened(kernels[index], outcomes[index].T).T
        squares = (at**2).sum(axis=1)[:, None] + (centres**2).sum(axis=1) - 2 * at @ centres.T
        return _log_mean_exp(-np.maximum(squares, 0) / 2) - log_volume(kernels[index])

    return _channel_to(points, count, log_density)


def _points(
    centres: Float64[np.ndarray, "N *K p"],
    covariances: Float64[np.ndarray, "N p p"],
    white: Float64[np.ndarray, "N M p"],
) -> Float64[np.ndarray, "m p"]:
    """Points about centres, one or one for each."""
    moved = colored(covariances, white.swapaxes(1, 2)).swapaxes(1, 2)
    about = centres[:, None] if centres.ndim == 2 else centres
    return (about + moved).reshape(-1, white.shape[2])


def _channel_to(
    points: Float64[np.ndarray, "m p"], count: int, log_density: Callable[[int], np.ndarray]
) -> Float64[np.ndarray, "N m"]:
    """The channel from densities to points that were drawn from all of them alike."""
    logs = np.stack([log_density(index) for index in range(count)])
    shares = np.exp(logs - logs.max(axis=0))
    shares /= shares.sum(axis=0)
    assert shares.shape == (count, len(points))
    return shares / shares.sum(axis=1, keepdims=True)


def _log_mean_exp(values: Float64[np.ndarray, "m M"]) -> Float64[np.ndarray, "m"]:
    largest = values.max(axis=1)
    return largest + np.log(np.exp(values - largest[:, None]).mean(axis=1))
