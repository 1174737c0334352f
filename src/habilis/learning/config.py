"""What a training run is made of."""

from dataclasses import dataclass, field, fields, replace
from typing import Any, TypeVar

NO_INTRINSIC = "none"
OPTIMIZERS = ("rmsprop", "adam")

Value = TypeVar("Value")


def _setting(default: Value, text: str) -> Value:
    """A field with its description, which the command line shows as help."""
    return field(default=default, metadata={"help": text})


@dataclass(frozen=True)
class Config:
    """One row of a table: a world, an intrinsic reward, the A2C settings, and how many runs.

    Every field is described where it stands, and is an option of `habilis train`.

    Raises:
        ValueError: a field is out of its range.

    Example:
        >>> Config(world="yard", intrinsic="object", horizon=3, beta=0.08).regularised
        True
    """

    world: str = _setting("corridor", "a built-in world's name or the path of a map")
    tool: str | None = _setting(None, "takes the place of the map's own tool")
    intrinsic: str = _setting(
        NO_INTRINSIC,
        'sensor whose empowerment is added to the reward: "state", a factor\'s name, or "none"',
    )
    horizon: int = _setting(0, "horizon of that empowerment, in actions")
    beta: float = _setting(
        0.0, "weight of that empowerment: the agent learns from reward + beta * bits(next state)"
    )
    runs: int = _setting(10, "independent runs")
    seed: int = _setting(0, "where the runs' random numbers start")
    episodes: int = _setting(100_000, "episodes after which a run is given up")
    steps: int = _setting(100_000_000, "environment steps after which a run is given up")
    envs: int = _setting(16, "environments that each run steps together")
    rollout: int = _setting(5, "steps of each environment between two updates")
    episode_limit: int = _setting(500, "steps after which an episode is cut off (truncated)")
    learning_rate: float = _setting(2e-3, "step size of the optimiser")
    optimizer: str = _setting("rmsprop", "rmsprop (decay 0.99, epsilon 1e-5) or adam")
    clip: float = _setting(0.5, "largest norm of the gradient")
    entropy: float = _setting(0.02, "weight of the policy's entropy (nats) in the loss")
    value: float = _setting(0.5, "weight of the value's squared error in the loss")
    discount: float = _setting(0.99, "discount factor, gamma")
    gae_lambda: float = _setting(1.0, "lambda of the generalised advantage; 1: n-step returns")
    reward_scale: float = _setting(
        1.0, "factor on the reward that the agent learns from (counted returns have none)"
    )
    hidden: tuple[int, ...] = _setting((64, 64), "widths of the network's hidden layers")

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
