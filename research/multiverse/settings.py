"""The conditions: every combination of the choices that a researcher has."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from habilis import worlds
from habilis.learning.config import Config
from habilis.studies.maps import MAPS
from habilis.studies.paper.published import EXPERIMENTS
from habilis.studies.paper.settings import frozen_settings

BUILTIN = Path(worlds.__file__).parent / "builtin"

BETAS = (0.04, 0.08, 0.15, 0.3)
HORIZONS = (1, 3, 6, 8)
RUNS, SEED = 10, 4001

_SHORTER = {"entropy_hold": 600_000, "entropy_steps": 600_000}

LEARNERS: dict[str, dict[str, Any]] = {
    "A2C": {"steps": 1_500_000} | _SHORTER,
    "A2C, constant entropy": {"steps": 1_500_000, "entropy_end": 0.02},
    "A2C, RMSprop, full reward": {
        "steps": 2_000_000,
        "optimizer": "rmsprop",
        "learning_rate": 2e-3,
        "reward_scale": 1.0,
        "envs": 8,
        "rollout": 20,
        "entropy_end": 0.02,
    },
    "PPO": {
        "algorithm": "ppo",
        "steps": 800_000,
        "envs": 16,
        "rollout": 32,
        "normalise": False,
        "entropy_end": 0.0,
        "entropy_hold": 300_000,
        "entropy_steps": 300_000,
    },
    "Q-learning": {
        "algorithm": "q-learning",
        "steps": 600_000,
        "learning_rate": 0.5,
        "epsilon": 0.1,
        "epsilon_end": 0.002,
        "epsilon_steps": 200_000,
    },
}
"""Training choices, by the names that figures show: changes to the settings of the tables, or to an
algorithm's defaults, and the budget of a run in environment steps. With A2C, entropy falls sooner
than in the tables, which changes little for vanilla agents, but takes a quarter of the time where a
bonus makes steps cheap. RMSprop on the full reward is the slowest learner here, and
came closest to the published counts of vanilla agents in the corridor."""


@dataclass(frozen=True)
class Condition:
    """One experimental condition, trained ten times.

    Attributes:
        part: of the study: "multiverse", "maps" or "shaping".
        learner: of `LEARNERS`.
        map: name of the world.
        tool: in it.
        reward: "none", "FOE" or "TOE".
        horizon, beta: of that reward; 0 for "none".
        how: how the bonus is given: "plain", or a name of `SHAPINGS`.
        config: what is trained.
    """

    part: str
    learner: str
    map: str
    tool: str
    reward: str
    horizon: int
    beta: float
    how: str
    config: Config


SHAPINGS: dict[str, dict[str, Any]] = {
    "plain": {},
    "potential": {"earned": "difference"},
    "linear decay": {"beta_schedule": "linear", "beta_steps": 300_000},
    "halving": {"beta_schedule": "exponential", "beta_steps": 100_000},
}
SENSORS = {"none": "none", "FOE": "state", "TOE": "object"}
WORLDS = (
    ("corridor", "picker", ("FOE", "TOE")),
    ("yard", "picker", ("TOE",)),
    ("yard", "broom", ("TOE",)),
)
"""Each world and tool of the paper, and with which rewards it is learned. These are the first two
worlds that were found, and `FOUND` how many others there were of each: what was trained is checked
in, and stays of these, whichever pair the reproduction uses now."""
FOUND = {"corridor": 8, "yard": 6}


def agents(maps: dict[str, Path]) -> list[Condition]:
    """All agents of the second part: the multiverse, the other maps, the shapings.

    Args:
        maps: other maps by name, such as "corridor-01"; they play the part of the world whose
            name they begin with.
    """
    return [*_multiverse(), *_on_maps(maps), *_shapings()]


def _multiverse() -> Iterator[Condition]:
    for learner in LEARNERS:
        for world, tool, rewards in WORLDS:
            yield _agent("multiverse", learner, world, tool)
            for reward in rewards:
                for horizon in HORIZONS:
                    for beta in BETAS:
                        yield _agent("multiverse", learner, world, tool, reward, horizon, beta)


def _on_maps(maps: dict[str, Path]) -> Iterator[Condition]:
    """The rows of the paper's tables, each on every map of its world."""
    for name, path in maps.items():
        for world, tool, reward, horizon, beta in paper_rows():
            if name.startswith(world):
                yield _agent("maps", "A2C", name, tool, reward, horizon, beta, path=path)


def _shapings() -> Iterator[Condition]:
    """The rows of the paper's tables, at its beta and at one that harms, given in each way."""
    for world, tool, reward, horizon, beta in paper_rows():
        if reward == "none":
            yield _agent("shaping", "A2C", world, tool)
            continue
        for weight in (beta, 0.3):
            for how in SHAPINGS:
                yield _agent("shaping", "A2C", world, tool, reward, horizon, weight, how)


def paper_rows() -> Iterator[tuple[str, str, str, int, float]]:
    """World, tool, reward, horizon and beta of every row of the paper's tables."""
    names = {sensor: reward for reward, sensor in SENSORS.items()}
    for experiment, world in zip(EXPERIMENTS, FOUND, strict=True):
        for row in experiment.rows:
            yield world, row.tool, names[row.intrinsic], row.horizon, row.beta


def _agent(
    part: str,
    learner: str,
    world: str,
    tool: str,
    reward: str = "none",
    horizon: int = 0,
    beta: float = 0.0,
    how: str = "plain",
    path: Path | None = None,
) -> Condition:
    config = Config.from_dict(frozen_settings()).changed(**LEARNERS[learner])
    config = config.changed(
        world=world if path is None else str(path),
        tool=tool,
        intrinsic=SENSORS[reward],
        horizon=horizon,
        beta=beta,
        **SHAPINGS[how],
        runs=RUNS,
        seed=SEED,
        episodes=1_000_000,
    )
    return Condition(part, learner, world, tool, reward, horizon, beta, how, config)


def all_maps() -> dict[str, Path]:
    """The built-in worlds and the reconstructions that are trained on, by name."""
    names = [f"{world}-{n:02}" for world, count in FOUND.items() for n in range(1, count + 1)]
    found = {name: MAPS / f"{name}.txt" for name in names}
    return {world: BUILTIN / f"{world}.txt" for world, *_ in WORLDS} | found
