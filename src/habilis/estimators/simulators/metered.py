"""Counting the steps that an estimator makes."""

from typing import Any

from habilis.estimators.protocol import Simulator


class Metered:
    """A simulator that counts its steps; everything else is as the simulator has it.

    A step of n states counts n. Steps that are differentiated (see `Gaussian`) count once.

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
        return getattr(self.simulator, name)
