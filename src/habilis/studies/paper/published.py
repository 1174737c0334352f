"""The tables as the paper prints them: Rasheed, Polani and Catenacci Volpi (ICDL 2023)."""

from dataclasses import dataclass

FIRST_WORLD, SECOND_WORLD = "corridor-b", "yard-b"
"""The built-in worlds of the two experiments: those that meet most of what the paper states. Its
numbers, statements and figures about the worlds are of them, and nothing else names them."""


@dataclass(frozen=True)
class Row:
    """A row of Table I or II: an agent, and its episodes to convergence over 10 runs."""

    label: str
    tool: str
    intrinsic: str
    horizon: int
    beta: float
    mean: float
    deviation: float

    @property
    def vanilla(self) -> bool:
        return self.beta == 0


@dataclass(frozen=True)
class Experiment:
    """A table: all its agents act in one world.

    Attributes:
        name, title: of the table.
        world: a built-in one.
        targets: the list of what the paper states about it.
        rows: the agents.
    """

    name: str
    title: str
    world: str
    targets: str
    rows: tuple[Row, ...]


EXPERIMENTS = (
    Experiment(
        "table1",
        "Table I",
        FIRST_WORLD,
        "corridor",
        (
            Row("A2C", "picker", "none", 0, 0.0, 37438.0, 3461.7),
            Row("A2C with 5-step FOE", "picker", "state", 5, 0.09, 31003.3, 3803.2),
            Row("A2C with 6-step TOE", "picker", "object", 6, 0.07, 28841.4, 2420.0),
        ),
    ),
    Experiment(
        "table2",
        "Table II",
        SECOND_WORLD,
        "yard",
        (
            Row("A2C (picker)", "picker", "none", 0, 0.0, 15555.4, 418.8),
            Row("A2C with 3-step TOE (picker)", "picker", "object", 3, 0.08, 11672.4, 733.4),
            Row("A2C (broom)", "broom", "none", 0, 0.0, 52872.2, 7742.2),
            Row("A2C with 3-step TOE (broom)", "broom", "object", 3, 0.08, 37657.6, 4885.9),
        ),
    ),
)
RUNS = 10

REWARDS = {"none": "none", "state": "FOE", "object": "TOE"}
"""The paper's names of what is added to the reward, by the sensor of the empowerment."""
