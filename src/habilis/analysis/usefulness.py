"""Whether a tool is of use, state by state and on average (section III-B.3 of the paper)."""

from dataclasses import dataclass
from typing import Any, Unpack

import numpy as np
from jaxtyping import Bool, Float64, Int64

from habilis.analysis.averages import NOTHING, compared_states, held
from habilis.empowerment.api import Options, empowerment
from habilis.empowerment.old_keywords import takes_old_keywords
from habilis.mdp import TabularMDP
from habilis.reprs import counted, short, unfailing
from habilis.worlds.table import tabulate
from habilis.worlds.world import NO_TOOL, World

Values = float | Float64[np.ndarray, "n"]


@dataclass(frozen=True)
class Usefulness:
    """The object empowerment of an agent with its tool in hand, and of the bare agent.

    Values are in the unit asked for, over the n states with the tool in hand. They are lower bounds
    that a certificate completes, so that a difference counts only where it is larger than the gap.

    Attributes:
        states: int64[n], in the table of the world with the tool.
        with_tool: float64[n], the tool's object empowerment E_TO.
        without: float64[n], the agent's object empowerment E_AO, agent and object in the same
            cells and no tool in the world.
        useful: bool[n], `E_TO > 0`: with the tool the agent can do something to the object.
        better_than_none: bool[n], `E_AO < E_TO`: more than it could without.
        encumbers: bool[n], `E_AO > E_TO`: less than it could without. Where neither holds, both are
            equal, or what is certified of them leaves open which is larger.
        average_with_tool: over all placements with the tool in hand.
        average_without: over all placements without a tool.
        gap_with_tool, gap_without: how much larger these averages can be (0 where nothing is
            noisy).
    """

    states: Int64[np.ndarray, "n"]
    with_tool: Float64[np.ndarray, "n"]
    without: Float64[np.ndarray, "n"]
    useful: Bool[np.ndarray, "n"]
    better_than_none: Bool[np.ndarray, "n"]
    encumbers: Bool[np.ndarray, "n"]
    average_with_tool: float
    average_without: float
    gap_with_tool: float
    gap_without: float

    @unfailing
    def __repr__(self) -> str:
        better, worse = (flags.mean() for flags in (self.better_than_none, self.encumbers))
        return short(
            "Usefulness",
            f"{self.average_with_tool:.4f} with the tool, {self.average_without:.4f} without",
            f"better than none in {better:.0%} of {counted(len(self.states), 'state')}",
            f"encumbers in {worse:.0%}",
        )

    @property
    def useful_on_average(self) -> bool:
        """Whether the average with the tool is above 0."""
        return self.average_with_tool > NOTHING

    @property
    def better_than_none_on_average(self) -> bool:
        """Whether the average with the tool is above that without, for certain."""
        return bool(_above(self.average_with_tool, self.average_without, self.gap_without))

    @property
    def encumbers_on_average(self) -> bool:
        """Whether the average with the tool is below that without, for certain."""
        return bool(_above(self.average_without, self.average_with_tool, self.gap_with_tool))


@takes_old_keywords
def usefulness(
    world: World, horizon: int, slip: float = 0.0, **options: Unpack[Options]
) -> Usefulness:
    """Whether the world's tool is of use for its object.

    A tool that could be put down on the map is held here.

    Args:
        world: the map, with a tool.
        horizon: h, in actions.
        slip: as in `tabulate`.
        **options: `method`, `unit`, `executor` and `show_progress`, as in `empowerment`.

    Returns:
        Both empowerments of every placement with the tool in hand, and what they say of the tool.

    Raises:
        ValueError: the world has no tool, or as in `empowerment`.

    Example:
        >>> from habilis.worlds.world import load_world
        >>> picker = usefulness(load_world("yard", tool="picker"), horizon=3)
        >>> picker.better_than_none_on_average, round(float(picker.better_than_none.mean()), 2)
        (True, 0.16)
    """
    if world.tool == NO_TOOL:
        raise ValueError(f"{world.name} has no tool to judge; give it one, as with_tool('broom')")
    show = options.get("show_progress", False)
    mdp = tabulate(held(world), slip, show_progress=show)
    bare = tabulate(world.with_tool(NO_TOOL), slip, show_progress=show)
    states = np.flatnonzero(compared_states(mdp))
    armed, armed_gap = empowerment(
        mdp, horizon, "object", states=states, return_gap=True, **options
    )
    alone, gap = empowerment(bare, horizon, "object", return_gap=True, **options)
    same = _same_placement(mdp, bare)[states]
    return Usefulness(
        states=states,
        with_tool=armed,
        without=alone[same],
        useful=armed > NOTHING,
        better_than_none=_above(armed, alone[same], gap[same]),
        encumbers=_above(alone[same], armed, armed_gap),
        average_with_tool=float(armed.mean()),
        average_without=float(alone.mean()),
        gap_with_tool=float(armed_gap.mean()),
        gap_without=float(gap.mean()),
    )


def _above(larger: Values, smaller: Values, gap: Values) -> Any:
    """Whether values are above others for certain: those may be larger by their gaps.

    Logarithms of equal counts, and means of them, may differ by rounding: `NOTHING` is no
    difference.
    """
    return larger > smaller + np.maximum(gap, NOTHING)


def _same_placement(mdp: TabularMDP, bare: TabularMDP) -> Int64[np.ndarray, "S"]:
    """For every state the state of the bare world with agent and object in the same cells."""

    def key(table: TabularMDP) -> Int64[np.ndarray, "S"]:
        cells = int(max(bare.factor("agent").max(), bare.factor("object").max())) + 1
        return table.factor("agent").astype(np.int64) * cells + table.factor("object")

    keys = key(bare)
    order = np.argsort(keys)
    return order[np.searchsorted(keys[order], key(mdp))]
