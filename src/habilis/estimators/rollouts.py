"""Where sequences of actions lead: the one place that steps simulators.

Everything here is in double precision. Simulators of JAX are compiled, one `scan` over the horizon;
those with a `rollout` of their own use that; others are stepped.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from jaxtyping import Float, Float64

from habilis.estimators.protocol import Random, Simulator, in_jax, is_stochastic
from habilis.estimators.sensors import Reading, checked_reading
from habilis.estimators.simulators.metered import unmetered
from habilis.extras import import_from

Outcomes = Callable[[np.ndarray, np.ndarray, int, int], np.ndarray]

_ROWS = 1 << 18  # of states in flight at a time


def scan(
    simulator: Simulator,
    states: Float[Any, "n d"],
    sequences: Float[Any, "n h k"],
    key: Random = None,
) -> Float[Any, "n d"]:
    """The states that sequences lead to, as a function of JAX arrays.

    Args:
        simulator: one of JAX.
        states: where each sequence begins.
        sequences: one for each state.
        key: of all steps; `None` where the simulator draws nothing.

    Returns:
        The last states.

    Raises:
        ValueError: a step gives states of another shape.
    """
    import jax
    import jax.numpy as jnp

    made = unmetered(simulator)
    keys = None if key is None else jax.random.split(key, sequences.shape[1])

    def one(states: Any, step: Any) -> tuple[Any, None]:
        actions, own = step
        found = made.step(states, actions, own)
        check_shape(found, states)
        return found, None

    if sequences.shape[1] == 0:
        return states
    return jax.lax.scan(one, states, (jnp.moveaxis(sequences, 1, 0), keys))[0]


def roll_out(
    simulator: Simulator,
    states: Float64[np.ndarray, "n d"],
    sequences: Float64[np.ndarray, "n h k"],
    seed: int = 0,
    compiled: Callable[..., Any] | None = None,
) -> Float64[np.ndarray, "n d"]:
    """The states that sequences lead to.

    Args:
        simulator: any.
        states: where each sequence begins.
        sequences: one for each state.
        seed: of the steps' draws.
        compiled: the function that `compiled_scan` made of the simulator, to use it again.

    Returns:
        The last states.

    Raises:
        ValueError: the simulator leads to numbers that are not finite, or to states of another
            shape.
    """
    if in_jax(simulator):
        last = (compiled or compiled_scan(simulator))(states, sequences, seed)
    elif hasattr(simulator, "rollout") and not is_stochastic(simulator):
        last = unmetered(simulator).rollout(states, sequences)  # pyright: ignore[reportAttributeAccessIssue]
    else:
        key = np.random.default_rng(seed) if is_stochastic(simulator) else None
        last = states
        for step in range(sequences.shape[1]):
            last = np.asarray(unmetered(simulator).step(last, sequences[:, step], key))
            check_shape(last, states)
    report_steps(simulator, sequences.shape[0] * sequences.shape[1])
    return _checked(last, states)


def roll_out_with(
    simulator: Simulator,
    states: Float64[np.ndarray, "n d"],
    sequences: Float64[np.ndarray, "n h k"],
    noise: Float64[np.ndarray, "n h q"],
) -> Float64[np.ndarray, "n d"]:
    """The states that sequences lead to with given noise.

    Args:
        simulator: one of NumPy with `noise` and `transition`.
        states: where each sequence begins.
        sequences: one for each state.
        noise: standard normal numbers, for each step.

    Returns:
        The last states.

    Raises:
        ValueError: as in `roll_out`.
    """
    last: Any = states
    for step in range(sequences.shape[1]):
        last = unmetered(simulator).transition(  # pyright: ignore[reportAttributeAccessIssue]
            last, sequences[:, step], noise[:, step]
        )
    report_steps(simulator, sequences.shape[0] * sequences.shape[1])
    return _checked(last, states)


def compiled_scan(simulator: Simulator) -> Callable[..., Any]:
    """`scan` of one simulator, compiled for each shape once, in double precision.

    Returns:
        A function of states, sequences and a seed, arrays of NumPy.
    """
    jax = import_from("jax", "robots")
    draws = is_stochastic(simulator)

    @jax.jit
    def run(states: Any, sequences: Any, key: Any) -> Any:
        return scan(simulator, states, sequences, key)

    def double(states: np.ndarray, sequences: np.ndarray, seed: int) -> np.ndarray:
        with jax.enable_x64(True):
            return np.asarray(run(states, sequences, jax.random.key(seed) if draws else None))

    return double


def outcomes_of(simulator: Simulator, shown: Reading) -> Outcomes:
    """What a sensor shows after sequences, from each of several states.

    Args:
        simulator: any.
        shown: of the sensor, see `reading`.

    Returns:
        A function of states float64[n, d], sequences float64[N, h, k], a seed and the number of
        samples of each, that returns float64[n, N, samples, p]. Draws are the same for each state:
        its outcomes do not depend on the others asked about, and differences between states
        are not those of their draws.
    """
    compiled = compiled_scan(simulator) if in_jax(simulator) else None
    seen = in_double(simulator, shown)

    def outcomes(states: np.ndarray, sequences: np.ndarray, seed: int, samples: int) -> np.ndarray:
        repeated = np.repeat(sequences, samples, axis=0)
        at_once = 1 if is_stochastic(simulator) else max(1, _ROWS // max(len(repeated), 1))
        found = []
        for first in range(0, len(states), at_once):
            some = states[first : first + at_once]
            starts = np.repeat(some, len(repeated), axis=0)
            actions = np.tile(repeated, (len(some), 1, 1))
            last = roll_out(simulator, starts, actions, seed, compiled)
            values = checked_reading(seen(last), len(last))
            found.append(values.reshape(len(some), len(sequences), samples, -1))
        if not found:
            return np.empty((0, len(sequences), samples, 1))
        return np.concatenate(found)

    return outcomes


def power_of_two(rows: int) -> int:
    """The least power of 2 that is no less: with few numbers of rows, little is compiled."""
    return 1 << (rows - 1).bit_length()


def padded(rows: np.ndarray, size: int) -> np.ndarray:
    """The rows, the last repeated so that there are so many."""
    if len(rows) == size:
        return rows
    return np.concatenate([rows, np.repeat(rows[-1:], size - len(rows), axis=0)])


def in_double(simulator: Simulator, function: Reading) -> Reading:
    """A sensor of a simulator of JAX in double precision; one of any other as it is."""
    if not in_jax(simulator):
        return function
    jax = import_from("jax", "robots")
    compiled = jax.jit(function)

    def double(states: np.ndarray) -> np.ndarray:
        with jax.enable_x64(True):
            return np.asarray(compiled(states))

    return double


def _checked(last: Any, states: Float64[np.ndarray, "n d"]) -> Float64[np.ndarray, "n d"]:
    check_shape(last, states)
    found = np.asarray(last, np.float64)
    good = np.isfinite(found).all(axis=1)
    if not good.all():
        row = states[int(np.flatnonzero(~good)[0])]
        start = np.array2string(row[:6], precision=4, threshold=6, separator=", ")
        raise ValueError(
            f"the simulator leads from {start} to numbers that are not finite; give a shorter "
            "horizon, a smaller time step or other states"
        )
    return found


def check_shape(found: Any, states: Float[Any, "n d"]) -> None:
    """Refuses next states of another shape than the states."""
    if np.shape(found) != np.shape(states):
        raise ValueError(
            f"step gives states of shape {np.shape(found)} for {np.shape(states)}; let it give one "
            "next state of the same length for each"
        )


def report_steps(simulator: Simulator, steps: int) -> None:
    """Tells a `Metered` simulator how many steps were made."""
    report = getattr(simulator, "report_steps", None)
    if report is not None:
        report(steps)
