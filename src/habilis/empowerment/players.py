"""Empowerment of one player against the best or the worst that the others do.

The others commit to a sequence of joint actions b_1 ... b_h, as the player does to its own: the
channel of a sequence of theirs is that of a model of one agent whose steps change with time, and

    best = max over b_1 ... b_h of C(s, b_1 ... b_h),   worst = min over the same.

Sequences of theirs that lead to the same outcomes of all the player's sequences are merged step by
step. Without noise these are sets of states, since what counts is the number of observations in the
set; with noise sets of beliefs, whose channel is certified in the end. Policies of the others are
`TabularMDP.of_player`'s.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Float64, Int32, Int64
from numpy.typing import ArrayLike

from habilis.channels.bounds import information_error
from habilis.channels.capacity import warn_of_gap
from habilis.channels.capacity_solver import best_inputs
from habilis.empowerment.arguments import chosen_actions, chosen_states
from habilis.empowerment.combined import check_single
from habilis.empowerment.initial_beliefs import are_beliefs
from habilis.empowerment.limits import Clock, Limits
from habilis.empowerment.methods import Exact, Method
from habilis.empowerment.one_step import last_observations, moves_of
from habilis.empowerment.sensors import (
    REST,
    Sensor,
    is_by_action,
    is_noisy,
    joint_labels,
    observations,
    rest_of,
)
from habilis.mdp import TabularMDP
from habilis.mdp_players import UNIFORM, available_to_others, joint_actions
from habilis.probabilities import as_array

if TYPE_CHECKING:
    from scipy.sparse import csr_array

BEST, WORST = EXTREMES = "best", "worst"

Bits = Float64[np.ndarray, "n"]
Beliefs = Float64[np.ndarray, "K N"]

_LN2 = float(np.log(2))
_DIGITS = 12  # to which beliefs are compared
_OTHERWISE = "give the others a policy"


def is_extreme(others: Any) -> bool:
    """Whether the others are to do their best or their worst."""
    return isinstance(others, str) and others in EXTREMES


def played_by(
    mdp: TabularMDP, player: str | None, others: Any, is_table: bool
) -> tuple[TabularMDP, tuple[str, str] | None]:
    """The table of a player whose others act by a policy; else the same, and who is against whom.

    Args:
        mdp: a table.
        player, others: as in `empowerment`; without either the table stays as it is.
        is_table: whether the table was given, so that its states have numbers.

    Raises:
        ValueError: as in `checked_others` and `TabularMDP.of_player`.
    """
    if player is None and others is None:
        return mdp, None
    player = checked_others(mdp, player, others, is_table)
    if is_extreme(others):
        return mdp, (player, others)
    return mdp.of_player(player, UNIFORM if others is None else others), None


def checked_others(mdp: TabularMDP, player: Any, others: Any, is_table: bool) -> str:
    """The player, unless it is missing, or the others have a policy over states without numbers.

    Raises:
        ValueError: says what to give.
    """
    if not isinstance(player, str):
        problem = "others is given without player" if player is None else f"player is {player!r}"
        known = ", ".join(mdp.players) or "none: it has no players"
        raise ValueError(f"{problem}; name the player whose empowerment it is ({known})")
    if not is_table and not (others is None or isinstance(others, str)):
        raise ValueError(
            "others is a policy, and a model's states have no numbers yet; explore or tabulate it"
        )
    if isinstance(others, str) and others not in (UNIFORM, *EXTREMES):
        raise ValueError(
            f"others is {others!r}; use 'uniform', 'best', 'worst', or give the others' policy"
        )
    return player


def against_others(
    mdp: TabularMDP,
    player: str,
    others: str,
    horizon: int,
    sensor: Sensor,
    actions: ArrayLike | None,
    states: Any,
    method: Method,
    scale: float,
    plain: bool = True,
) -> tuple[Bits, Bits]:
    """The player's empowerment against the best or the worst sequence of the others, and its gap.

    Args:
        mdp: a table of several players.
        player: its name.
        others: "best" or "worst".
        horizon, sensor, actions, states: as in `empowerment`, of the player.
        method: `Exact`, with its limits.
        scale: how many of the unit are one bit.
        plain: whether the output is the last observation, and nothing costs anything.

    Raises:
        ValueError: an action of the others is not available everywhere, what does not go with
            these others, or a computation above the limits, with the largest horizon that fits.

    Warns:
        ConvergenceWarning: a gap is above the tolerance.
    """
    if not isinstance(method, Exact) or are_beliefs(states) or not plain:
        raise ValueError(
            f"others is {others!r}, which goes with method=hb.Exact(), states and the observation "
            "at the end alone; leave out the rest, or give the others a policy"
        )
    check_single(mdp, sensor, f"others={others!r}")
    joint, starts = joint_actions(mdp, player), chosen_states(mdp, states)
    used = chosen_actions(mdp, actions, len(joint))
    if is_by_action(sensor):
        sensor = _of_joint_actions(sensor, joint, player)
    elif isinstance(sensor, str) and sensor == REST and REST not in mdp.factors:
        own = [player] if player in mdp.factors else None
        sensor, _ = joint_labels(mdp, rest_of(mdp, own))
    _check_always(mdp, player, others, joint)
    limits, tolerance = replace(method.limits, otherwise=_OTHERWISE), method.tolerance / scale
    asked, place = np.unique(starts, return_inverse=True)
    best, gaps = others == BEST, np.zeros(len(asked))
    if horizon == 0 or not len(asked):
        bits = gaps
    elif not mdp.is_stochastic and not is_noisy(sensor):
        bits = _counted(mdp, joint[used], sensor, asked, horizon, best, limits)
    else:
        steps = _Steps.of(mdp, joint[used], sensor)
        bits, gaps = _certified(steps, asked, horizon, best, tolerance, limits)
    if (gaps > tolerance).any():
        warn_of_gap(float(gaps.max()), tolerance)
    return bits[place] * scale, gaps[place] * scale


def _of_joint_actions(sensor: Any, joint: Int64[np.ndarray, "P B"], player: str) -> np.ndarray:
    """A sensor that depends on the player's last action, for the joint ones."""
    given = as_array("sensor", sensor)
    if len(given) != len(joint):
        raise ValueError(
            f"sensor has shape {given.shape}; give [actions of {player!r}, states, observations], "
            f"here {len(joint)} actions"
        )
    by_joint = np.empty((joint.size, *given.shape[1:]), given.dtype)
    by_joint[joint] = given[:, None]
    return by_joint


def _check_always(
    mdp: TabularMDP, player: str, others: str, joint: Int64[np.ndarray, "P B"]
) -> None:
    """Refuses tables in which a sequence of the others might not be carried out."""
    theirs = available_to_others(mdp, player, joint)
    lacking = np.argwhere(~theirs & theirs.any(axis=1, keepdims=True))
    if len(lacking):
        state, action = lacking[0]
        raise ValueError(
            f"others is {others!r}, but their joint action {action} is not available in state "
            f"{state}: sequences of theirs could not be carried out; give it a next state, or the "
            "others a policy"
        )


# Without noise: sets of states


@dataclass(frozen=True)
class _Sets:
    """Sets of states, one after the other: `state[first[i]:first[i + 1]]` are those of set i."""

    first: Int64[np.ndarray, "n_and_one"]
    state: Int32[np.ndarray, "m"]

    @property
    def owner(self) -> Int64[np.ndarray, "m"]:
        """The set that each entry belongs to."""
        return np.repeat(np.arange(len(self.first) - 1), np.diff(self.first))


def _counted(
    mdp: TabularMDP,
    joint: Int64[np.ndarray, "P B"],
    sensor: Sensor,
    starts: Int64[np.ndarray, "n"],
    horizon: int,
    best: bool,
    limits: Limits,
) -> Bits:
    """The logarithm of the largest or the least number of observations."""
    labels, label_count = observations(mdp, sensor)
    sets = _Sets(np.arange(len(starts) + 1), starts.astype(np.int32))
    clock = Clock(horizon, limits)
    led: list[Int64[np.ndarray, "k B"]] = []
    held = 0.0
    for step in range(horizon):
        place, sets = _after(mdp.next_state, joint, sets, clock, step, held)
        led.append(place)
        held += place.nbytes
    seen = np.unique(sets.owner * label_count + labels[sets.state])
    value = np.bincount(seen // label_count, minlength=len(sets.first) - 1)
    for place in reversed(led):
        value = value[place].max(axis=1) if best else value[place].min(axis=1)
    return np.log2(np.maximum(value, 1))


def _after(
    next_state: Int32[np.ndarray, "S A"],
    joint: Int64[np.ndarray, "P B"],
    sets: _Sets,
    clock: Clock,
    step: int,
    held: float,
) -> tuple[Int64[np.ndarray, "k B"], _Sets]:
    """The sets that some sets of states lead to, and which one by each joint action of others."""
    count, states, owner = len(sets.first) - 1, len(next_state), sets.owner
    known: dict[bytes, int] = {}
    found: list[np.ndarray] = []
    place = np.empty((count, joint.shape[1]), np.int64)
    clock.begin()
    for other in range(joint.shape[1]):
        clock.check_memory(held + place.nbytes + 32.0 * len(owner) * len(joint), step)
        reached = next_state[sets.state[:, None], joint[:, other]]
        keys = (owner[:, None] * states + reached)[reached >= 0]
        owners, after = np.divmod(np.unique(keys), states)
        edges = np.searchsorted(owners, np.arange(count + 1)).tolist()
        after = after.astype(np.int32)
        for one in range(count):
            part = after[edges[one] : edges[one + 1]]
            number = known.setdefault(part.tobytes(), len(found))
            if number == len(found):
                found.append(part)
                held += part.nbytes + 150
            place[one, other] = number
        clock.check((other + 1) / joint.shape[1], step)
    sizes = [len(part) for part in found]
    return place, _Sets(np.concatenate([[0], np.cumsum(sizes)]), np.concatenate(found))


# With noise: sets of beliefs


@dataclass(frozen=True)
class _Steps:
    """The transitions and the last observations of joint actions, float64[S * A, .], by pairs."""

    moves: "csr_array"
    seen: "csr_array"
    joint: Int64[np.ndarray, "P B"]
    actions: int

    @classmethod
    def of(cls, mdp: TabularMDP, joint: Int64[np.ndarray, "P B"], sensor: Sensor) -> "_Steps":
        seen = last_observations(mdp, sensor)
        return cls(moves_of(mdp.transitions), seen, joint, mdp.action_count)


def _certified(
    steps: _Steps,
    starts: Int64[np.ndarray, "n"],
    horizon: int,
    best: bool,
    tolerance: float,
    limits: Limits,
) -> tuple[Bits, Bits]:
    """Bounds on the largest or the least capacity."""
    clock = Clock(horizon, limits)
    bits, gaps = np.zeros((2, len(starts)))
    pick = np.max if best else np.min
    for number, start in enumerate(starts.tolist()):
        channels, distance = _channels(steps, start, horizon, clock)
        clock.begin()
        bounds = np.zeros((len(channels), 2))
        for place, channel in enumerate(channels):
            bounds[place] = _capacity(channel, distance, tolerance)
            clock.check((place + 1) / len(channels), horizon - 1)
        low, high = pick(bounds, axis=0)
        bits[number], gaps[number] = low, high - low
        clock.check_all((number + 1) / len(starts))
    return bits, gaps


def _channels(steps: _Steps, start: int, horizon: int, clock: Clock) -> tuple[list[Beliefs], float]:
    """The distinct channels from the player's sequences, over all sequences of the others.

    And how much merging may have changed a row, at most, in total variation: twice a step, by
    half of what entries are rounded by.
    """
    layer, nodes, distance = np.array([start]), [np.ones((1, 1))], 0.0
    for step in range(horizon):
        source = steps.seen if step == horizon - 1 else steps.moves
        rows = layer[:, None, None] * steps.actions + steps.joint
        reached = np.unique(source[rows.ravel()].indices)
        distance += 10.0**-_DIGITS * len(reached)
        known: dict[bytes, Beliefs] = {}
        entries = 0
        clock.begin()
        for other in range(rows.shape[2]):
            each = [source[pairs][:, reached].toarray() for pairs in rows[:, :, other].T]
            for place, beliefs in enumerate(nodes):
                after = [beliefs[_sure(beliefs, one)] @ one for one in each]
                key, distinct = _distinct(np.concatenate(after))
                if key not in known:
                    known[key] = distinct
                    entries += 3 * distinct.size + 20
                clock.check_memory(8.0 * entries, step)
                clock.check((other * len(nodes) + place + 1) / (rows.shape[2] * len(nodes)), step)
        layer, nodes = reached, list(known.values())
    return nodes, distance


def _sure(beliefs: Beliefs, after: Float64[np.ndarray, "N M"]) -> Any:
    """Under which beliefs an action is available in all states that are possible."""
    return ~(beliefs[:, ~after.any(axis=1)] > 0).any(axis=1)


def _distinct(rows: Beliefs) -> tuple[bytes, Float64[np.ndarray, "k N"]]:
    """The distinct rows in an order of their own, and what equal ones have in common."""
    rounded, first = np.unique(np.round(rows, _DIGITS) + 0.0, axis=0, return_index=True)
    return rounded.tobytes(), rows[first]


def _capacity(channel: Beliefs, distance: float, tolerance: float) -> tuple[float, float]:
    """Bounds on the capacity of a channel whose rows were merged with others like them."""
    possible = channel.any(axis=0)
    channel = np.ascontiguousarray(channel[:, possible])
    if min(channel.shape) <= 1:
        return 0.0, 0.0
    channel /= channel.sum(axis=1, keepdims=True)
    _, found = best_inputs(channel, tolerance / 2 * _LN2)
    merged = information_error(distance, channel.shape[1])
    return found.lower / _LN2, max(found.upper, found.lower) / _LN2 + merged
