"""The samplers of public code, written anew from their formulas, for comparison.

None of them needs a model of the world, and each is quick. They are here so that the better
estimators can be compared with what is in use; see `docs/explanation/estimators.md` for how far off
they are.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64
from numpy.typing import ArrayLike

from habilis.empowerment.arguments import at_least_one, positive, whole_number
from habilis.estimators.actions import ActionBox, action_size, check_size, drawn_actions
from habilis.estimators.actions import checked_actions as actions_of
from habilis.estimators.protocol import (
    Kind,
    SensorOfSimulator,
    Simulator,
    Target,
    checked_simulator,
    checked_states,
    is_stochastic,
)
from habilis.estimators.rollouts import Outcomes, outcomes_of
from habilis.estimators.sensors import reading

_BOX = 10  # actions of a box that stand for all

Readings = Float64[np.ndarray, "N 1 p"]


@dataclass(frozen=True)
class RandomSequences:
    """The logarithm of the number of cells that random sequences of actions reach.

    Du et al. (2020) count so with 1,000 sequences. In deterministic worlds this is a lower bound,
    far below the truth where sequences outnumber it; in stochastic ones noise is counted as choice.

    Attributes:
        sequences: how many are drawn.
        resolution: the size of the sensor's cells.

    Example:
        >>> from habilis import TabularMDP, empowerment
        >>> ring = TabularMDP.deterministic([[(s - 1) % 9, (s + 1) % 9] for s in range(9)])
        >>> empowerment(ring, 3, states=[0], method=RandomSequences())
        array([2.])
    """

    sequences: int = 1000
    resolution: float = 1.0

    def __post_init__(self) -> None:
        _check(self)

    def fit(
        self,
        simulator: Simulator,
        horizon: int,
        sensor: SensorOfSimulator = "state",
        *,
        seed: int = 0,
    ) -> "Sampler":
        """Prepares the counting; nothing is learned.

        Args:
            simulator: any.
            horizon: h, how many actions.
            sensor: see `habilis.estimators.sensors`.
            seed: of the draws.

        Returns:
            Counts on request.
        """
        kind: Kind = "approximation" if is_stochastic(simulator) else "lower bound"

        def bits(seen: Readings) -> float:
            return float(np.log2(len(np.unique(_cells(seen, self.resolution), axis=0))))

        actions = actions_of(checked_simulator(simulator).actions)
        drawn = _random(actions, self.sequences, horizon, seed)
        return _sampler(simulator, sensor, drawn, bits, seed, kind, "capacity")


@dataclass(frozen=True)
class VarianceProxy:
    """The logarithm of the variance of where random sequences of actions lead.

    Du et al. (2020) take it in the place of empowerment, from the set of outcomes: each that is
    different counts once. It depends on how outcomes are numbered and scaled.

    Attributes:
        sequences: how many are drawn.

    Example:
        >>> from habilis import TabularMDP, empowerment
        >>> ring = TabularMDP.deterministic([[(s - 1) % 9, (s + 1) % 9] for s in range(9)])
        >>> empowerment(ring, 1, states=[1, 0], method=VarianceProxy()).round(2)
        array([0.  , 3.61])
    """

    sequences: int = 1000

    def __post_init__(self) -> None:
        _check(self)

    def fit(
        self,
        simulator: Simulator,
        horizon: int,
        sensor: SensorOfSimulator = "state",
        *,
        seed: int = 0,
    ) -> "Sampler":
        """Prepares the sampling; nothing is learned.

        Args:
            simulator: any.
            horizon: h, how many actions.
            sensor: see `habilis.estimators.sensors`.
            seed: of the draws.

        Returns:
            max(0, log2(variance)) on request, the variances of the sensor's components summed.
        """

        def bits(seen: Readings) -> float:
            variance = np.unique(seen[:, 0], axis=0).var(axis=0).sum()
            return float(np.log2(max(float(variance), 1.0)))

        actions = actions_of(checked_simulator(simulator).actions)
        drawn = _random(actions, self.sequences, horizon, seed)
        return _sampler(simulator, sensor, drawn, bits, seed, "approximation", "capacity")


@dataclass(frozen=True)
class FirstAction:
    """The information of the first action and the outcome, both counted in a few samples.

    Each action is tried first, `samples` times, and followed by uniformly random ones; the
    information is that of the empirical distribution. Its target is effective empowerment under
    uniform actions, not the capacity; and as nearly every sample is new where outcomes are many, it
    then is the logarithm of the number of actions.

    Attributes:
        samples: of each action.
        resolution: the size of the sensor's cells.

    Example:
        >>> from habilis import TabularMDP, empowerment
        >>> ring = TabularMDP.deterministic([[(s - 1) % 9, (s + 1) % 9] for s in range(9)])
        >>> empowerment(ring, 1, states=[0], method=FirstAction())
        array([1.])
    """

    samples: int = 10
    resolution: float = 1.0

    def __post_init__(self) -> None:
        _check(self)

    def fit(
        self,
        simulator: Simulator,
        horizon: int,
        sensor: SensorOfSimulator = "state",
        *,
        seed: int = 0,
    ) -> "Sampler":
        """Prepares the sampling; nothing is learned.

        Args:
            simulator: any; of an `ActionBox`, 10 first actions are drawn.
            horizon: h, how many actions, 1 or more.
            sensor: see `habilis.estimators.sensors`.
            seed: of the draws.

        Returns:
            Values on request.
        """
        horizon = at_least_one("horizon", horizon)
        actions = actions_of(checked_simulator(simulator).actions)
        generator = np.random.default_rng(whole_number("seed", seed))
        is_box = isinstance(actions, ActionBox)
        first: Any = drawn_actions(actions, (_BOX,), generator) if is_box else actions
        later = drawn_actions(actions, (len(first), self.samples, horizon - 1), generator)
        leading = np.repeat(first[:, None, None], self.samples, axis=1)
        drawn = np.concatenate([leading, later], axis=2).reshape(-1, horizon, first.shape[1])

        def bits(seen: Readings) -> float:
            groups = seen.reshape(len(first), self.samples, -1)
            outcome = _cells(groups.reshape(-1, 1, groups.shape[2]), self.resolution)
            labels = np.unique(outcome, axis=0, return_inverse=True)[1].reshape(len(first), -1)
            counts = np.stack([np.bincount(one, minlength=labels.max() + 1) for one in labels])
            return _information(counts / counts.sum())

        return _sampler(simulator, sensor, drawn, bits, seed, "approximation", "effective")


@dataclass(frozen=True, eq=False)
class Sampler:
    """One of the samplers, of one simulator, horizon and sensor.

    Attributes:
        outcomes: what the sensor shows after sequences.
        sequences: float64[N, h, k].
        value: of float64[N, 1, p], in bits.
        seed: of the steps.
        kind: "lower bound" or "approximation".
        target: "capacity" or "effective".
    """

    outcomes: Outcomes
    sequences: Float64[np.ndarray, "N h k"]
    value: Callable[[Readings], float]
    seed: int
    kind: Kind
    target: Target

    def bits(self, states: ArrayLike) -> Float64[np.ndarray, "n"]:
        """The values of states.

        Args:
            states: float[n, d].

        Returns:
            float64[n].
        """
        given = checked_states(states)
        found = self.outcomes(given, self.sequences, self.seed, 1)
        return np.array([self.value(each) for each in found], np.float64)


def _sampler(
    simulator: Simulator,
    sensor: SensorOfSimulator,
    sequences: Float64[np.ndarray, "N h k"],
    value: Callable[[Readings], float],
    seed: int,
    kind: Kind,
    target: Target,
) -> Sampler:
    outcomes = outcomes_of(simulator, reading(simulator, sensor))
    return Sampler(outcomes, sequences, value, seed, kind, target)


def _random(actions: Any, most: int, horizon: int, seed: int) -> Float64[np.ndarray, "N h k"]:
    horizon = whole_number("horizon", horizon)
    generator = np.random.default_rng(whole_number("seed", seed))
    check_size(most, horizon, action_size(actions))
    return drawn_actions(actions, (most, horizon), generator)


def _cells(seen: Readings, resolution: float) -> Float64[np.ndarray, "N p"]:
    return np.rint(seen[:, 0] / resolution) + 0.0


def _information(joint: Float64[np.ndarray, "a o"]) -> float:
    """The mutual information of rows and columns, in bits."""
    apart = joint.sum(axis=1, keepdims=True) * joint.sum(axis=0)
    there = joint > 0
    return float((joint[there] * np.log2(joint[there] / apart[there])).sum())


def _check(settings: Any) -> None:
    for name in ("sequences", "samples"):
        if hasattr(settings, name):
            object.__setattr__(settings, name, at_least_one(name, getattr(settings, name)))
    if hasattr(settings, "resolution"):
        positive("resolution", settings.resolution)
