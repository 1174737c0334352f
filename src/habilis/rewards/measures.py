"""Measures of states that a reward may name: a kind of empowerment, and a sensor."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float64
from numpy.typing import ArrayLike

from habilis.cache import fingerprint, kept
from habilis.empowerment.kinds import CLOSED_LOOP, EFFECTIVE, GOAL_DIRECTED, OPEN_LOOP, of_kind
from habilis.empowerment.methods import Exact, Method
from habilis.empowerment.sensors import Sensor, observation_probabilities
from habilis.mdp import TabularMDP
from habilis.rewards.cached_tables import kept_empowerment

Policy = ArrayLike | Callable[[TabularMDP], ArrayLike]
"""float[S, A] for one table, or a function that gives it for each."""

_EDITION = 1  # of the values: to be raised when they become others
_EXACT = Exact()
_NAMED = (EFFECTIVE, CLOSED_LOOP, GOAL_DIRECTED)


class Named(NamedTuple):
    """A kind of empowerment and the sensor through which it is measured."""

    kind: str
    sensor: Sensor

    @classmethod
    def of(cls, sensor: Sensor) -> "Named":
        """What a name says: "effective:object" a kind and a sensor, else open-loop empowerment.

        Example:
            >>> Named.of("effective:object:can")
            Named(kind='effective', sensor='object:can')
            >>> Named.of("object:can").kind
            'open-loop'
        """
        if isinstance(sensor, str):
            kind, _, rest = sensor.partition(":")
            if kind.strip() in _NAMED and rest:
                return cls(kind.strip(), rest.strip())
        return cls(OPEN_LOOP, sensor)

    @property
    def has_horizon(self) -> bool:
        return self.kind != EFFECTIVE


def measured(
    mdp: TabularMDP,
    horizon: int,
    sensor: Sensor,
    discount: float,
    actions: ArrayLike | None = None,
    method: Method = _EXACT,
) -> Float64[np.ndarray, "S"]:
    """The measure of every state, in bits; the second time from the disk.

    Args:
        mdp: the table.
        horizon: in actions; effective empowerment has none, and takes 0.
        sensor: as in `empowerment`, or a name with a kind: "effective:object", under the uniform
            policy, "closed-loop:object", or "goal-directed:object", towards the terminal states.
        discount: of the agent, which effective empowerment shares.
        actions, method: as in `empowerment`.

    Raises:
        ValueError: as in the kind's function; or effective empowerment with a horizon.
    """
    named = Named.of(sensor)
    if named.kind == OPEN_LOOP:
        return kept_empowerment(mdp, horizon, sensor, actions, method=method)
    if not named.has_horizon and horizon:
        raise ValueError(f"horizon is {horizon} and sensor {sensor!r}, which has none; give 0")
    options: Any = {"method": method}
    shared = discount if named.kind == EFFECTIVE else None
    kind, one = named

    def compute() -> dict[str, np.ndarray]:
        values, _ = of_kind(kind, mdp, horizon, one, actions, None, shared, None, options)
        return {"values": values}

    seen = observation_probabilities(mdp, one)
    what = (kind, _EDITION, horizon, mdp.transitions, mdp.terminal, seen, shared, repr(method))
    name = fingerprint(*what, None if actions is None else np.asarray(actions).tolist())
    return kept(name, compute)["values"]


def under_policy(
    mdp: TabularMDP, sensor: Sensor, discount: float, policy: Policy, tolerance: float
) -> Float64[np.ndarray, "S"]:
    """Effective empowerment of every state under a policy that is not uniform, in bits.

    Args:
        mdp: the table.
        sensor: a name such as "effective:object".
        discount: of the agent.
        policy: of this table, or a function that gives it.
        tolerance: the gap to reach, in bits.

    Raises:
        ValueError: a sensor of another kind, or as in `effective_empowerment`.
    """
    from habilis.empowerment.effective import effective_empowerment

    kind, one = Named.of(sensor)
    if kind != EFFECTIVE:
        raise ValueError(
            f"sensor is {sensor!r}, which no policy changes; give an effective empowerment, such "
            "as 'effective:object'"
        )
    chosen = policy(mdp) if callable(policy) else policy
    return effective_empowerment(mdp, chosen, discount, one, tolerance=tolerance)
