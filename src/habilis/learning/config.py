"""What a training run is made of."""

from dataclasses import dataclass, field, fields, replace
from typing import Any

NO_INTRINSIC = "none"
OPTIMIZERS = ("rmsprop", "adam")


@dataclass(frozen=True)
class Config:
    """One row of a table: a world, an intrinsic reward, the A2C settings, and how many runs.

    Example:
        >>> Config(world="yard", intrinsic="object", horizon=3, beta=0.08).regularised
        True
    """

    world: str = "corridor"
    """A built-in world's name or the path of a map."""
    tool: str | None = None
    """Takes the place of the map's own tool; `None` keeps that."""
    intrinsic: str = NO_INTRINSIC
    """The sensor whose empowerment is added to the reward: "state", a factor's name, "none"."""
    horizon: int = 0
    """Horizon of that empowerment, in actions."""
    beta: float = 0.0
    """Its weight: the agent learns from `reward + beta * bits` of the state a step leads to."""
    runs: int = 10
    """Independent runs; run i of seed s is the same whatever else trains beside it."""
    seed: int = 0
    """Where the runs' random numbers start."""
    episodes: int = 60_000
    """Budget: a run that has not converged by then counts as not converged."""
    steps: int = 100_000_000
    """Budget of environment steps of one run; whichever budget is used up first ends it."""
    envs: int = 16
    """Environments that each run steps together."""
    rollout: int = 5
    """Steps of each environment between two updates."""
    episode_limit: int = 500
    """Steps after which an episode is cut off (truncated, not terminated)."""
    learning_rate: float = 2e-3
    """Constant step size of the optimiser."""
    optimizer: str = "rmsprop"
    """ "rmsprop" (decay 0.99, epsilon 1e-5) or "adam"."""
    clip: float = 0.5
    """Largest norm of the whole gradient."""
    entropy: float = 0.02
    """Weight of the policy's entropy (nats) in the loss."""
    value: float = 0.5
    """Weight of the value's squared error in the loss."""
    discount: float = 0.99
    """Discount factor, gamma."""
    gae_lambda: float = 1.0
    """Lambda of the generalised advantage estimate; 1 is plain n-step returns."""
    reward_scale: float = 1.0
    """Factor on the regularised reward that the agent learns from; counted returns have none."""
    hidden: tuple[int, ...] = field(default=(64, 64))
    """Widths of the network's hidden layers."""

    def __post_init__(self) -> None:
        for name, least in _LEAST.items():
            if not getattr(self, name) >= least:
                raise ValueError(f"{name} is {getattr(self, name)!r}; give at least {least}")
        for name in ("learning_rate", "clip", "reward_scale"):
            if not 0 < getattr(self, name) < float("inf"):
                raise ValueError(f"{name} is {getattr(self, name)!r}; give a number above 0")
        for name in ("discount", "gae_lambda"):
            if not 0 <= getattr(self, name) <= 1:
                raise ValueError(f"{name} is {getattr(self, name)!r}; give a number from 0 to 1")
        if not abs(self.beta) < float("inf"):
            raise ValueError(f"beta is {self.beta!r}; give a finite number")
        if self.optimizer not in OPTIMIZERS:
            raise ValueError(
                f"optimizer {self.optimizer!r} is unknown; use one of {', '.join(OPTIMIZERS)}"
            )
        if not self.hidden or min(self.hidden) < 1:
            raise ValueError(f"hidden is {self.hidden!r}; give at least one width of at least 1")
        if self.rollout > self.episode_limit:
            raise ValueError(
                f"rollout is {self.rollout} and episode_limit {self.episode_limit}; "
                "make a rollout no longer than an episode"
            )

    @property
    def regularised(self) -> bool:
        """Whether the agent learns from an intrinsic reward besides the extrinsic one."""
        return self.intrinsic != NO_INTRINSIC and self.beta != 0

    @classmethod
    def from_dict(cls, values: dict[str, Any]) -> "Config":
        """A configuration from plain values, such as a settings file holds.

        Raises:
            ValueError: a field does not exist, or its value is out of range.
        """
        known = {f.name for f in fields(cls)}
        unknown = sorted(set(values) - known)
        if unknown:
            raise ValueError(
                f"setting {unknown[0]!r} is unknown; use some of {', '.join(sorted(known))}"
            )
        if "hidden" in values:
            values = {**values, "hidden": tuple(values["hidden"])}
        return replace(cls(), **values)


_LEAST = {
    "horizon": 0,
    "runs": 1,
    "seed": 0,
    "episodes": 1,
    "steps": 1,
    "envs": 1,
    "rollout": 1,
    "episode_limit": 1,
    "entropy": 0,
    "value": 0,
}
