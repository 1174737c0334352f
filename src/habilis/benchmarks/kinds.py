"""Every kind of empowerment: its time at a documented size, and its gap."""

from collections.abc import Callable
from typing import Any

import numpy as np
from jaxtyping import Float64

from habilis.benchmarks import Result
from habilis.benchmarks.scale import timed
from habilis.empowerment import (
    closed_loop_empowerment,
    effective_empowerment,
    empowerment,
    goal_directed_empowerment,
)
from habilis.mdp import TabularMDP
from habilis.processors import processors
from habilis.worlds.table import tabulate
from habilis.worlds.world import load_world

_PRICED = 20  # states whose curve over budgets is timed
_BUDGETS = (0.0, 0.5, 1.0, 2.0, 3.0)
_LARGE, _LABELS, _WHOLE = 1_000_000, 32, 10_000

Bits = Float64[np.ndarray, "*any"]


def results(large: bool = False) -> list[Result]:
    """Lines of time and gap.

    Args:
        large: whether to measure the largest sizes too, which takes minutes and 2 GiB.
    """
    yard, corridor = tabulate(load_world("yard")), tabulate(load_world("corridor"))
    _compiled()
    return [
        *_effective("object sensor, yard", yard, "object", 0.9),
        *_effective("object sensor, yard", yard, "object", 0.99),
        *_of_lake(2),
        *_goal_directed("corridor", corridor),
        *_goal_directed("yard", yard),
        *_budget(corridor),
        *_each_step(corridor),
        *(_largest() if large else []),
    ]


def _compiled() -> None:
    """Compilation is not what is measured."""
    ring = TabularMDP.deterministic([[(s - 1) % 5, (s + 1) % 5] for s in range(5)])
    effective_empowerment(ring, "uniform", 0.99)
    closed_loop_empowerment(ring.slippery(0.2), 2)
    goal_directed_empowerment(ring, 2, goal=[0], slack=1)
    empowerment(ring, 2, cost=np.ones((5, 2)), budget=3)


def _effective(name: str, mdp: TabularMDP, sensor: Any, discount: float) -> list[Result]:
    size = f"all {mdp.states:,} states, {processors()} threads"
    return _lines(
        f"effective, discount {discount}, {name}",
        lambda: effective_empowerment(mdp, "uniform", discount, sensor, return_gap=True),
        size,
    )


def _of_lake(horizon: int) -> list[Result]:
    """Closed and open loop on ice, so that one sees what looking is worth."""
    import gymnasium

    lake = TabularMDP.from_gymnasium(gymnasium.make("FrozenLake-v1"))
    name, size = f"slippery FrozenLake 4x4, h = {horizon}", f"all {lake.states} states"
    closed = lambda: closed_loop_empowerment(lake, horizon, return_gap=True)  # noqa: E731
    return _lines(f"closed loop, {name}", closed, size)


def _goal_directed(name: str, mdp: TabularMDP) -> list[Result]:
    def measure() -> tuple[Bits, Bits]:
        bits = goal_directed_empowerment(mdp, 6, slack=4, sensor="object")
        return bits, np.zeros_like(bits)

    size = f"all {mdp.states:,} states, slack 4"
    return _lines(f"goal-directed, object sensor, {name}, h = 6", measure, size)


def _budget(mdp: TabularMDP) -> list[Result]:
    cost = np.ones((mdp.states, mdp.action_count))
    cost[:, ::2] = 0.5
    states = np.linspace(0, mdp.states - 1, _PRICED).astype(int)
    budget = 1.5 + np.array(_BUDGETS) / 2  # three of the cheapest cost 1.5
    return _lines(
        f"budget, {len(budget)} of them, full state, corridor, h = 3",
        lambda: empowerment(mdp, 3, states=states, cost=cost, budget=budget, return_gap=True),
        f"{_PRICED} states",
    )


def _each_step(mdp: TabularMDP) -> list[Result]:
    return _lines(
        "each step, object sensor, corridor, h = 4",
        lambda: empowerment(mdp, 4, "object", sensor_at="each step", return_gap=True),
        f"all {mdp.states:,} states",
    )


def _largest() -> list[Result]:
    random = np.random.default_rng(1)
    many = TabularMDP.deterministic(random.integers(_LARGE, size=(_LARGE, 8), dtype=np.int32))
    whole = TabularMDP.deterministic(random.integers(_WHOLE, size=(_WHOLE, 8), dtype=np.int32))
    labels = random.integers(_LABELS, size=_LARGE).astype(np.int32)
    return [
        *_effective(f"{_LABELS} labels, random", many, labels, 0.9),
        *_effective("full state, random", whole, "state", 0.9),
        *_of_lake(3),
    ]


def _lines(name: str, measure: Callable[[], tuple[Bits, Bits]], size: str) -> list[Result]:
    seconds, (_, gap) = timed(measure)
    return [
        Result(name, seconds, "s", size),
        Result("  largest gap", float(gap.max()), "bits", "0: counts"),
    ]
