"""Estimators compared with known values in independent tasks: one seed, one case, one estimator."""

import pickle
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, is_dataclass
from functools import cached_property
from typing import Any

import numpy as np

from habilis.cache import fingerprint, table_digest
from habilis.estimators.evaluation.case import Case
from habilis.estimators.evaluation.estimates import Contestant, Estimates, estimated, set_up
from habilis.estimators.simulators.finite import FiniteSimulator
from habilis.extras import import_from
from habilis.own_code import FILE
from habilis.tasks.shared import Shared
from habilis.tasks.task import Arrays

_EDITION = 2  # of the results, which are kept
_WITHOUT_EFFECT = "folder", "show_progress"


@dataclass(frozen=True)
class Carried:
    """What plain pickles may not carry: functions within functions, and classes of one's own files.

    Attributes:
        content: a pickle.
    """

    content: bytes

    @classmethod
    def of(cls, value: Any) -> "Carried":
        """A value, with the code of classes that a file of one's own has.

        Raises:
            ValueError: it cannot be pickled.
            MissingExtraError: it takes cloudpickle, which is not installed.
        """
        module = sys.modules.get(type(value).__module__)
        if module is None or not module.__name__.endswith(FILE):
            try:
                return cls(pickle.dumps(value))
            except (AttributeError, TypeError, pickle.PicklingError):
                module = None
        cloudpickle = import_from("cloudpickle", "gymnasium")
        if module is not None:
            cloudpickle.register_pickle_by_value(module)
        try:
            return cls(cloudpickle.dumps(value))
        except (AttributeError, TypeError, pickle.PicklingError) as error:
            raise ValueError(
                f"{type(value).__name__} cannot be carried to another process ({error}); leave out "
                "executor, or let it be pickled"
            ) from None

    @cached_property
    def value(self) -> Any:
        return pickle.loads(self.content)

    def __getstate__(self) -> dict[str, Any]:
        """For pickles: without what was read of it."""
        return {"content": self.content}


@dataclass(frozen=True)
class EstimateTask:
    """The estimates of one seed (a `habilis.tasks.task.Task`).

    Attributes:
        name: a hash of estimator, case and seed.
        label: their names.
        size: of the simulator's table, if it has one.
        estimator: what is fitted.
        case: what it is evaluated on.
        seed: of the fit.
    """

    name: str
    label: str
    size: float
    estimator: Carried
    case: Shared[Carried]
    seed: int

    def run(self) -> Arrays:
        """See `Estimates.as_arrays`."""
        found = estimated(self.estimator.value, self.case.value.value, self.seed)
        return found.as_arrays()

    def rehearse(self) -> None:
        """Fits and estimates it all."""
        self.run()

    def check(self, result: Arrays) -> None:
        Estimates.of_arrays(result)


def tasks_of(
    name: str, contestant: Contestant, case: Case, seeds: Sequence[int]
) -> list[EstimateTask]:
    """The tasks of an estimator and a case, one a seed.

    Raises:
        ValueError, MissingExtraError: it cannot be set up for this case.
    """
    estimator = set_up(contestant, case)
    carried, shared = Carried.of(estimator), Shared(_identity(case), Carried.of(case))
    settings = [*_settings(estimator)]
    size = case.simulator.mdp.states if isinstance(case.simulator, FiniteSimulator) else 0
    return [
        EstimateTask(
            fingerprint(_EDITION, shared.key, seed, *settings)[:32],
            f"{name}, {case.name}, seed {seed}",
            float(size),
            carried,
            shared,
            seed,
        )
        for seed in seeds
    ]


def _settings(value: Any) -> Iterator[Any]:
    """All that an estimator's results depend on, arrays whole, for a hash."""
    if is_dataclass(value) and type(value).__module__.startswith("habilis."):
        yield type(value).__name__
        for one in fields(value):
            if one.name not in _WITHOUT_EFFECT:
                yield one.name
                yield from _settings(getattr(value, one.name))
    elif isinstance(value, list | tuple):
        yield len(value)
        for one in value:
            yield from _settings(one)
    elif value is None or isinstance(value, np.ndarray | np.generic | str | int | float):
        yield value
    else:
        yield Carried.of(value).content


def _identity(case: Case) -> str:
    """A hash of all of a case."""
    simulator: Any = case.simulator
    if isinstance(simulator, FiniteSimulator):
        world = table_digest(simulator.mdp)
    else:
        world = Carried.of(simulator).content
    sensor = case.sensor if isinstance(case.sensor, str) else Carried.of(case.sensor).content
    asked = case.name, case.horizon, case.target, case.power, sensor
    values = (np.asarray(one) for one in (case.states, case.bits, case.error))
    return fingerprint(*asked, world, *values)
