"""The parts of a study: agents, the cases in which they are compared, and the measures."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib.resources import files
from typing import Any

import polars as pl
from matplotlib.figure import Figure

from habilis.learning.config import NO_INTRINSIC, NOVELTIES, Config
from habilis.sweeps.training import RunMeasure
from habilis.worlds.world import World

HORIZON = 4
"""Of every empowerment. It was fixed after pilots with 3 and 4, and is not searched."""
BETAS = (0.03, 0.1, 0.3)
"""The weights among which that of every bonus is chosen, the same for all of them."""


@dataclass(frozen=True)
class Agent:
    """A learner and its bonus.

    Attributes:
        name: in tables and pictures.
        config: its settings; the weight of a bonus is chosen by `weights.choose`.
    """

    name: str
    config: Config

    @classmethod
    def of(cls, name: str, intrinsic: str = NO_INTRINSIC, algorithm: str = "a2c") -> "Agent":
        """An agent with a learner's own settings, and `HORIZON` where its bonus has one."""
        bonus: dict[str, Any] = {}
        if intrinsic != NO_INTRINSIC:
            horizon = 0 if intrinsic in NOVELTIES else HORIZON
            bonus = {"intrinsic": intrinsic, "beta": BETAS[0], "horizon": horizon}
        return cls(name, Config().changed(algorithm=algorithm, **bonus))

    @property
    def has_bonus(self) -> bool:
        return self.config.intrinsic != NO_INTRINSIC


@dataclass(frozen=True, eq=False)
class Case:
    """A world and its settings, in which agents are compared.

    Attributes:
        name: in tables and pictures.
        world: what they learn in.
        settings: fields of `Config` that all agents have there.
    """

    name: str
    world: World
    settings: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Measure:
    """A number of each run.

    Attributes:
        column: in the table of runs; null where a run exceeded its budget.
        title: in words.
        counts: whether it counts episodes, of which fewer are better, rather than being a share,
            of which more is better.
    """

    column: str
    title: str
    counts: bool


CONVERGENCE = Measure("converged_at", "episodes to convergence", True)
FIRST_SUCCESS = Measure("first_success", "episodes to first success", True)


@dataclass(frozen=True)
class Budget:
    """The amount of training.

    Attributes:
        runs: of every agent in every case.
        tried: of every weight of every bonus, with other random numbers, to choose among them.
        most: steps of the environment at most, whatever the study asks for.
        betas: the weights that are tried.
    """

    runs: int
    tried: int
    most: int
    betas: tuple[float, ...] = BETAS


FULL = Budget(runs=10, tried=3, most=10**9)
QUICK = Budget(runs=2, tried=1, most=20_000, betas=BETAS[:1])


@dataclass(frozen=True, eq=False)
class Study:
    """A question, and how it is answered.

    Attributes:
        name: on the command line.
        title, question: of its section of the report.
        cases: where agents are compared.
        agents: which are.
        pairs: the contrasts, each an agent's name and another's.
        measures: what its table has; the first one decides, also among weights.
        measure_run: measurements of a run besides episodes to first success and convergence.
        figure: its picture, from `analysis.summary` and the table of runs.
        caption: under it.
        steps: the budget of a run, in environment steps.
    """

    name: str
    title: str
    question: str
    cases: tuple[Case, ...]
    agents: tuple[Agent, ...]
    pairs: tuple[tuple[str, str], ...]
    measures: tuple[Measure, ...]
    measure_run: RunMeasure
    figure: Callable[[pl.DataFrame, pl.DataFrame], Figure]
    caption: str
    steps: int


def world_of(name: str) -> World:
    """A map of the studies, by the name of its file without the ending."""
    text = (files("habilis.studies.bonuses") / "worlds" / f"{name}.txt").read_text("utf-8")
    return World.parse(text, name)
