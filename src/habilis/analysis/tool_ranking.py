"""Which object is the tool: the influence on one object that is lost without another."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float64

from habilis.bridges.puzzles.pushworld import OBJECT, PushWorld, State
from habilis.empowerment.api import empowerment
from habilis.empowerment.arguments import whole_number
from habilis.empowerment.methods import Exact, checked_method
from habilis.models.explore import explore
from habilis.models.limits import MAX_STATES
from habilis.progress import progress_bar

if TYPE_CHECKING:
    import polars as pl

_EXACT = Exact()


def tool_ranking(
    model: PushWorld,
    target: str = "object:m0",
    *,
    horizon: int,
    states: Sequence[State] | None = None,
    method: Exact = _EXACT,
    max_states: int = MAX_STATES,
    show_progress: bool = False,
) -> "pl.DataFrame":
    """How much object empowerment over one movable is lost without each of the others.

    E_h(s) is the h-step object empowerment over the target in state s: log2 of the number of cells
    in which the target can be after exactly h actions. With another movable o,

        lost_removed(o) = mean over s of E_h(s) - E_h(s without o)
        lost_fixed(o)   = mean over s of E_h(s) - E_h(s with o fixed)

    where o is taken off the map, or is turned into walls in the cells that it covers in s;
    everything else is as in s. What the agent needs in order to reach the target is lost in both
    cases. What is in the way is missed only where it is fixed, for then it cannot be pushed aside,
    and its loss where it is removed is negative: the agent gains by that.

    Args:
        model: a puzzle, as `load_pushworld` and `load_sokoban` return it.
        target: the movable acted on, as the factor "object:m0" or as "m0".
        horizon: h, in actions, 0 or more. No state is explored that h actions do not reach.
        states: the states s; by default the puzzle's first alone.
        method: `Exact`, with its settings, as in `empowerment`.
        max_states: how many states to accept in each puzzle, as in `explore`.
        show_progress: whether to draw a progress bar on standard error, once it takes two seconds.

    Returns:
        A Polars data frame with a row for each other movable: `object`, its factor; `bits`, the
        mean of E_h(s), which is the same in all rows; `lost_fixed` and `lost_removed`, in bits.
        The largest `lost_removed` comes first, of equal ones the largest `lost_fixed`, then the
        order of `model.objects`.

    Raises:
        ValueError: the model is not a puzzle, has no such movable or state, the horizon is not a
            whole number from 0 up, or the computation is above max_states, max_gib or max_seconds.

    Example:
        >>> puzzle = PushWorld.parse("A  M1 M0 .  .")
        >>> tool_ranking(puzzle, horizon=2).rows()
        [('object:m1', 1.584962500721156, 1.584962500721156, 0.5849625007211561)]
    """
    if not isinstance(model, PushWorld):
        raise ValueError(
            f"{type(model).__name__} is not a puzzle; give one that load_pushworld or load_sokoban "
            "returns"
        )
    horizon, method = whole_number("horizon", horizon), checked_method(method, [Exact])
    aim = model.objects[model.place(target) - 1]
    asked = [model.initial] if states is None else [model.at(one).initial for one in states]
    if not asked:
        raise ValueError("states is empty; give at least one state")
    others = [name for name in model.objects if name != aim]

    def bits(puzzle: PushWorld, there: Sequence[State]) -> Float64[np.ndarray, "n"]:
        mdp = explore(puzzle, there, horizon, max_states)
        numbers = [mdp.index(state) for state in there]
        return empowerment(mdp, horizon, f"{OBJECT}{aim}", states=numbers, method=method)

    free, lost = bits(model, asked), []
    with progress_bar("objects", show_progress) as report:
        for done, name in enumerate(others):
            place = model.place(name)
            left = [state[:place] + state[place + 1 :] for state in asked]
            removed = bits(model.without(name), left)
            fixed = np.empty(len(asked))
            cells = np.array([state[place] for state in asked])
            for cell in np.unique(cells):
                here = np.flatnonzero(cells == cell).tolist()
                walled = model.fixed(name, asked[here[0]])
                fixed[here] = bits(walled, [left[which] for which in here])
            lost.append((float((free - fixed).mean()), float((free - removed).mean())))
            report(done + 1, len(others))
    order = sorted(range(len(others)), key=lambda which: lost[which][::-1], reverse=True)
    import polars as pl

    return pl.DataFrame(
        {
            "object": [f"{OBJECT}{others[which]}" for which in order],
            "bits": [float(free.mean())] * len(others),
            "lost_fixed": [lost[which][0] for which in order],
            "lost_removed": [lost[which][1] for which in order],
        },
        schema={"object": pl.String}
        | dict.fromkeys(("bits", "lost_fixed", "lost_removed"), pl.Float64),
    )
