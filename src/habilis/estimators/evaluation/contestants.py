"""The estimators that come with the package, each set up for any case."""

from collections.abc import Callable
from typing import Any

import numpy as np

from habilis.estimators.actions import ActionBox, checked_actions
from habilis.estimators.counting import Counting
from habilis.estimators.evaluation.case import Case
from habilis.estimators.gaussian import Gaussian
from habilis.estimators.learned.contrastive import Contrastive
from habilis.estimators.learned.variational import Variational
from habilis.estimators.monte_carlo import MonteCarlo
from habilis.estimators.protocol import Estimator, is_finite
from habilis.estimators.samplers import FirstAction, RandomSequences, VarianceProxy

_CELL = 0.1  # of sensors that are numbers


def contestants(quick: bool = False) -> dict[str, Callable[[Case], Estimator]]:
    """The estimators of the package by their names, as `evaluate` takes them.

    Args:
        quick: whether to sample and train a tenth as much.

    Returns:
        Functions of a case.

    Example:
        >>> from habilis.estimators.evaluation.case import suite
        >>> contestants()["counting"](*suite(["maze"]))
        Counting(resolution=1.0, sequences=1000)
    """
    sequences, samples, rounds = (100, 30, 5) if quick else (300, 300, 50)

    def monte_carlo(case: Case) -> Estimator:
        if _cell(case) == 1:
            return MonteCarlo(sequences, samples, outcomes="labels")
        return MonteCarlo(sequences // 6, samples // 3)  # densities take longer than counts

    return {
        "counting": lambda case: Counting(_cell(case), 1000),
        "monte-carlo": monte_carlo,
        "gaussian": lambda case: Gaussian(_power(case), noise=0.0),
        "variational": lambda case: Variational(
            rounds=rounds, samples=400, power=case.power, patience=rounds
        ),
        "contrastive": lambda case: Contrastive(rounds=2 * rounds, samples=256, patience=rounds),
        "variance-proxy": lambda case: VarianceProxy(1000),
        "random-sequences": lambda case: RandomSequences(1000, _cell(case)),
        "first-action": lambda case: FirstAction(10, _cell(case)),
    }


def _cell(case: Case) -> float:
    """The size of the cells that are told apart: 1 where the sensor shows whole numbers."""
    return 1.0 if is_finite(case.simulator) or callable(case.sensor) else _CELL


def _power(case: Case) -> float:
    """The power of the case; where actions are bounded otherwise, that of uniform ones."""
    if case.power is not None:
        return case.power
    actions: Any = checked_actions(case.simulator.actions)
    if isinstance(actions, ActionBox):
        mean_square = ((actions.high - actions.low) ** 2 / 12).sum()
    else:
        mean_square = np.var(actions, axis=0).sum()
    return float(max(case.horizon, 1) * mean_square)
