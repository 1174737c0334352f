"""The kinds of empowerment by name, for measures that are made of any of them."""

from typing import Any

import numpy as np
from jaxtyping import Float64
from numpy.typing import ArrayLike

from habilis.empowerment.api import Options, empowerment
from habilis.empowerment.arguments import per_bit
from habilis.empowerment.methods import Exact
from habilis.empowerment.sensors import Sensor
from habilis.mdp import TabularMDP

OPEN_LOOP, EFFECTIVE, CLOSED_LOOP, GOAL_DIRECTED = KINDS = (
    "open-loop",
    "effective",
    "closed-loop",
    "goal-directed",
)
WHOLE = (EFFECTIVE, GOAL_DIRECTED)
"""What looks farther ahead than the horizon, and so needs a whole table."""


def checked_kind(kind: str, discount: float | None, slack: int | None) -> str:
    """A kind's name, with none but its own settings.

    Raises:
        ValueError: there is no such kind, or it lacks a setting or has one of another.
    """
    if kind not in KINDS:
        raise ValueError(f"kind is {kind!r}; use one of {', '.join(KINDS)}")
    if (discount is None) == (kind == EFFECTIVE):
        fix = "give discount=" if kind == EFFECTIVE else "leave out discount"
        raise ValueError(f"discount is {discount} and kind {kind!r}; {fix}")
    if slack is not None and kind != GOAL_DIRECTED:
        raise ValueError(f"slack is {slack} and kind {kind!r}, which has none; leave it out")
    return kind


def named(kind: str, horizon: int, discount: float | None) -> str:
    """A kind in words, with what it looks ahead by."""
    if kind == EFFECTIVE:
        return f"effective empowerment, discount {discount:g}"
    return f"{horizon}-step {'' if kind == OPEN_LOOP else kind + ' '}empowerment"


def of_kind(
    kind: str,
    mdp: TabularMDP,
    horizon: int,
    sensor: Sensor,
    actions: ArrayLike | None,
    states: Any,
    discount: float | None,
    slack: int | None,
    options: Options,
    against: tuple[str, str] | None = None,
) -> tuple[Float64[np.ndarray, "n"], Float64[np.ndarray, "n"]]:
    """Values of a kind, and their gaps; see the function of each.

    Effective empowerment is that of the uniform policy, and has no horizon. Of a table of several
    players `against` is a player, and whether the others do their "best" or their "worst".

    Returns:
        In the unit of `options`; gaps are 0 where values are counts.

    Raises:
        ValueError: as there; or the kind does not know an option.
    """
    if kind == OPEN_LOOP:
        player, others = against or (None, None)
        some: Any = {"player": player, "others": others, **options}
        return empowerment(mdp, horizon, sensor, actions, states, return_gap=True, **some)
    if against is not None:
        raise ValueError(f"others is {against[1]!r} and kind {kind!r}; give the others a policy")
    if options.get("executor") is not None:
        raise ValueError(f"kind {kind!r} is of all states at once; leave out executor")
    method, unit = options.get("method", Exact()), options.get("unit", "bits")
    show = options.get("show_progress", False)
    if not isinstance(method, Exact):
        raise ValueError(f"kind {kind!r} has no method but Exact; leave out method")
    if kind == CLOSED_LOOP:
        from habilis.empowerment.closed_loop import closed_loop_empowerment

        return closed_loop_empowerment(
            *(mdp, horizon, sensor, states),
            return_gap=True,
            actions=actions,
            tolerance=method.tolerance,
            unit=unit,
            show_progress=show,
        )
    if actions is not None:
        raise ValueError(f"kind {kind!r} is over all actions; leave out actions")
    if kind == EFFECTIVE:
        from habilis.empowerment.effective import effective_empowerment

        assert discount is not None, "`checked_kind` has seen to it"
        return effective_empowerment(
            *(mdp, "uniform", discount, sensor, states),
            tolerance=method.tolerance,
            return_gap=True,
            unit=unit,
            show_progress=show,
        )
    from habilis.empowerment.goal_directed import goal_directed_empowerment

    bits = goal_directed_empowerment(
        *(mdp, horizon, None, slack or 0, sensor, states), method=method, show_progress=show
    )
    return bits * per_bit(unit), np.zeros(len(bits))
