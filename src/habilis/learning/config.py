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
    steps: int = _setting(
        100_000_000, "environment steps after which a run is given up (looked at every 20,000)"
    )
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
        object.__setattr__(self, "hidden", _widths(self.hidden))
        for f in fields(self):
            _check_type(f.name, getattr(self, f.name), type(f.default))
        for name, least in _LEAST.items():
            if not getattr(self, name) >= least:
                raise ValueError(f"{name} is {getattr(self, name)!r}; give at least {least}")
        for name in ("learning_rate", "clip", "reward_scale"):
            if not getattr(self, name) > 0:
                raise ValueError(f"{name} is {getattr(self, name)!r}; give a number above 0")
        for name in ("discount", "gae_lambda"):
            if not 0 <= getattr(self, name) <= 1:
                raise ValueError(f"{name} is {getattr(self, name)!r}; give a number from 0 to 1")
        if self.seed >= 2**32:
            raise ValueError(f"seed is {self.seed}; give one below {2**32}")
        if self.optimizer not in OPTIMIZERS:
            raise ValueError(
                f"optimizer {self.optimizer!r} is unknown; use one of {', '.join(OPTIMIZERS)}"
            )
        if self.rollout > self.episode_limit:
            raise ValueError(
                f"rollout is {self.rollout} and episode_limit {self.episode_limit}; "
                "make a rollout no longer than an episode"
            )
        if (self.intrinsic == NO_INTRINSIC) != (self.beta == 0):
            raise ValueError(
                f"intrinsic is {self.intrinsic!r} and beta {self.beta:g}; give both a sensor and "
                "its weight, or neither"
            )

    @property
    def regularised(self) -> bool:
        """Whether the agent learns from an intrinsic reward besides the extrinsic one."""
        return self.intrinsic != NO_INTRINSIC

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

_LARGEST = 1e30  # of a number that is learned with, in float32


def _check_type(name: str, value: Any, wanted: type) -> None:
    """Refuses a value that is not of its field's type, or no finite number."""
    if wanted is int and (isinstance(value, bool) or not isinstance(value, int)):
        raise ValueError(f"{name} is {value!r}; give a whole number")
    if wanted is float:
        number = isinstance(value, int | float) and not isinstance(value, bool)
        if not number or not abs(value) <= _LARGEST:
            raise ValueError(f"{name} is {value!r}; give a finite number")
    if wanted is str and not isinstance(value, str):
        raise ValueError(f"{name} is {value!r}; give a text")


def _widths(value: Any) -> tuple[int, ...]:
    """Layer widths as a tuple; lists come from JSON."""
    if (
        not isinstance(value, tuple | list)
        or not value
        or not all(isinstance(width, int) and width >= 1 for width in value)
    ):
        raise ValueError(f"hidden is {value!r}; give at least one width of at least 1")
    return tuple(value)
