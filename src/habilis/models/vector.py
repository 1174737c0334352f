"""Vectorised models: their steps, and the table of what can be reached."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from jaxtyping import Bool, Int64

from habilis.mdp import TabularMDP
from habilis.models.limits import Limits, made_again
from habilis.models.protocol import VectorModel, action_names
from habilis.models.rows import ReachedRows, Rows, Step, reach_rows
from habilis.models.tables import table_of
from habilis.models.values import usable_actions

_ROWS = 2  # dimensions of an array with a state a row


def explore_rows(
    model: VectorModel,
    states: Sequence[Any],
    limits: Limits,
    report: Callable[[int, int], None],
) -> TabularMDP:
    """The table of all states of a vectorised model that can be reached from some.

    Raises:
        ValueError: as in `explore`.
    """
    names, actions = action_names(model)
    try:
        initial = np.asarray(states)
    except ValueError:  # of different lengths
        initial = np.empty(0)
    if initial.dtype.kind not in "iub" or initial.ndim != _ROWS or not initial.size:
        raise ValueError(
            f"states has shape {initial.shape} and type {initial.dtype}; give a row of k integers "
            "for each state"
        )
    found = reach_rows(_step_of(model, actions), actions, initial.astype(np.int64), limits, report)
    _check_again(model, found)
    return table_of(model, found, len(found.found), names)


def _step_of(model: VectorModel, actions: int) -> Step:
    """Where all actions lead, and which are available."""

    def step(rows: Rows) -> tuple[Int64[np.ndarray, "n A k"], Bool[np.ndarray, "n A"] | None]:
        rows.flags.writeable = False
        there = _available(model, rows, actions)
        after = np.empty((len(rows), actions, rows.shape[1]), np.int64)
        for action in range(actions):
            if there is None:
                after[:, action] = _stepped(model, rows, np.full(len(rows), action))
            else:
                usable = np.flatnonzero(there[:, action])
                chosen = np.full(len(usable), action)
                after[usable, action] = _stepped(model, rows[usable], chosen)
        return after, there

    return step


def _available(model: VectorModel, rows: Rows, actions: int) -> Bool[np.ndarray, "n A"] | None:
    """Which actions are available in some states; `None`: all.

    Raises:
        ValueError: the model does not say it as `VectorModel` asks.
    """
    many, one = getattr(model, "available_many", None), getattr(model, "available", None)
    if many is not None:
        there = np.asarray(many(rows))
        if there.dtype != bool or there.shape != (len(rows), actions):
            raise ValueError(
                f"available_many returns {there.dtype} of shape {there.shape}; return bool of "
                f"shape {(len(rows), actions)}"
            )
        return there
    if one is None:
        return None
    there = np.zeros((len(rows), actions), bool)
    for place, row in enumerate(rows.tolist()):
        there[place, [*usable_actions(one, tuple(row), actions)]] = True
    return there


def _stepped(model: VectorModel, rows: Rows, actions: Int64[np.ndarray, "n"]) -> Rows:
    """The next states of some.

    Raises:
        ValueError: they are not rows of integers like them.
    """
    after = np.asarray(model.step_many(rows, actions))
    if after.dtype == np.uint64 and after.size and after.max() > np.iinfo(np.int64).max:
        raise ValueError(f"step_many returns {after.max()}; use numbers below 2**63")
    if after.dtype.kind not in "iub" or after.shape != rows.shape:
        raise ValueError(
            f"step_many returns {after.dtype} of shape {after.shape}; return integers of shape "
            f"{rows.shape}, like the states"
        )
    return after.astype(np.int64, copy=False)


def _check_again(model: VectorModel, found: ReachedRows) -> None:
    """Makes steps a second time, in another order and company.

    Raises:
        ValueError: one has another outcome then.
    """
    leads = found.next_state
    chosen = made_again(leads.size)
    chosen = chosen[leads.ravel()[chosen] >= 0]
    if not len(chosen):
        return
    states, actions = np.divmod(chosen, leads.shape[1])
    before = leads.ravel()[chosen]
    after = _stepped(model, found.take(states), actions)
    wrong = np.flatnonzero((after != found.take(before)).any(axis=1))
    if len(wrong):
        first = wrong[0]
        raise ValueError(
            f"step_many leads from {found.state(int(states[first]))} by action {actions[first]} to "
            f"{tuple(after[first].tolist())} the second time, and to "
            f"{found.state(int(before[first]))} before; let it depend on state and action alone, "
            "row by row"
        )
