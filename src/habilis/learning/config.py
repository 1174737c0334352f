"""The configuration of a training run."""

from dataclasses import dataclass, field, fields
from typing import Any

from habilis.cache import table_digest
from habilis.checks import as_in, at_least, check_types, one_of, setting, share
from habilis.empowerment.kinds import KINDS
from habilis.learning.algorithms import ALGORITHMS
from habilis.learning.algorithms.protocol import Algorithm
from habilis.mdp import TabularMDP
from habilis.reprs import settings, unfailing
from habilis.rewards.measures import Named
from habilis.rewards.shaping import Bonus

DEFAULT = "a2c"
"""The algorithm where none is named."""
NO_INTRINSIC = "none"
COUNT, DISTILLATION = "count", "rnd"
NOVELTIES = (COUNT, DISTILLATION)
BY_DIGEST = "table:"
"""The beginning of the world of a run that was trained on a table; its digest follows."""
ONE_HOT, COORDINATES = "one-hot", "coordinates"
OBSERVATIONS = (ONE_HOT, COORDINATES)


@dataclass(frozen=True)
class Config:
    """One row of a table: a world, an intrinsic reward, an algorithm, and how many runs.

    The agent learns from r + beta * M(s'), M in bits, s' the state that a step leads to (equation 1
    of Rasheed, Polani and Catenacci Volpi 2023), or as `earned` has it.

    Every field is described where it stands, and is an option of `habilis train`, as are those of
    the algorithm.

    Raises:
        ValueError: a field is out of its range.

    Example:
        >>> Config(world="yard", intrinsic="object", horizon=3, beta=0.08).regularised
        True
        >>> Config().changed(algorithm="ppo", envs=4).algorithm.envs
        4
    """

    world: str | TabularMDP = field(
        default="corridor",
        metadata={
            "help": 'a built-in world\'s name; the path of a map, a table (".npz", or ".drn" of '
            'Storm) or a puzzle (".pwp", ".xsb"); "gym:ID"; or a table itself',
            "static": False,
        },
    )
    tool: str | None = setting(
        None,
        'replaces the map\'s own tools: "picker", "broom", "rake", "stick", "magnet", '
        '"none" or "FILE.py:CLASS"',
    )
    algorithm: Algorithm = field(
        default_factory=lambda: ALGORITHMS[DEFAULT](), metadata={"help": "how the agent learns"}
    )
    intrinsic: str = setting(
        NO_INTRINSIC,
        'intrinsic reward: the empowerment through "state", a factor\'s name or "rest" (all '
        'but the agent), or sums and products of several, as "object:can + object:can2"; of '
        'another kind as "effective:object", "goal-directed:object"; "count", 1 / sqrt(visits '
        'of the state); "rnd", random network distillation; or "none"',
    )
    horizon: int = setting(0, "horizon of that empowerment, in actions")
    policy_every: int = setting(
        0,
        'with "effective:...": how many updates apart it is computed anew, under the agent\'s '
        "policy; 0: once, under the uniform policy",
    )
    beta: float = as_in(Bonus, "beta")
    beta_schedule: str = as_in(Bonus, "beta_schedule")
    beta_steps: int = as_in(Bonus, "beta_steps")
    earned: str = as_in(Bonus, "earned")
    terminal_bonus: bool = as_in(Bonus, "terminal_bonus")
    extrinsic: bool = as_in(Bonus, "extrinsic")
    runs: int = setting(10, "independent runs")
    seed: int = setting(0, "random seed of the runs")
    episodes: int = setting(100_000, "budget of episodes, after which a run ends")
    steps: int = setting(
        100_000_000, "budget of environment steps, after which a run ends (checked every 20,000)"
    )
    episode_limit: int = setting(500, "steps after which an episode is truncated")
    limit_is_terminal: bool = setting(
        False,
        "whether the agent treats a truncated episode as terminated (a bias: states far from the "
        "goal seem to cost less than they do)",
    )
    observation: str = setting(
        ONE_HOT,
        'what networks observe of a state: its factors, each "one-hot", or "coordinates" from '
        "-1 to 1",
    )
    slip: float = setting(0.0, "probability that a uniformly random action replaces the chosen one")
    starts: int = setting(
        0, "random placements of tools and objects that episodes start from; 0: the map's own"
    )
    unseen: int = setting(
        0, "further placements, held out of training, for the success rate on unseen ones"
    )
    starts_seed: int = setting(0, "random seed of these placements")

    @unfailing
    def __repr__(self) -> str:
        return settings(self, nested=("algorithm",))

    def __post_init__(self) -> None:
        if not isinstance(self.world, str | TabularMDP):
            raise ValueError(
                f"world is {self.world!r:.60}; give a name, a path or a table, such as "
                "habilis.explore(model)"
            )
        check_types(self, besides=["world"] if isinstance(self.world, TabularMDP) else [])
        algorithm = ALGORITHMS.name_of(self.algorithm)
        if self.tool is not None and not isinstance(self.tool, str):
            raise ValueError(f"tool is {self.tool!r}; give its name")
        at_least(
            self, horizon=0, policy_every=0, runs=1, seed=0, episodes=1, steps=1, episode_limit=1
        )
        at_least(self, starts=0, unseen=0, starts_seed=0)
        if (self.unseen or self.starts_seed) and not self.starts:
            raise ValueError(
                f"unseen is {self.unseen} and starts_seed {self.starts_seed}, but starts is 0: "
                "episodes begin where the map has everything; give starts"
            )
        share(self, "slip")
        one_of(self, "observation", OBSERVATIONS)
        for name in self.algorithm.ignores:
            if getattr(self, name) != _DEFAULTS[name]:
                raise ValueError(
                    f"{name} is {getattr(self, name)!r}, which plays no part in {algorithm}; leave "
                    f"it at {_DEFAULTS[name]!r}, or choose another algorithm"
                )
        _ = self.bonus  # which refuses what is out of its range
        if self.seed >= 2**32:
            raise ValueError(f"seed is {self.seed}; give one below {2**32}")
        if self.algorithm.rollout > self.episode_limit:
            raise ValueError(
                f"rollout is {self.algorithm.rollout} and episode_limit {self.episode_limit}; "
                "make a rollout no longer than an episode"
            )
        if (self.intrinsic == NO_INTRINSIC) != (self.beta == 0):
            raise ValueError(
                f"intrinsic is {self.intrinsic!r} and beta {self.beta:g}; give both the reward "
                "and its weight, or neither"
            )

        if self.horizon and not self.regularised:
            raise ValueError(
                f"horizon is {self.horizon} and intrinsic {self.intrinsic!r}, which has none; give "
                "the sensor of an empowerment as intrinsic, or leave out the horizon"
            )
        if self.intrinsic in KINDS:
            raise ValueError(
                f"intrinsic is {self.intrinsic!r}, a kind of empowerment without a sensor; name "
                f"one, as '{self.intrinsic}:object'"
            )
        measured = self.regularised and self.intrinsic not in NOVELTIES
        if measured and not Named.of(self.intrinsic).has_horizon:
            if self.horizon:
                raise ValueError(
                    f"horizon is {self.horizon} and intrinsic {self.intrinsic!r}, which has none; "
                    "leave out the horizon"
                )
        elif self.policy_every:
            raise ValueError(
                f"policy_every is {self.policy_every} and intrinsic {self.intrinsic!r}, which no "
                "policy changes; give an effective empowerment, such as 'effective:object'"
            )
        elif measured and self.horizon < 1:
            raise ValueError(
                f"intrinsic is {self.intrinsic!r} and horizon 0, so it is 0 everywhere; give a "
                "horizon of at least 1"
            )

    @property
    def bonus(self) -> Bonus:
        """How the intrinsic reward is added."""
        return Bonus(**{f.name: getattr(self, f.name) for f in fields(Bonus)})

    @property
    def regularised(self) -> bool:
        """Whether the agent learns from an intrinsic reward besides the extrinsic one."""
        return self.intrinsic != NO_INTRINSIC

    def as_dict(self) -> dict[str, Any]:
        """All fields as plain values, those of the algorithm among them; a table by its digest."""
        own = {f.name: getattr(self, f.name) for f in fields(self)}
        if isinstance(self.world, TabularMDP):
            own["world"] = BY_DIGEST + table_digest(self.world)
        learner = {f.name: getattr(self.algorithm, f.name) for f in fields(self.algorithm)}
        return own | {"algorithm": ALGORITHMS.name_of(self.algorithm)} | learner

    @classmethod
    def from_dict(cls, values: dict[str, Any]) -> "Config":
        """A configuration from plain values, such as a settings file holds.

        Args:
            values: fields by name, those of the algorithm among them; "algorithm" by its name, as
                "ppo". What is left out is the default.

        Returns:
            The configuration.

        Raises:
            ValueError: a field does not exist, or its value is out of range.
        """
        name = values.get("algorithm", DEFAULT)
        if not isinstance(name, str) or name not in ALGORITHMS:
            raise ValueError(f"algorithm {name!r} is unknown; use one of {', '.join(ALGORITHMS)}")
        kind = ALGORITHMS[name]
        own, learner = ({f.name for f in fields(c)} for c in (cls, kind))
        unknown = sorted(set(values) - own - learner)
        of_others = [other for other, k in ALGORITHMS.items() if unknown and _has(k, unknown[0])]
        if of_others:
            raise ValueError(
                f"{unknown[0]} is a setting of {' and '.join(of_others)}, not of {name}; leave it "
                f"out, or choose algorithm={of_others[0]!r}"
            )
        if unknown:
            raise ValueError(
                f"setting {unknown[0]!r} is unknown; use some of {', '.join(sorted(own | learner))}"
            )
        settings = {k: v for k, v in values.items() if k in learner}
        for f in fields(kind):  # JSON and TOML have lists
            if isinstance(f.default, tuple) and isinstance(settings.get(f.name), list):
                settings[f.name] = tuple(settings[f.name])
        algorithm = kind(**settings)
        given: dict[str, Any] = {k: v for k, v in values.items() if k in own}
        given["algorithm"] = algorithm
        return cls(**given)

    def changed(self, **values: Any) -> "Config":
        """This configuration with other values for some fields, its own or the algorithm's.

        Args:
            **values: fields by name. With another `algorithm`, by its name, all that is not given
                is that one's default.

        Returns:
            Another configuration; this one stays as it is.

        Raises:
            ValueError: as in `from_dict`.
        """
        kept = self.as_dict() | {"world": self.world}
        if values.get("algorithm", kept["algorithm"]) != kept["algorithm"]:
            kept = {f.name: kept[f.name] for f in fields(self)}
        return type(self).from_dict(kept | values)


def without_ignored(values: dict[str, Any]) -> dict[str, Any]:
    """Plain values, with the default for what plays no part in the algorithm.

    Editions before this one saved other values of such settings, which did nothing.
    """
    name = values.get("algorithm", DEFAULT)
    ignored = ALGORITHMS[name].ignores if name in ALGORITHMS else ()
    return values | {field: _DEFAULTS[field] for field in ignored}


_DEFAULTS = {f.name: f.default for f in fields(Config)}


def _has(kind: Any, name: str) -> bool:
    return any(f.name == name for f in fields(kind))
