"""The futures that an agent could choose among: the inputs that attain a state's empowerment."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float64, Int32, Int64
from numpy.typing import ArrayLike

from habilis.bridges.puzzles.bodies import ACTIONS as PUZZLE_ACTIONS
from habilis.bridges.puzzles.pushworld import PushWorld
from habilis.channels.capacity import warn_of_gap
from habilis.empowerment.arguments import (
    Unit,
    chosen_actions,
    chosen_states,
    per_bit,
    whole_number,
)
from habilis.empowerment.combined import is_combined
from habilis.empowerment.limits import too_much
from habilis.empowerment.methods import Exact, checked_method
from habilis.empowerment.old_keywords import takes_old_keywords
from habilis.empowerment.sensors import Sensor, factor_of, is_noisy
from habilis.mdp import TabularMDP
from habilis.probabilities import as_array
from habilis.progress import progress_bar
from habilis.reprs import counted, short, unfailing
from habilis.worlds.world import World

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_EXACT = Exact()
_UNUSED = 1e-9  # sequences with less probability are left out
_ARROWS = "↑→↓←⇑⇒⇓⇐↧"
_MOST = 12  # sequences shown
_DPI, _GAP, _HEAD, _FOOT, _BARS = 96, 24, 56, 48, 210  # pixels
_ACTION, _SEQUENCE = 9, 110  # pixels of an action, and at least of a sequence


@dataclass(frozen=True)
class Futures:
    """The capacity-achieving action sequences, and the observations that they lead to.

    Attributes:
        empowerment: of the state, in `unit`; to within `gap`.
        gap: a proven upper bound on what is missing.
        unit: "bits" or "nats".
        sequences: int32[k, h], action indices: the sequences worth choosing, the most probable
            first; one stands for all that lead to the same observations.
        probability: float64[k], with which each would be chosen; their sum is 1.
        observations: int64[m], what could be seen: states, labels of a factor, columns of a
            noisy sensor, or, of "rest", the numbers of the combinations that there are.
        channel: float64[k, m], the probability of each observation after each sequence.
    """

    empowerment: float
    gap: float
    unit: Unit
    sequences: Int32[np.ndarray, "k h"]
    probability: Float64[np.ndarray, "k"]
    observations: Int64[np.ndarray, "m"]
    channel: Float64[np.ndarray, "k m"]

    @unfailing
    def __repr__(self) -> str:
        return short(
            "Futures",
            f"{self.empowerment:.4f} {self.unit}, gap {self.gap:.1e}",
            f"{counted(len(self.sequences), 'sequence')} of "
            f"{counted(self.sequences.shape[1], 'action')}, "
            f"{counted(len(self.observations), 'observation')}",
        )

    @property
    def seen(self) -> Float64[np.ndarray, "m"]:
        """The probability of each observation when sequences are chosen so."""
        return self.probability @ self.channel


@takes_old_keywords
def futures(
    mdp: TabularMDP,
    state: int,
    horizon: int,
    sensor: Sensor = "state",
    actions: ArrayLike | None = None,
    *,
    method: Exact = _EXACT,
    unit: Unit = "bits",
    show_progress: bool = False,
) -> Futures:
    """The capacity-achieving distribution over action sequences of one state.

    Of the distributions that attain the empowerment it is one; where every sequence has one
    outcome, the uniform one over the outcomes. It is the maximising p in

        E_h(s) = max over p(a_1 ... a_h) of I(A_1 ... A_h; O_h | s)

    (Klyubin, Polani and Nehaniv 2005), found as in `capacity`.

    Args:
        mdp, horizon, actions, unit, show_progress: as in `empowerment`.
        state: the state's index.
        sensor: as in `empowerment`, but one alone.
        method: `Exact`, with its settings; one thread works on one state.

    Returns:
        The sequences worth choosing among, with their probabilities, and what they lead to; none
        where no sequence can surely be carried out.

    Raises:
        ValueError: as in `empowerment`; or a sum or product of several sensors, whose values no one
            choice of sequences attains together.

    Warns:
        ConvergenceWarning: the gap is above the tolerance.

    Example:
        >>> ring = TabularMDP.deterministic([[(s - 1) % 9, (s + 1) % 9] for s in range(9)])
        >>> choice = futures(ring, state=4, horizon=2)
        >>> choice.observations, choice.seen.round(3)
        (array([2, 4, 6]), array([0.333, 0.333, 0.333]))
    """
    from habilis.empowerment.tabular.beliefs import TooManyBeliefsError
    from habilis.empowerment.tabular.cost import check_effort, most_entries
    from habilis.empowerment.tabular.open_loop import exact, problem_of

    horizon, scale = whole_number("horizon", horizon), per_bit(unit)
    method = checked_method(method, [Exact])
    tolerance, limits = method.tolerance / scale, replace(method.limits, otherwise="")
    if is_combined(mdp, sensor):
        raise ValueError(
            f"sensor is {sensor!r}, and futures are those of a single one; give one of them"
        )
    used = chosen_actions(mdp, actions)
    start = int(chosen_states(mdp, [state])[0])
    most = most_entries(limits, 1)
    problem = problem_of(mdp, horizon, sensor, used, tolerance, most)
    check_effort(problem, np.array([start]), 1, limits, listed=True)
    try:
        with progress_bar("actions", show_progress) as report:
            beliefs, answer = exact(problem, start, report)
    except TooManyBeliefsError as error:
        raise too_much(horizon, error.horizon, limits) from None
    if answer.gap > tolerance:
        warn_of_gap(answer.gap, tolerance)
    order = np.argsort(-answer.inputs, kind="stable")
    order = order[answer.inputs[order] > _UNUSED]
    probability = answer.inputs[order]
    return Futures(
        answer.bits * scale,
        answer.gap * scale,
        unit,
        used.astype(np.int32)[beliefs.sequences(answer.rows[order])],
        probability / probability.sum(),
        _named(mdp, sensor, answer.observations),
        answer.channel[order],
    )


def _named(
    mdp: TabularMDP, sensor: Sensor, observations: Int64[np.ndarray, "m"]
) -> Int64[np.ndarray, "m"]:
    """Observations by the sensor's own labels."""
    factor = factor_of(mdp, sensor) if isinstance(sensor, str) else None
    if is_noisy(sensor) or (isinstance(sensor, str) and factor is None):
        return observations
    labels = as_array("sensor", sensor) if factor is None else mdp.factors[factor]
    return np.unique(labels)[observations].astype(np.int64)


def futures_figure(
    world: World | PushWorld, mdp: TabularMDP, found: Futures, thing: str, cell: int = 48
) -> "Figure":
    """Where a thing could be brought, and by which sequences of actions.

    Args:
        world: the map, in the state asked about (see `placement`); or the puzzle, as `at` makes it.
        mdp: its table, for the names of actions.
        found: of a sensor whose labels are cells.
        thing: the name of the factor that it senses.
        cell: pixels a cell.

    Returns:
        On the left the map: in each cell the percentage of the agent's choices that end with the
        thing there. On the right the most probable sequences; thin arrows move the agent, double
        ones the tool, and one with a bar puts it down.
    """
    from matplotlib.figure import Figure

    from habilis.worlds.pictures.heatmap import draw_heat, draw_scale

    map_width, map_height = cell * world.width, max(cell * world.height, 240)
    labels = [sequence_text(mdp, sequence) for sequence in found.sequences[:_MOST]]
    beside = max([_SEQUENCE, *(_ACTION * len(label) for label in labels)])
    width = 3 * _GAP + 80 + map_width + beside + _BARS
    height = _HEAD + map_height + _FOOT
    figure = Figure(figsize=(width / _DPI, height / _DPI), dpi=_DPI)

    def axes(left: int, across: int) -> "Axes":
        box = (left / width, _FOOT / height, across / width, map_height / height)
        return figure.add_axes(box)

    percent = np.full(world.height * world.width, np.nan)
    percent[found.observations] = 100 * found.seen
    ax = axes(_GAP, map_width)
    shown = percent.reshape(world.height, world.width)
    heat = draw_heat(ax, world, shown, vmin=0, agent=True)
    draw_scale(heat, "% of choices", cax=axes(_GAP + map_width + 12, 16))
    bars = axes(width - _BARS - _GAP, _BARS)
    _draw_sequences(bars, labels, found)
    horizon, name = found.sequences.shape[1], thing.rpartition(":")[2]
    figure.suptitle(
        f"where the {name} could be after {horizon} actions: "
        f"{found.empowerment:.3f} {found.unit}, {len(found.observations)} cells",
        fontsize=11,
    )
    figure.text(0.5, 1 - 44 / height, arrows_legend(mdp), ha="center", fontsize=8)
    return figure


def _draw_sequences(ax: "Axes", labels: Sequence[str], found: Futures) -> None:
    count = len(labels)
    ax.barh(range(count), 100 * found.probability[:count], color="#0072b2")
    ax.set_yticks(range(count), labels, fontsize=9)
    ax.set_ylim(_MOST - 0.5, -0.5)
    left = len(found.sequences) - count
    ax.set_xlabel("% of choices" + (f" ({left} more sequences)" if left else ""), fontsize=9)
    ax.spines[["top", "right"]].set_visible(False)


def sequence_text(mdp: TabularMDP, sequence: np.ndarray) -> str:
    """A sequence of actions in arrows for a world or a puzzle, else by names or numbers."""
    if arrows := _arrows(mdp):
        return "".join(arrows[action] for action in sequence)
    return " ".join(mdp.actions[a] if mdp.actions else str(a) for a in sequence)


def arrows_legend(mdp: TabularMDP) -> str:
    """A legend of the arrows in `sequence_text`; "" where there are none."""
    arrows = _arrows(mdp)
    parts = [
        (arrows[:4], "move the agent"),
        (arrows[4:8], "put the tool on that side of it"),
        (arrows[8:], "puts it down"),
    ]
    return ", ".join(f"{some} {what}" for some, what in parts if some)


def _arrows(mdp: TabularMDP) -> str:
    """An arrow for each action of a world or a puzzle."""
    if mdp.shape is not None and mdp.actions == PUZZLE_ACTIONS:
        return "←→↑↓"
    if mdp.shape is not None and mdp.actions[:1] == ("north",):
        return _ARROWS[: len(mdp.actions)]
    return ""
