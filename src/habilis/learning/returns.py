"""Returns and advantages."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float


def generalised_advantages(
    reward: Float[Array, "T E"],
    value: Float[Array, "T E"],
    next_value: Float[Array, "T E"],
    terminated: Bool[Array, "T E"],
    truncated: Bool[Array, "T E"],
    discount: Float[Array, ""] | float,
    gae_lambda: Float[Array, ""] | float,
) -> Float[Array, "T E"]:
    """The generalised advantage estimate (Schulman et al. 2016).

        delta_t = r_t + discount * V(s'_t) - V(s_t)          V(s'_t) = 0 where s'_t is terminal
        A_t     = delta_t + discount * lambda * A_{t+1}      the sum ends where an episode does

    With lambda 1 the estimate plus `value` is the n-step return.

    Args:
        reward, value: r_t and V(s_t) of step t in environment e.
        next_value: V(s'_t) of the state the step led to, before any reset. Where an episode is
            cut off, this is what its future is worth; where it terminates, it is not used.
        terminated, truncated: whether the step ended its episode, and how.
        discount, gae_lambda: between 0 and 1.
    """
    delta = reward + discount * jnp.where(terminated, 0.0, next_value) - value
    decay = discount * gae_lambda * ~(terminated | truncated)

    def back(later, step):
        advantage = step[0] + step[1] * later
        return advantage, advantage

    _, advantages = jax.lax.scan(
        back, jnp.zeros_like(value[0]), (delta, decay), reverse=True, unroll=8
    )
    return advantages
