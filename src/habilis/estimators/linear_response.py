"""How a sensor responds to small changes of the next actions and of the noise."""

from collections.abc import Callable
from typing import Any

import numpy as np
from jaxtyping import Float64

from habilis.estimators.protocol import Simulator, in_jax
from habilis.estimators.rollouts import (
    check_shape,
    padded,
    power_of_two,
    report_steps,
    roll_out,
    roll_out_with,
)
from habilis.estimators.sensors import Reading, checked_reading
from habilis.estimators.simulators.metered import unmetered
from habilis.extras import import_from

Responses = tuple[np.ndarray, np.ndarray]
"""float64[n, p, h k] of actions, float64[n, p, h q] of noise."""

Response = Callable[[np.ndarray], Responses]
"""From states float64[n, d]."""


def linear_response(
    simulator: Simulator,
    shown: Reading,
    nominal: Float64[np.ndarray, "h k"],
    noise: int,
    difference: float,
) -> Response:
    """The Jacobians of a sensor after h steps.

    Args:
        simulator: the world.
        shown: the sensor, see `reading`.
        nominal: the actions about which it is linearised, without noise.
        noise: q, how many normal numbers a step draws.
        difference: of central finite differences, where the simulator is not one of JAX.

    Returns:
        A function of states. In JAX derivatives are exact, elsewhere their error is of second order
        in the difference.
    """
    if in_jax(simulator):
        return _by_jax(simulator, shown, nominal, noise)
    return _by_differences(simulator, shown, nominal, noise, difference)


def _by_jax(
    simulator: Simulator, shown: Reading, nominal: Float64[np.ndarray, "h k"], noise: int
) -> Response:
    jax = import_from("jax", "robots")
    jnp = jax.numpy
    horizon = len(nominal)
    inputs = nominal.size + horizon * noise
    made = unmetered(simulator)

    def last(actions: Any, drawn: Any, state: Any) -> Any:
        def once(state: Any, step: Any) -> tuple[Any, None]:
            action, own = step
            moves: Any = made.transition if noise else made.step  # pyright: ignore[reportAttributeAccessIssue]
            found = moves(state, action, own if noise else None)
            check_shape(found, state)
            return found, None

        steps = actions[:, None], drawn[:, None]
        return shown(jax.lax.scan(once, state[None], steps)[0])[0]

    def jacobians(state: Any) -> Any:
        at = jnp.asarray(nominal), jnp.zeros((horizon, noise))
        outputs = jax.eval_shape(last, *at, state).shape[0]
        differentiated = jax.jacrev if outputs < inputs else jax.jacfwd
        return differentiated(last, argnums=(0, 1))(*at, state)

    compiled = jax.jit(jax.vmap(jacobians))

    def response(states: np.ndarray) -> Responses:
        report_steps(simulator, len(states) * horizon)
        with jax.enable_x64(True):
            found = compiled(jnp.asarray(padded(states, power_of_two(len(states)))))
            by_action, by_noise = (np.asarray(one)[: len(states)] for one in found)
        return _flat(by_action), _flat(by_noise)

    return response


def _flat(jacobian: Float64[np.ndarray, "n p h k"]) -> Float64[np.ndarray, "n p hk"]:
    return jacobian.reshape(*jacobian.shape[:2], -1)


def _by_differences(
    simulator: Simulator,
    shown: Reading,
    nominal: Float64[np.ndarray, "h k"],
    noise: int,
    difference: float,
) -> Response:
    horizon = len(nominal)
    inputs = nominal.size + horizon * noise
    changes = difference * np.concatenate([np.eye(inputs), -np.eye(inputs)])
    actions = nominal + changes[:, : nominal.size].reshape(len(changes), *nominal.shape)
    drawn = changes[:, nominal.size :].reshape(len(changes), horizon, noise)

    def of_state(state: np.ndarray) -> np.ndarray:
        starts = np.repeat(state[None], len(changes), axis=0)
        if noise:
            last = roll_out_with(simulator, starts, actions, drawn)
        else:
            last = roll_out(simulator, starts, actions)
        up, down = np.split(checked_reading(shown(last), len(last)), 2)
        return (up - down).T / (2 * difference)

    def response(states: np.ndarray) -> Responses:
        both = np.stack([of_state(state) for state in states])
        return both[..., : nominal.size], both[..., nominal.size :]

    return response
