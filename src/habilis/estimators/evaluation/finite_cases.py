"""Cases that are tables: a maze, worlds with tools, FrozenLake, channels, effective values."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from habilis.cache import fingerprint, kept, table_digest
from habilis.empowerment.api import empowerment
from habilis.empowerment.effective import effective_empowerment
from habilis.estimators.evaluation.case import Case, spread
from habilis.estimators.protocol import Target
from habilis.estimators.simulators.finite import FiniteSimulator
from habilis.mdp import TabularMDP
from habilis.worlds.grid import STEPS
from habilis.worlds.table import tabulate
from habilis.worlds.world import load_world

_ASKED = 32  # states of a large table
_LOOKED_AT = 300  # among which these are chosen

# The walls of Klyubin, Polani and Nehaniv (2005) as public code has them: two characters a cell,
# "_" for a wall below it and "|" for one to its right.
_MAZE = (
    "......_.............",
    ".......|_...........",
    "........_|..........",
    "...._._._|..........",
    "....................",
    "............_.......",
    "...........|.|......",
    "_._._._._._|.|_._...",
    "....................",
    "....................",
)

_LAKE = ("SFFF", "FHFH", "FFFH", "HFFG")  # of Gymnasium's FrozenLake-v1


def maze() -> TabularMDP:
    """Klyubin's maze: 10 by 10 cells with walls between them, 4 moves and one that stays.

    Returns:
        A deterministic table with the factor "agent".
    """
    size = len(_MAZE)
    table = np.arange(size * size)[:, None].repeat(5, axis=1)
    for cell in range(size * size):
        row, column = divmod(cell, size)
        for action, (down, right) in enumerate(STEPS):
            there = row + down, column + right
            if all(0 <= place < size for place in there) and not _walled((row, column), there):
                table[cell, action] = there[0] * size + there[1]
    return _on_grid(TabularMDP.deterministic(table), size)


def _walled(cell: tuple[int, int], other: tuple[int, int]) -> bool:
    (row, column), (down, _) = min(cell, other), max(cell, other)
    below = down > row
    return _MAZE[row][2 * column + (0 if below else 1)] == ("_" if below else "|")


def frozen_lake() -> TabularMDP:
    """Gymnasium's slippery FrozenLake-v1, whose holes and goal are left by no action.

    Returns:
        A stochastic table with the factor "agent": each move leads where it should, to the left or
        to the right of that with probability 1/3 each.
    """
    size = len(_LAKE)
    west_south_east_north = [STEPS[3], STEPS[2], STEPS[1], STEPS[0]]
    P = np.zeros((4, size * size, size * size))
    for cell in range(size * size):
        row, column = divmod(cell, size)
        for action in range(4):
            for turned in (action - 1, action, action + 1):
                down, right = west_south_east_north[turned % 4]
                if _LAKE[row][column] in "HG":
                    down, right = 0, 0
                there = np.clip([row + down, column + right], 0, size - 1)
                P[action, cell, there[0] * size + there[1]] += 1 / 3
    return _on_grid(TabularMDP.stochastic(P, axes="ASS"), size)


def channels(inputs: int, outputs: int, seed: int = 0) -> TabularMDP:
    """One step of a table as a noisy channel in each state, from noiseless to mostly noise.

    Args:
        inputs: actions.
        outputs: states; each is the start of a channel too.
        seed: of the channels.

    Returns:
        A stochastic table.
    """
    generator = np.random.default_rng(seed)
    meant = generator.permuted(
        np.arange(max(inputs, outputs))[None].repeat(outputs, axis=0) % outputs, axis=1
    )
    noise = generator.dirichlet(np.full(outputs, 0.2), (inputs, outputs))
    share = np.linspace(0, 0.9, outputs)[:, None]
    P = share * noise
    for action in range(inputs):
        P[action, np.arange(outputs), meant[:, action]] += 1 - share[:, 0]
    return TabularMDP.stochastic(P, axes="ASS")


def binary_channels() -> TabularMDP:
    """Binary symmetric channels with crossover probabilities 0, 0.05 ... 0.5.

    Returns:
        A stochastic table of 11 states and 2 actions, which lead to the states 0 and 1.
    """
    crossover = np.linspace(0, 0.5, 11)
    P = np.zeros((2, 11, 11))
    P[0, :, 0], P[0, :, 1] = 1 - crossover, crossover
    P[1, :, 0], P[1, :, 1] = crossover, 1 - crossover
    return TabularMDP.stochastic(P, axes="ASS")


def _on_grid(mdp: TabularMDP, size: int) -> TabularMDP:
    cells = np.arange(mdp.states, dtype=np.int32)
    return replace(mdp, factors={"agent": cells}, shape=(size, size))


def _world(name: str, slip: float = 0.0) -> TabularMDP:
    return tabulate(load_world(name), slip)


def _case(
    mdp: TabularMDP,
    horizon: int,
    sensor: str,
    about: str,
    target: Target = "capacity",
) -> Callable[[str], Case]:
    """A case of a table, at all of its states or, where they are many, at some whose values are
    spread from the least to the largest.
    """

    def truth(states: Any) -> tuple[np.ndarray, np.ndarray]:
        if target == "effective":
            some = mdp, "uniform", 0.0, sensor, states, horizon
            return effective_empowerment(*some, return_gap=True)
        return empowerment(mdp, horizon, sensor, states=states, return_gap=True)

    def make(name: str) -> Case:
        def compute() -> dict[str, np.ndarray]:
            states, (bits, error) = _spread_states(mdp, truth)
            return {"states": states, "bits": bits, "error": error}

        key = fingerprint("suite", table_digest(mdp), horizon, sensor, target, _ASKED, _LOOKED_AT)
        found = kept(f"suite-{key[:32]}", compute)
        states = found["states"].astype(np.float64)[:, None]
        simulator = FiniteSimulator(mdp)
        truths = found["bits"], found["error"]
        return Case(name, simulator, horizon, sensor, states, *truths, target, None, about)

    return make


def _spread_states(mdp: TabularMDP, truth: Any) -> tuple[np.ndarray, Any]:
    if mdp.states <= 100:
        every = np.arange(mdp.states)
        return every, truth(every)
    some = np.flatnonzero(mdp.flags["equipped"]) if "equipped" in mdp.flags else mdp.states
    some = np.sort(np.random.default_rng(0).choice(some, _LOOKED_AT, replace=False))
    bits, error = truth(some)
    chosen = spread(bits, _ASKED)
    return some[chosen], (bits[chosen], error[chosen])


def _later(make: Callable[[], Callable[[str], Case]]) -> Callable[[str], Case]:
    return lambda name: make()(name)


MAKERS: dict[str, Callable[[str], Case]] = {
    "maze": _later(lambda: _case(maze(), 5, "state", "Klyubin's maze, no noise")),
    "maze-10": _later(lambda: _case(maze(), 10, "state", "10^7 sequences, no noise")),
    "yard": _later(lambda: _case(_world("yard"), 3, "state", "tool in hand, full state")),
    "yard-object": _later(lambda: _case(_world("yard"), 4, "object", "tool in hand, the object")),
    "corridor-object": _later(
        lambda: _case(_world("corridor"), 5, "object", "32,768 sequences, most change nothing")
    ),
    "maze-slips": _later(lambda: _case(maze().slippery(0.2), 2, "state", "slip 0.2")),
    "yard-slips": _later(lambda: _case(_world("yard", 0.2), 2, "state", "slip 0.2, full state")),
    "yard-slips-object": _later(
        lambda: _case(_world("yard", 0.2), 3, "object", "slip 0.2, the object")
    ),
    "frozen-lake": _later(lambda: _case(frozen_lake(), 3, "state", "Gymnasium's, slippery")),
    "channels-2": _later(lambda: _case(binary_channels(), 1, "state", "binary symmetric channels")),
    "channels-16": _later(lambda: _case(channels(16, 16), 1, "state", "16 inputs, 16 outputs")),
    "channels-256": _later(lambda: _case(channels(256, 64), 1, "state", "256 inputs, 64 outputs")),
    "maze-effective": _later(
        lambda: _case(maze().slippery(0.2), 3, "state", "slip 0.2, first of 3", "effective")
    ),
    "lake-effective": _later(
        lambda: _case(frozen_lake(), 2, "state", "slippery, first of 2", "effective")
    ),
    "yard-effective": _later(
        lambda: _case(_world("yard"), 3, "object", "the object, first of 3", "effective")
    ),
    "choices-effective": _later(
        lambda: _case(channels(64, 64), 1, "state", "up to 6 bits of one action", "effective")
    ),
}
"""Each by its name."""
