"""Empowerment in the reward: r + beta * M, and which M."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from habilis.checks import above_zero, at_least, check_types, is_probability, one_of, setting

SCHEDULES = ("constant", "linear", "exponential")
EARNED = ("next", "current", "difference")

EXTRINSIC, EMPOWERMENT = "extrinsic_reward", "empowerment"
"""Keys of `info`: the environment's own reward, and the bits of the state that was reached."""


@dataclass(frozen=True)
class Bonus:
    """How a value M of states is added to the reward of a step from s to s'.

    Raises:
        ValueError: a field is out of its range.

    Example:
        >>> Bonus(beta=0.5).numbers(discount=0.99)["of_next"]
        1.0
    """

    beta: float = setting(
        0.0, "weight of that reward: the agent learns from reward + beta * bits(next state)"
    )
    beta_schedule: str = setting("constant", f"schedule of beta: {', '.join(SCHEDULES)}")
    beta_steps: int = setting(
        0, "environment steps after which beta is 0 (linear) or has halved (exponential)"
    )
    earned: str = setting(
        "next",
        "the state that the bonus is paid for: the next, the current one, or the difference "
        "discount * next - current, a potential, which preserves the optimal policy where beta and "
        "the values do not change",
    )
    terminal_bonus: bool = setting(True, "whether entering a terminal state earns the bonus, too")
    extrinsic: bool = setting(True, "whether the agent also learns from the world's reward")

    def __post_init__(self) -> None:
        check_types(self)
        at_least(self, beta_steps=0)
        one_of(self, "beta_schedule", SCHEDULES)
        one_of(self, "earned", EARNED)
        if self.beta_schedule != "constant":
            above_zero(self, "beta_steps")

    def numbers(self, discount: float) -> dict[str, float]:
        """These settings as the numbers that `regularised` needs.

        Args:
            discount: gamma, in the difference gamma M(s') - M(s) (Ng, Harada and Russell 1999).

        Raises:
            ValueError: discount is not from 0 to 1.
        """
        if not is_probability(discount):
            raise ValueError(f"discount is {discount!r}; give a number from 0 to 1")
        over = max(self.beta_steps, 1)
        return {
            "beta": self.beta,
            "beta_falls": 1 / over if self.beta_schedule == "linear" else 0.0,
            "beta_halves": 1 / over if self.beta_schedule == "exponential" else 0.0,
            "of_next": {"next": 1.0, "current": 0.0, "difference": discount}[self.earned],
            "of_current": {"next": 0.0, "current": 1.0, "difference": -1.0}[self.earned],
            # A potential must be 0 where nothing follows, or it would change the best policy.
            "of_terminal": float(self.terminal_bonus and self.earned != "difference"),
            "extrinsic": float(self.extrinsic),
        }


def regularised(
    numbers: Mapping[str, Any],
    extrinsic: Any,
    of_next: Any,
    of_current: Any,
    terminated: Any,
    taken: Any,
    xp: Any = np,
) -> Any:
    """The reward that is learned from, of one step or an array of them.

        r + beta * M(s')        or, as the settings have it, M(s), gamma M(s') - M(s)

    Args:
        numbers: of `Bonus.numbers`.
        extrinsic: r, the environment's reward.
        of_next, of_current: M of the state after the step, and before it.
        terminated: whether the step ended the episode by its own rules.
        taken: environment steps made so far, on which the weight may depend.
        xp: the module whose arrays these are, `numpy` or `jax.numpy`.
    """
    beta = beta_after(numbers, taken, xp)
    entered = xp.where(terminated, numbers["of_terminal"], 1.0) * numbers["of_next"] * of_next
    return numbers["extrinsic"] * extrinsic + beta * (entered + numbers["of_current"] * of_current)


def beta_after(numbers: Mapping[str, Any], taken: Any, xp: Any = np) -> Any:
    """The weight of the bonus after so many environment steps."""
    fallen = xp.maximum(0.0, 1 - taken * numbers["beta_falls"])
    return numbers["beta"] * fallen * xp.exp2(-taken * numbers["beta_halves"])
