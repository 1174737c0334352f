"""A differentiable function of JAX as a simulator."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Float, Float64

from habilis.empowerment.arguments import whole_number
from habilis.estimators.actions import checked_actions
from habilis.estimators.protocol import Random, check_length
from habilis.extras import import_from

if TYPE_CHECKING:
    from habilis.estimators.simulators.scenes import Scene


@dataclass(frozen=True, eq=False)
class JaxSimulator:
    """A function of JAX as a simulator.

    Attributes:
        function: of one state float[d] and one action float[k], the next state; with noise of a
            third vector too, float[noise], of independent standard normal numbers. Written with
            `jax.numpy`, and differentiable where `Gaussian` is to be used.
        actions: float[m, k], or an `ActionBox`.
        noise: how many standard normal numbers a step draws; 0 of a deterministic function.
        observation: of one state, the observation; by default the state itself.
        names: of entries of the observation: an index, a list of indices or a slice by name.
        low, high: float[d], between which `random_states` draws; without them there are none.
        is_linear: whether the function is linear in state, action and noise, and the observation
            in the state.
        draw: a picture of one state, see `at`.
        name: what messages and pictures call it.

    Raises:
        ValueError: the actions are none, or noise is no whole number.

    Example:
        >>> simulator = JaxSimulator(lambda state, action: 0.9 * state + action, [[-1.0], [1.0]])
        >>> simulator.step(np.ones((2, 1)), np.array([[-1.0], [1.0]])).round(1).ravel()
        Array([-0.1,  1.9], dtype=float32)
    """

    function: Callable[..., Any]
    actions: Any
    noise: int = 0
    observation: Callable[[Any], Any] | None = None
    names: Mapping[str, Any] = field(default_factory=dict)
    low: Any = None
    high: Any = None
    is_linear: bool = False
    draw: "Callable[[np.ndarray], Scene] | None" = None
    name: str = "simulator"

    def __post_init__(self) -> None:
        object.__setattr__(self, "actions", checked_actions(self.actions))
        object.__setattr__(self, "noise", whole_number("noise", self.noise))

    @property
    def in_jax(self) -> bool:
        """True: it can be compiled and differentiated."""
        return True

    @property
    def is_stochastic(self) -> bool:
        """Whether a step draws noise."""
        return self.noise > 0

    def step(
        self, states: Float[Any, "n d"], actions: Float[Any, "n k"], key: Random = None
    ) -> Float[Any, "n d"]:
        """One step of many states at once.

        Args:
            states: one a row.
            actions: one for each.
            key: of JAX; has no part in a deterministic step.

        Returns:
            The next states.
        """
        jax = import_from("jax", "robots")
        drawn = None
        if self.noise:
            drawn = jax.random.normal(key, (len(states), self.noise), states.dtype)
        return self.transition(states, actions, drawn)

    def transition(
        self, states: Float[Any, "n d"], actions: Float[Any, "n k"], noise: Any
    ) -> Float[Any, "n d"]:
        """One step with given noise.

        Args:
            states: one a row.
            actions: one for each.
            noise: float[n, noise]; `None` without noise.

        Returns:
            The next states.
        """
        jax = import_from("jax", "robots")
        if self.low is not None:
            check_length(states, np.size(self.low))
        if self.noise:
            return jax.vmap(self.function)(states, actions, noise)
        return jax.vmap(self.function)(states, actions)

    def observe(self, states: Float[Any, "n d"]) -> Float[Any, "n o"]:
        """The observations of states.

        Args:
            states: one a row.

        Returns:
            One a row.
        """
        if self.observation is None:
            return states
        return import_from("jax", "robots").vmap(self.observation)(states)

    def random_states(
        self, count: int, generator: np.random.Generator
    ) -> Float64[np.ndarray, "n d"]:
        """States drawn uniformly between `low` and `high`.

        Args:
            count: n.
            generator: to draw from.

        Returns:
            One a row.

        Raises:
            ValueError: low and high were not given.
        """
        if self.low is None or self.high is None:
            raise ValueError(f"{self.name} has no low and high to draw states from; give them")
        low, high = np.asarray(self.low, np.float64), np.asarray(self.high, np.float64)
        return generator.uniform(low, high, (count, len(low)))

    def at(self, state: Any) -> "Scene":
        """A state as something to draw, which `save_picture` and `save_video` take.

        Args:
            state: float[d].

        Returns:
            A scene.

        Raises:
            ValueError: the simulator has no picture.
        """
        if self.draw is None:
            raise ValueError(f"{self.name} has no picture; give draw=, a function of one state")
        return self.draw(np.asarray(state, np.float64))
