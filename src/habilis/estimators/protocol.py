"""What a simulator is, and what estimators make of one."""

from typing import Any, Literal, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float, Float64
from numpy.typing import ArrayLike

Kind = Literal["exact", "lower bound", "asymptotically exact", "approximation"]
"""How an estimate is related to its target: equal, never above but for sampling error, equal in the
limit of many samples, or neither."""

Target = Literal["capacity", "effective"]
"""What is estimated: the largest information over all distributions of actions, or the information
under one of them."""

SensorOfSimulator = Any
"""See `habilis.estimators.sensors`."""

Random = Any
"""What a step draws from: a JAX key, a NumPy generator, or `None` where nothing is drawn."""


@runtime_checkable
class Simulator(Protocol):
    """A world of vectors: any class with `actions` and `step`.

    A state is a vector of d numbers, an action one of k. Besides `actions` and `step`, a simulator
    may have these attributes:

    - `observe(states)`: float[n, o], its observations, which sensors refer to. By default the
      states.
    - `names`: a mapping from names to an index, a list of indices or a slice of the observation.
    - `is_stochastic`: whether a step draws random numbers; True by default. Where it is False, the
      key of a step is `None`.
    - `in_jax`: whether `step` and `observe` are functions of JAX arrays, which can be compiled and
      differentiated; False by default. They then receive a JAX key, and NumPy's `Generator`
      otherwise.
    - `noise`: q, how many independent standard normal numbers a step draws, and
      `transition(states, actions, noise)`: the same step with these numbers, float[n, q], instead
      of a key. `Gaussian` needs both of a stochastic simulator.
    - `is_linear`: whether a step is a linear function of state, action and noise, and an
      observation one of the state.
    - `is_finite`: whether observations are whole numbers that stand for something, such as the
      states of a table.
    - `random_states(count, generator)`: float[count, d], states to fit a model to.
    - `rollout(states, sequences)`: float[n, d], where sequences float[n, h, k] of actions lead, of
      a deterministic simulator that can compute this faster than by one `step` after another.

    Attributes:
        actions: float[m, k], the m actions that there are; or an `ActionBox`, all vectors between
            two.
    """

    @property
    def actions(self) -> Any:
        """See the class."""
        ...

    def step(
        self, states: Float[Any, "n d"], actions: Float[Any, "n k"], key: Random
    ) -> Float[Any, "n d"]:
        """One step of many states at once.

        Args:
            states: one a row.
            actions: one for each state.
            key: see the class.

        Returns:
            The next states.
        """
        ...


@runtime_checkable
class Fitted(Protocol):
    """An estimator that knows a simulator, a horizon and a sensor.

    Attributes:
        kind: "exact", "lower bound", "asymptotically exact" or "approximation".
        target: "capacity" (empowerment) or "effective" (effective empowerment).
    """

    @property
    def kind(self) -> Kind:
        """See the class."""
        ...

    @property
    def target(self) -> Target:
        """See the class."""
        ...

    def bits(self, states: ArrayLike) -> Float64[np.ndarray, "n"]:
        """The estimates for states, in bits; one state's do not depend on the others asked about.

        Args:
            states: float[n, d].

        Returns:
            float64[n].
        """
        ...


@runtime_checkable
class Estimator(Protocol):
    """A method for simulators: any class with `fit`."""

    def fit(
        self, simulator: Simulator, horizon: int, sensor: SensorOfSimulator = "state", *, seed: int
    ) -> Fitted:
        """Prepares for the estimates of many states: amortised methods learn here.

        Args:
            simulator: the world.
            horizon: h, how many actions.
            sensor: see `habilis.estimators.sensors`.
            seed: of all draws, from 0 up: the same seed gives the same numbers.

        Returns:
            Estimates on request.
        """
        ...


def is_estimator(method: Any) -> bool:
    """Whether a method is an estimator; those of tables (`Exact`, `Sampled`) are none."""
    return callable(getattr(method, "fit", None))


def checked_estimator(method: Any) -> Estimator:
    """`method` if it is an estimator, else a ValueError that names some."""
    if isinstance(method, type):
        raise ValueError(f"method is the class {method.__name__}; give an instance, with settings")
    if not is_estimator(method):
        raise ValueError(
            f"method is {method!r:.60}, no estimator; simulators need one, as hb.Counting(0.1), "
            "hb.MonteCarlo() or hb.Gaussian(power=1, noise=0.1)"
        )
    return method


def is_stochastic(simulator: Simulator) -> bool:
    """Whether a step draws random numbers."""
    return bool(getattr(simulator, "is_stochastic", True))


def in_jax(simulator: Simulator) -> bool:
    """Whether a step is a function of JAX arrays."""
    return bool(getattr(simulator, "in_jax", False))


def is_finite(simulator: Simulator) -> bool:
    """Whether observations are whole numbers that stand for something."""
    return bool(getattr(simulator, "is_finite", False))


def is_linear(simulator: Simulator, sensor: SensorOfSimulator) -> bool:
    """Whether what a sensor shows is a linear function of state, actions and noise."""
    return bool(getattr(simulator, "is_linear", False)) and not callable(sensor)


def checked_simulator(simulator: Any) -> Simulator:
    """`simulator` if it is one, else a ValueError that says what it lacks."""
    for name in ("actions", "step"):
        if not hasattr(simulator, name):
            raise ValueError(
                f"{type(simulator).__name__} is no simulator: it has no `{name}`; give one with "
                "`actions` and `step(states, actions, key)`, as habilis.Simulator describes"
            )
    return simulator


def check_length(states: Float[Any, "n d"], length: int) -> None:
    """Refuses states of another length, which NumPy might spread over all entries.

    Raises:
        ValueError: says what they have.
    """
    if states.shape[1] != length:
        raise ValueError(
            f"states have {states.shape[1]} numbers each, the simulator's {length}; give "
            f"float[n, {length}]"
        )


def checked_states(states: Any) -> Float64[np.ndarray, "n d"]:
    """`states` as float64[n, d], else a ValueError."""
    given = np.asarray(states)
    if given.ndim != 2 or given.dtype.kind not in "biuf":
        raise ValueError(
            f"states has shape {np.shape(states)} and type {given.dtype}; give float[n, d], one "
            "state a row, as [[0.0, 1.0]]"
        )
    checked = given.astype(np.float64)
    if not np.isfinite(checked).all():
        row = int(np.flatnonzero(~np.isfinite(checked).all(axis=1))[0])
        raise ValueError(f"states[{row}] is not finite; give numbers")
    return checked


def checked_starts(states: Any) -> Float64[np.ndarray, "n d"] | None:
    """The states that an estimator is to train on, if any are given."""
    if states is None:
        return None
    checked = checked_states(states)
    if not len(checked):
        raise ValueError("states is empty; give states to train on, or leave it out")
    return checked
