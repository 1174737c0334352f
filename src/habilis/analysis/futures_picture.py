"""A picture of the futures that an agent could choose among."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from habilis.analysis.futures import Futures
from habilis.mdp import TabularMDP
from habilis.worlds.pictures.heatmap import draw_heat, draw_scale
from habilis.worlds.world import World

_ARROWS = ("↑", "→", "↓", "←", "⇑", "⇒", "⇓", "⇐", "↧")
_MOST = 12  # sequences shown
_DPI, _GAP, _HEAD, _FOOT, _BARS = 96, 24, 56, 48, 320  # pixels


def futures_figure(
    world: World, mdp: TabularMDP, found: Futures, thing: str, cell: int = 48
) -> Figure:
    """Where a thing could be brought, and by which sequences of actions.

    Args:
        world: the map, in the state asked about (see `placement`).
        mdp: its table, for the names of actions.
        found: of a sensor whose labels are cells.
        thing: the name of the factor that it senses.
        cell: pixels a cell.

    Returns:
        On the left the map: in each cell the percentage of the agent's choices that end with the
        thing there. On the right the most probable sequences; thin arrows move the agent, double
        ones the tool, and one with a bar puts it down.
    """
    map_width, map_height = cell * world.width, max(cell * world.height, 240)
    width, height = 3 * _GAP + 80 + map_width + _BARS, _HEAD + map_height + _FOOT
    figure = Figure(figsize=(width / _DPI, height / _DPI), dpi=_DPI)

    def axes(left: int, across: int) -> Axes:
        box = (left / width, _FOOT / height, across / width, map_height / height)
        return figure.add_axes(box)

    percent = np.full(world.height * world.width, np.nan)
    percent[found.observations] = 100 * found.seen
    ax = axes(_GAP, map_width)
    shown = percent.reshape(world.height, world.width)
    heat = draw_heat(ax, world, shown, vmin=0, agent=True)
    draw_scale(heat, "% of choices", cax=axes(_GAP + map_width + 12, 16))
    bars = axes(width - _BARS - _GAP + 110, _BARS - 110)
    _draw_sequences(bars, mdp, found)
    horizon, name = found.sequences.shape[1], thing.rpartition(":")[2]
    figure.suptitle(
        f"where the {name} could be after {horizon} actions: "
        f"{found.empowerment:.3f} {found.unit}, {len(found.observations)} cells",
        fontsize=11,
    )
    return figure


def _draw_sequences(ax: Axes, mdp: TabularMDP, found: Futures) -> None:
    count = min(_MOST, len(found.sequences))
    labels = [sequence_text(mdp, sequence) for sequence in found.sequences[:count]]
    ax.barh(range(count), 100 * found.probability[:count], color="#0072b2")
    ax.set_yticks(range(count), labels, fontsize=9)
    ax.set_ylim(_MOST - 0.5, -0.5)
    left = len(found.sequences) - count
    ax.set_xlabel("% of choices" + (f" ({left} more sequences)" if left else ""), fontsize=9)
    ax.spines[["top", "right"]].set_visible(False)


def sequence_text(mdp: TabularMDP, sequence: np.ndarray) -> str:
    """A sequence of actions in arrows for a world's table, else by names or numbers."""
    if mdp.shape is not None and mdp.actions[:1] == ("north",):
        return "".join(_ARROWS[action] for action in sequence)
    return " ".join(mdp.actions[a] if mdp.actions else str(a) for a in sequence)
