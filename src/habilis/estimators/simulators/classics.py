"""Four classic continuous worlds, written in JAX.

Noise is one number in all of them: the standard deviation of the Gaussian noise that each step
adds to every component of the action, independently.
"""

from typing import Any

import numpy as np

from habilis.checks import is_number
from habilis.empowerment.arguments import positive
from habilis.estimators.actions import ActionBox
from habilis.estimators.simulators import scenes
from habilis.estimators.simulators.jax_function import JaxSimulator
from habilis.probabilities import as_array

GRAVITY = 9.81


def linear_system(
    A: Any, B: Any, *, noise: Any = None, actions: Any = None, spread: float = 1.0
) -> JaxSimulator:
    """The linear system s' = A s + B a + N z, z of independent standard normal numbers.

    Args:
        A: float[d, d].
        B: float[d, k].
        noise: N, float[d, q]: N N^T is the covariance of the process noise. `None` without.
        actions: of a simulator; by default all vectors of k numbers.
        spread: states to fit to are drawn from -spread to spread.

    Returns:
        A simulator, which `Gaussian` gives the exact empowerment of.

    Raises:
        ValueError: the matrices do not fit together.

    Example:
        >>> simulator = linear_system([[1.0, 0.1], [0.0, 1.0]], [[0.0], [0.1]])
        >>> np.asarray(simulator.step(np.zeros((1, 2)), np.ones((1, 1))))
        array([[0. , 0.1]], dtype=float32)
    """
    A, B = as_array("A", A), as_array("B", B)
    N = None if noise is None else as_array("noise", noise)
    size = len(A)
    for name, matrix in (("A", A), ("B", B), ("noise", N)):
        if matrix is None:
            continue
        square = name == "A" and matrix.shape != (size, size)
        if matrix.ndim != 2 or square or len(matrix) != size or matrix.dtype.kind not in "biuf":
            raise ValueError(
                f"{name} has shape {matrix.shape}; give A float[d, d], B float[d, k] and noise "
                "float[d, q]"
            )
    A, B = A.astype(np.float64), B.astype(np.float64)

    def step(state: Any, action: Any) -> Any:
        return A @ state + B @ action

    def noisy_step(state: Any, action: Any, drawn: Any) -> Any:
        assert N is not None
        return A @ state + B @ action + N.astype(np.float64) @ drawn

    unbounded = ActionBox(np.full(B.shape[1], -np.inf), np.full(B.shape[1], np.inf))
    return JaxSimulator(
        step if N is None else noisy_step,
        unbounded if actions is None else actions,
        noise=0 if N is None else N.shape[1],
        low=np.full(size, -spread),
        high=np.full(size, spread),
        is_linear=True,
        name="linear system",
    )


def double_integrator(
    *, force: float = 1.0, dt: float = 0.1, noise: float = 0.0, limit: float = 3.0
) -> JaxSimulator:
    """A unit mass on a line, pushed by a force: state (position in m, velocity in m/s).

    It is linear, and a step is exact.

    Args:
        force: in N, actions are from -force to force.
        dt: seconds of a step.
        noise: the standard deviation of what is added to the force of a step.
        limit: m and m/s up to which states to fit to are drawn.

    Returns:
        A simulator with the names "position" and "velocity".

    Raises:
        ValueError: a number is out of its range.

    Example:
        >>> simulator = double_integrator(dt=1.0)
        >>> np.asarray(simulator.step(np.zeros((1, 2)), np.ones((1, 1)))).tolist()
        [[0.5, 1.0]]
    """
    force, dt, limit = positive("force", force), positive("dt", dt), positive("limit", limit)

    def step(state: Any, action: Any, drawn: Any = None) -> Any:
        import jax.numpy as jnp

        (a,) = _pushed(action, noise, drawn)
        x, v = state
        return jnp.stack([x + v * dt + a * dt * dt / 2, v + a * dt])

    return JaxSimulator(
        step,
        ActionBox([-force], [force]),
        noise=_drawn(noise, 1),
        names={"position": 0, "velocity": 1},
        low=[-limit, -limit],
        high=[limit, limit],
        is_linear=True,
        draw=lambda state: scenes.double_integrator(state, limit, "double integrator"),
        name="double integrator",
    )


def pendulum(
    *,
    torque: float = 5.0,
    mass: float = 1.0,
    length: float = 1.0,
    friction: float = 0.05,
    dt: float = 0.1,
    substeps: int = 4,
    noise: float = 0.0,
) -> JaxSimulator:
    """A mass on a rod that can turn all the way round: state (angle in rad, velocity in rad/s).

    The angle is 0 upright and grows clockwise; it is not wrapped. The default torque is too weak to
    lift the mass at once. Integrated by the method of Runge and Kutta of order 4.

    Args:
        torque: in Nm, actions are from -torque to torque.
        mass: in kg.
        length: in m.
        friction: in Nms.
        dt: seconds of a step.
        substeps: how many steps of integration it takes.
        noise: the standard deviation of what is added to the torque of a step.

    Returns:
        A simulator. Its observation is (cos, sin) of the angle and the velocity, named "angle" (the
        first two) and "velocity".

    Raises:
        ValueError: a number is out of its range.

    Example:
        >>> simulator = pendulum()
        >>> upright = np.zeros((1, 2))
        >>> np.asarray(simulator.step(upright, np.zeros((1, 1)))).tolist()
        [[0.0, 0.0]]
    """
    torque, dt = positive("torque", torque), positive("dt", dt)
    inertia = positive("mass", mass) * positive("length", length) ** 2

    def step(state: Any, action: Any, drawn: Any = None) -> Any:
        import jax.numpy as jnp

        (u,) = _pushed(action, noise, drawn)

        def change(state: Any) -> Any:
            angle, velocity = state
            pull = mass * GRAVITY * length * jnp.sin(angle)
            return jnp.stack([velocity, (pull - friction * velocity + u) / inertia])

        return _integrated(change, state, dt, substeps)

    def observation(state: Any) -> Any:
        import jax.numpy as jnp

        return jnp.stack([jnp.cos(state[0]), jnp.sin(state[0]), state[1]])

    return JaxSimulator(
        step,
        ActionBox([-torque], [torque]),
        noise=_drawn(noise, 1),
        observation=observation,
        names={"angle": [0, 1], "velocity": 2},
        low=[-np.pi, -8.0],
        high=[np.pi, 8.0],
        draw=lambda state: scenes.pendulum(state, length, "pendulum"),
        name="pendulum",
    )


def cart_pole(
    *,
    force: float = 10.0,
    cart: float = 1.0,
    mass: float = 0.1,
    half_length: float = 0.5,
    dt: float = 0.05,
    substeps: int = 2,
    noise: float = 0.0,
    limit: float = 2.4,
) -> JaxSimulator:
    """A pole on a cart: state (position in m, velocity in m/s, angle in rad, velocity in rad/s).

    The angle is 0 upright and grows clockwise; it is not wrapped, and the track has no end.
    Equations as in Florian (2007), without friction, integrated by the method of Runge and Kutta of
    order 4.

    Args:
        force: in N, actions are from -force to force.
        cart: the cart's mass in kg.
        mass: the pole's in kg.
        half_length: from the pole's foot to its middle, in m.
        dt: seconds of a step.
        substeps: how many steps of integration it takes.
        noise: the standard deviation of what is added to the force of a step.
        limit: m from the middle up to which states to fit to are drawn, and the track is.

    Returns:
        A simulator. Its observation is position, velocity, (cos, sin) of the angle and the angular
        velocity, with the names "cart" (the first two), "angle" and "pole" (the last three).

    Raises:
        ValueError: a number is out of its range.

    Example:
        >>> simulator = cart_pole()
        >>> pushed = np.asarray(simulator.step(np.zeros((1, 4)), np.ones((1, 1))))[0]
        >>> bool(pushed[0] > 0 and pushed[2] < 0)  # the pole is left behind
        True
    """
    force, dt, limit = positive("force", force), positive("dt", dt), positive("limit", limit)
    total = positive("cart", cart) + positive("mass", mass)
    positive("half_length", half_length)

    def step(state: Any, action: Any, drawn: Any = None) -> Any:
        import jax.numpy as jnp

        (u,) = _pushed(action, noise, drawn)

        def change(state: Any) -> Any:
            _, velocity, angle, turning = state
            sine, cosine = jnp.sin(angle), jnp.cos(angle)
            push = (u + mass * half_length * turning**2 * sine) / total
            turned = (GRAVITY * sine - cosine * push) / (
                half_length * (4 / 3 - mass * cosine**2 / total)
            )
            moved = push - mass * half_length * turned * cosine / total
            return jnp.stack([velocity, moved, turning, turned])

        return _integrated(change, state, dt, substeps)

    def observation(state: Any) -> Any:
        import jax.numpy as jnp

        x, velocity, angle, turning = state
        return jnp.stack([x, velocity, jnp.cos(angle), jnp.sin(angle), turning])

    return JaxSimulator(
        step,
        ActionBox([-force], [force]),
        noise=_drawn(noise, 1),
        observation=observation,
        names={"cart": [0, 1], "angle": [2, 3], "pole": [2, 3, 4]},
        low=[-limit, -2.0, -np.pi, -4.0],
        high=[limit, 2.0, np.pi, 4.0],
        draw=lambda state: scenes.cart_pole(state, half_length, limit, "cart-pole"),
        name="cart-pole",
    )


def ball_in_box(
    *,
    force: float = 1.0,
    size: float = 3.0,
    radius: float = 0.2,
    friction: float = 0.5,
    dt: float = 0.2,
    noise: float = 0.0,
) -> JaxSimulator:
    """A ball of unit mass between four walls that it bounces off: state (x, y, and velocities).

    Positions are in m from the lower left corner, velocities in m/s. Near a wall, and most of all
    in a corner, fewer places are within reach.

    Args:
        force: in N, each component of an action is from -force to force.
        size: of the box in m.
        radius: of the ball in m.
        friction: the rate at which its velocity decays, in 1/s.
        dt: seconds of a step.
        noise: the standard deviation of what is added to each component of the force of a step.

    Returns:
        A simulator with the names "position" and "velocity".

    Raises:
        ValueError: a number is out of its range, or the ball does not fit into the box.

    Example:
        >>> simulator = ball_in_box(friction=0.0, dt=1.0)
        >>> start = np.array([[0.2, 1.0, -1.0, 0.0]])
        >>> moved = np.asarray(simulator.step(start, np.zeros((1, 2))))
        >>> moved.round(2)  # off the left wall
        array([[1.2, 1. , 1. , 0. ]], dtype=float32)
    """
    force, dt = positive("force", force), positive("dt", dt)
    room = positive("size", size) - 2 * positive("radius", radius)
    if room <= 0:
        raise ValueError(f"radius is {radius}; give less than half the size of the box, {size}")

    def step(state: Any, action: Any, drawn: Any = None) -> Any:
        import jax.numpy as jnp

        pushed = jnp.stack(_pushed(action, noise, drawn))
        velocity = (state[2:] + pushed * dt) * np.exp(-friction * dt)
        # Beyond a wall the path goes on in a mirror image of the box.
        reached = (state[:2] - radius + velocity * dt) % (2 * room)
        back = reached > room
        place = radius + jnp.where(back, 2 * room - reached, reached)
        return jnp.concatenate([place, jnp.where(back, -velocity, velocity)])

    return JaxSimulator(
        step,
        ActionBox([-force, -force], [force, force]),
        noise=_drawn(noise, 2),
        names={"position": [0, 1], "velocity": [2, 3]},
        low=[radius, radius, -2.0, -2.0],
        high=[size - radius, size - radius, 2.0, 2.0],
        draw=lambda state: scenes.ball_in_box(state, size, radius, "ball in a box"),
        name="ball in a box",
    )


def _drawn(noise: float, size: int) -> int:
    """How many numbers a step draws."""
    if not is_number(noise) or not 0 <= noise < np.inf:
        raise ValueError(f"noise is {noise!r}; give a standard deviation, 0 or more")
    return size if noise else 0


def _pushed(action: Any, noise: float, drawn: Any) -> list[Any]:
    """The components of an action with its noise."""
    pushed = action if drawn is None else action + noise * drawn
    return [pushed[index] for index in range(len(pushed))]


def _integrated(change: Any, state: Any, dt: float, substeps: int) -> Any:
    """The state after dt seconds."""
    import jax

    step = dt / substeps

    def once(_: Any, state: Any) -> Any:
        k1 = change(state)
        k2 = change(state + step / 2 * k1)
        k3 = change(state + step / 2 * k2)
        k4 = change(state + step * k3)
        return state + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)

    return jax.lax.fori_loop(0, substeps, once, state)
