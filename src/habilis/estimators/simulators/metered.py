"""Counting the steps that an estimator makes."""

import sys
from collections.abc import Callable
from typing import Any

import numpy as np

from habilis.estimators.protocol import Simulator


class Metered:
    """A simulator that counts its steps; everything else is as the simulator has it.

    A step of n states counts n, whether Habilis or the estimator makes it; so do `transition` and,
    for each action, `rollout`. Steps that are differentiated (see `Gaussian`) count once. Those
    that an estimator compiles itself cannot be seen: it reports them with `report_steps`.

    Attributes:
        simulator: the one inside.
        steps: how many have been made.

    Example:
        >>> from habilis import TabularMDP
        >>> from habilis.estimators import Counting
        >>> from habilis.estimators.simulators import FiniteSimulator
        >>> metered = Metered(FiniteSimulator(TabularMDP.deterministic([[0, 1], [0, 1]])))
        >>> Counting().fit(metered, 1).bits([[0.0]]), metered.steps
        (array([1.]), 2)
    """

    def __init__(self, simulator: Simulator):
        """
        Args:
            simulator: any.
        """
        self.simulator = simulator
        self.steps = 0

    @property
    def actions(self) -> Any:
        """Those of the simulator."""
        return self.simulator.actions

    def step(self, states: Any, actions: Any, key: Any) -> Any:
        """As the simulator.

        Args:
            states, actions, key: see `Simulator`.

        Returns:
            The next states.
        """
        self._count(states, 1)
        return self.simulator.step(states, actions, key)

    def report_steps(self, steps: int) -> None:
        """Adds to the count.

        Args:
            steps: how many were made.
        """
        self.steps += steps

    def __getattr__(self, name: str) -> Any:
        if name == "simulator":  # not there yet, as in a copy that is being made
            raise AttributeError(name)
        found = getattr(self.simulator, name)
        if name == "transition":
            return self._counted(found, lambda actions: 1)
        if name == "rollout":
            return self._counted(found, lambda sequences: np.shape(sequences)[1])
        return found

    def _counted(self, function: Callable[..., Any], each: Callable[[Any], int]) -> Any:
        def counting(states: Any, actions: Any, *rest: Any, **named: Any) -> Any:
            self._count(states, each(actions))
            return function(states, actions, *rest, **named)

        return counting

    def _count(self, states: Any, each: int) -> None:
        jax: Any = sys.modules.get("jax")
        if jax is None or not isinstance(states, jax.core.Tracer):
            self.steps += len(states) * each


def unmetered(simulator: Simulator) -> Simulator:
    """The simulator inside, for those who report their steps in one go."""
    return simulator.simulator if isinstance(simulator, Metered) else simulator
