"""Configurations, ready to be trained."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from habilis.cache import fingerprint
from habilis.learning import intrinsic
from habilis.learning.config import NO_INTRINSIC, Config
from habilis.learning.dynamics import Dynamics, make_dynamics, roomy
from habilis.learning.episodes import Ledger
from habilis.learning.lanes import Lane, Program, Settings, settings_of, start_lanes
from habilis.learning.runs import Record, Run, episode_table
from habilis.learning.sources import Source, source_of
from habilis.learning.stacks import InStack
from habilis.learning.training_problem import (
    KEPT,
    Conditions,
    best_return,
    margin,
    training_problem,
)
from habilis.mdp import TabularMDP
from habilis.worlds.world import World

STRETCH = 20_000
"""Environment steps of one run between two looks at it from Python."""


@dataclass(frozen=True, eq=False)
class Job:
    """A configuration, ready to be trained, and how far its runs have come.

    Attributes:
        index: its place among those trained together.
        config: the configuration.
        world: its world, or table.
        mdp: its table.
        best_return: of a shortest plan; in a stochastic world, what the best policy expects.
        table: float64[S], the intrinsic value of every state, where it is a table.
        numbers: of its runs, from which their random numbers come; 0 up, unless it has only some
            of them. Elsewhere a run is meant by its place among these.
        records: of its runs.
        lanes: of its runs that have begun, as they were after the last stretch: in arrays of
            their own, or side by side with other runs. `lane` gives one in any case.
    """

    index: int
    config: Config
    world: Source
    mdp: TabularMDP
    best_return: float
    table: Float[np.ndarray, "S"]
    numbers: tuple[int, ...]
    records: list[Record]
    lanes: dict[int, Lane | InStack]

    @classmethod
    def of(
        cls,
        index: int,
        config: Config,
        world: Source | None = None,
        numbers: Sequence[int] | None = None,
    ) -> "Job":
        """A configuration, ready to be trained.

        Args:
            index: its place among those trained together.
            config: the configuration.
            world: its world, if that is not to be read from where the configuration says.
            numbers: which of its runs, if not all.

        Raises:
            ValueError: a world, tool or sensor does not exist, or the goal is unreachable.
        """
        world = source_of(config) if world is None else world
        conditions = Conditions.of(config)
        mdp = training_problem(world, conditions).mdp
        intrinsic.check_sensors(mdp, config.intrinsic)
        ledger = _ledger(world, conditions)
        numbers = tuple(range(config.runs) if numbers is None else numbers)
        best = best_return(world, conditions, config.episode_limit)
        close = margin(world, conditions, config.episode_limit)
        records = [Record(config, best, ledger, close) for _ in numbers]
        table = _values(
            world, conditions, config.intrinsic, config.horizon, config.algorithm.discount
        )
        return cls(index, config, world, mdp, best, table, numbers, records, {})

    @property
    def conditions(self) -> Conditions:
        """The settings of its episodes besides the map."""
        return Conditions.of(self.config)

    @cached_property
    def dynamics(self) -> tuple[Dynamics, int]:
        # A table of values would have some for states that nobody comes to.
        with_room = self.config.starts > 0 and not self.config.algorithm.tabular
        return _task(self.world, self.conditions, with_room, self.config.observation)

    @cached_property
    def program(self) -> Program:
        return Program.of(self.config, self.dynamics[1], STRETCH)

    @cached_property
    def settings(self) -> Settings:
        more = self.dynamics[0].states - self.mdp.states
        return settings_of(self.config, np.pad(self.table, (0, more)))

    @cached_property
    def kind(self) -> tuple:
        """The properties shared by all runs in a batch; other settings may differ."""
        return self.world, self.conditions, self.config.observation, self.program

    def lane(self, run: int) -> Lane:
        """A run as it was after its last stretch, or before its first step, in NumPy arrays."""
        held = self.lanes.get(run)
        if held is None:
            held = self.lanes[run] = self.start(run)
        return held.lane() if isinstance(held, InStack) else jax.tree.map(np.asarray, held)

    def start(self, run: int) -> Lane:
        """A run before its first step; its random numbers are its own."""
        key = jax.random.fold_in(jax.random.key(self.config.seed), self.numbers[run])
        lanes = start_lanes(self.dynamics[0], self.program, key[None])
        return jax.tree.map(lambda leaf: np.asarray(leaf)[0], lanes)

    def followed(self, train_state: Any) -> Float[np.ndarray, "S"]:
        """The intrinsic value of every state under the policy of one of its runs.

        Raises:
            ValueError: a state has no action, so that a policy ends there.
        """
        dynamics = self.dynamics[0]
        policy = np.asarray(self.config.algorithm.policy(dynamics, train_state.parameters))
        values = intrinsic.followed_table(self.mdp, self.config, policy[: self.mdp.states])
        return np.pad(values, (0, dynamics.states - self.mdp.states)).astype(np.float32)

    def result(self) -> Run:
        """The results, when all runs have ended."""
        learned = [self.lane(run).train_state.parameters for run in range(len(self.records))]
        return Run(
            config=self.config,
            world=self.world,
            best_return=self.best_return,
            episodes=episode_table(self.records, list(self.mdp.flags)),
            converged_at=tuple(record.converged_at for record in self.records),
            parameters=jax.tree.map(lambda *leaves: jnp.stack(leaves), *learned),
        )


# What many jobs share is made once: a sweep has thousands of them on a few worlds.


@lru_cache(KEPT)
def _ledger(world: Source, conditions: Conditions) -> Ledger:
    return Ledger.of(training_problem(world, conditions).mdp)


def digest_of_own_tool(world: Source) -> str | None:
    """A fingerprint of a world's table with custom tools, in 32 hexadecimal digits.

    `None` where all tools are built-in ones, which are always the same.

    Raises:
        ValueError: the goal is unreachable.
    """
    if not isinstance(world, World) or not world.own_tools:
        return None
    mdp = training_problem(world).mdp
    return fingerprint(mdp.transitions, *mdp.factors.values(), *mdp.flags.values())[:32]


@lru_cache(KEPT)
def _task(
    world: Source, conditions: Conditions, with_room: bool, observation: str
) -> tuple[Dynamics, int]:
    problem = training_problem(world, conditions)
    initial = problem.seen if conditions.starts else None
    dynamics, rows = make_dynamics(problem.mdp, initial, observation)
    return roomy(dynamics) if with_room else dynamics, rows


@lru_cache(KEPT)
def _values(
    world: Source, conditions: Conditions, intrinsic_reward: str, horizon: int, discount: float
) -> Float[np.ndarray, "S"]:
    weight = float(intrinsic_reward != NO_INTRINSIC)
    config = Config(intrinsic=intrinsic_reward, horizon=horizon, beta=weight)
    config = config.changed(discount=discount)
    table = intrinsic.value_table(training_problem(world, conditions).mdp, config)
    table.flags.writeable = False
    return table
