"""The estimates of one fit of an estimator for a case."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64

from habilis.estimators.evaluation.case import Case
from habilis.estimators.protocol import Estimator, is_estimator
from habilis.estimators.simulators.metered import Metered
from habilis.extras import MissingExtraError
from habilis.tasks.task import Arrays

Contestant = Estimator | Callable[[Case], Estimator]
"""An estimator, or a function that sets one up for a case."""

REFUSALS = (ValueError, MissingExtraError, FloatingPointError)
"""Errors by which an estimator says that it cannot, or fails to, estimate a case."""


@dataclass(frozen=True)
class Estimates:
    """The estimates of a fit, or why there are none.

    Attributes:
        kind: the estimator's.
        bits: float64[n].
        seconds: of the fit and of all values.
        steps: of the simulator.
        reason: why there are none; "" where there are.
    """

    kind: str = ""
    bits: Float64[np.ndarray, "n"] | None = None
    seconds: float = 0.0
    steps: int = 0
    reason: str = ""

    def as_arrays(self) -> Arrays:
        """The same as arrays by name, for files."""
        bits = np.empty(0) if self.bits is None else self.bits
        numbers = {"seconds": self.seconds, "steps": self.steps, "kind": self.kind}
        rest = {**numbers, "reason": self.reason}
        return {"bits": bits} | {name: np.array(value) for name, value in rest.items()}

    @classmethod
    def of_arrays(cls, arrays: Arrays) -> "Estimates":
        """The estimates that `as_arrays` made them of.

        Raises:
            ValueError, KeyError, TypeError: they are no such arrays.
        """
        kind, reason = (str(arrays[name]) for name in ("kind", "reason"))
        seconds, steps = float(arrays["seconds"]), int(arrays["steps"])
        if arrays["bits"].dtype != np.float64:
            raise ValueError(f"bits is {arrays['bits'].dtype}")
        return cls(kind, None if reason else arrays["bits"], seconds, steps, reason)


def set_up(contestant: Contestant, case: Case) -> Any:
    """The estimator for a case."""
    return contestant if is_estimator(contestant) else contestant(case)  # pyright: ignore[reportCallIssue]


def refused(error: Exception) -> Estimates:
    """No estimates, for the reason that an error gives."""
    return Estimates(reason=str(error).partition("\n")[0] or type(error).__name__)


def estimated(contestant: Contestant, case: Case, seed: int) -> Estimates:
    """The estimates of one seed."""
    try:
        return _estimated(set_up(contestant, case), case, seed)
    except REFUSALS as error:
        return refused(error)


def _estimated(estimator: Any, case: Case, seed: int) -> Estimates:
    metered = Metered(case.simulator)
    start = time.perf_counter()
    fitted = estimator.fit(metered, case.horizon, case.sensor, seed=seed)
    if fitted.target != case.target:
        names = {"capacity": "the capacity", "effective": "effective empowerment"}
        raise ValueError(f"estimates {names[fitted.target]}, the case is {names[case.target]}")
    bits = np.asarray(fitted.bits(case.states), np.float64)
    seconds = time.perf_counter() - start
    if bits.shape != case.bits.shape:
        raise ValueError(f"gives bits of shape {bits.shape} for {len(case.states)} states")
    if not np.isfinite(bits).all():
        raise ValueError("gives bits that are not finite")
    return Estimates(fitted.kind, bits, seconds, metered.steps)
