"""A controller without any reward: go where estimated empowerment is largest."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64, Int64
from numpy.typing import ArrayLike

from habilis.empowerment.arguments import at_least_one, whole_number
from habilis.estimators.actions import ActionBox, checked_actions
from habilis.estimators.protocol import (
    Fitted,
    Simulator,
    checked_simulator,
    checked_states,
    in_jax,
    is_stochastic,
)
from habilis.estimators.rollouts import compiled_scan, roll_out

_LEVELS = 5  # actions tried of each component of a box
_MOST = 10_000  # actions tried in all


@dataclass(frozen=True, eq=False)
class Followed:
    """Where a controller went.

    Attributes:
        states: float64[steps + 1, n, d], of each start, which is the first.
        actions: float64[steps, n, k].
        bits: float64[steps, n], the estimate of the state that was chosen; with noise the mean over
            the drawn next states.
    """

    states: Float64[np.ndarray, "steps_and_start n d"]
    actions: Float64[np.ndarray, "steps n k"]
    bits: Float64[np.ndarray, "steps n"]


def follow(
    fitted: Fitted,
    simulator: Simulator,
    states: ArrayLike,
    steps: int,
    *,
    actions: Any = None,
    samples: int = 1,
    seed: int = 0,
) -> Followed:
    """The trajectories of a controller that looks one step ahead.

    In each state it tries every action in the simulator, and takes the one after which the estimate
    is largest; the first of equal ones. There is no reward, and nothing is learned.

    Args:
        fitted: an estimator of this simulator, or anything else with `bits(states)`.
        simulator: the world, in which it both looks ahead and acts.
        states: float[n, d], the starts; one state as float[d].
        steps: how many, 0 or more.
        actions: float[m, k], to choose from; by default the simulator's own, and of a box five
            values of each component, the ends among them.
        samples: how many next states are drawn for each action, where the simulator is stochastic.
        seed: of these draws.

    Returns:
        States, actions and estimates on the way.

    Raises:
        ValueError: an argument is none of its kind, or the box has an infinite side.

    Example:
        >>> from habilis.estimators import Gaussian
        >>> from habilis.estimators.simulators import pendulum
        >>> world = pendulum()
        >>> fitted = Gaussian(power=1, noise=0.1).fit(world, 5)
        >>> went = follow(fitted, world, [np.pi, 0.1], steps=40)  # hanging at first
        >>> bool(np.cos(went.states[-1, 0, 0]) > 0.9)  # upright
        True
    """
    checked_simulator(simulator)
    starts = checked_states(np.atleast_2d(np.asarray(states)))  # one vector is one start
    steps, seed = whole_number("steps", steps), whole_number("seed", seed)
    tried = _choices(simulator.actions if actions is None else actions)
    draws = at_least_one("samples", samples) if is_stochastic(simulator) else 1
    compiled = compiled_scan(simulator) if in_jax(simulator) else None
    seeds = np.random.default_rng(seed).integers(2**31, size=(steps, 2))
    now, taken, values = [starts], [], []
    for step in range(steps):
        ahead, real = (int(one) for one in seeds[step])
        chosen, bits = _best(fitted, simulator, now[-1], tried, draws, ahead, compiled)
        action = tried[chosen]
        now.append(roll_out(simulator, now[-1], action[:, None], real, compiled))
        taken.append(action)
        values.append(bits)
    count, size = len(starts), tried.shape[1]
    return Followed(
        np.stack(now),
        np.array(taken).reshape(steps, count, size),
        np.array(values).reshape(steps, count),
    )


def _best(
    fitted: Fitted,
    simulator: Simulator,
    states: Float64[np.ndarray, "n d"],
    tried: Float64[np.ndarray, "m k"],
    draws: int,
    seed: int,
    compiled: Any,
) -> tuple[Int64[np.ndarray, "n"], Float64[np.ndarray, "n"]]:
    """The best action in each state, and the estimate after it."""
    count, many = len(states), len(tried)
    starts = np.repeat(states, many * draws, axis=0)
    sequences = np.tile(np.repeat(tried, draws, axis=0), (count, 1))[:, None]
    reached = roll_out(simulator, starts, sequences, seed, compiled)
    bits = np.asarray(fitted.bits(reached), np.float64).reshape(count, many, draws).mean(axis=2)
    chosen = bits.argmax(axis=1)
    return chosen, bits[np.arange(count), chosen]


def _choices(given: Any) -> Float64[np.ndarray, "m k"]:
    """The actions to try."""
    actions = checked_actions(given)
    if not isinstance(actions, ActionBox):
        return actions
    if not actions.is_bounded:
        raise ValueError("the action box is unbounded; give follow(..., actions=) to choose from")
    if _LEVELS**actions.size > _MOST:
        raise ValueError(
            f"an action has {actions.size} components, too many to try five values of each; give "
            "follow(..., actions=) to choose from"
        )
    ends = zip(actions.low, actions.high, strict=True)
    levels = [np.linspace(low, high, _LEVELS) for low, high in ends]
    return np.stack(np.meshgrid(*levels, indexing="ij"), axis=-1).reshape(-1, actions.size)
