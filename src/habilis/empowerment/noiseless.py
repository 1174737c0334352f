"""Empowerment without noise: logarithms of numbers of observations."""

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float64, Int64

from habilis.empowerment.availability import with_nowhere
from habilis.empowerment.limits import Progress
from habilis.empowerment.methods import Exact
from habilis.empowerment.sensors import Sensor, factor_of, observations
from habilis.mdp import TabularMDP
from habilis.processors import processors
from habilis.progress import in_percent, progress_bar

if TYPE_CHECKING:
    from habilis.empowerment.tabular.deterministic import Question


def counted_bits(
    mdp: TabularMDP,
    horizon: int,
    sensor: Sensor,
    actions: Int64[np.ndarray, "A"],
    starts: Int64[np.ndarray, "n"] | None,
    method: Exact,
    show_progress: bool,
) -> Float64[np.ndarray, "n"]:
    """The logarithms of the numbers of reachable observations, without noise."""
    # Numba takes as long to import as everything else together: only who computes pays.
    from habilis.empowerment.tabular.deterministic import counts

    with progress_bar("empowerment", show_progress) as bar:
        question = question_of(mdp, horizon, sensor, actions, starts, method, in_percent(bar))
        return bits_of(counts(question))


def question_of(
    mdp: TabularMDP,
    horizon: int,
    sensor: Sensor,
    actions: Int64[np.ndarray, "A"],
    starts: Int64[np.ndarray, "n"] | None,
    method: Exact,
    report: Progress,
) -> "Question":
    """The counting problem of a measure of a deterministic table."""
    from habilis.empowerment.tabular.deterministic import Question

    labels, label_count = observations(mdp, sensor)
    factor = factor_of(mdp, sensor) if isinstance(sensor, str) else None
    cells = factor is not None and mdp.is_cell(factor)
    table = mdp.next_state
    if len(actions) < mdp.action_count:
        table = np.ascontiguousarray(table[:, actions])
    table, labels = with_nowhere(table, labels)
    if len(labels) > mdp.states:  # the state added is not asked about, and has no cell
        cells, starts = False, np.arange(mdp.states) if starts is None else starts
    return Question(
        table,
        labels,
        label_count,
        horizon,
        starts,
        mdp.factors[factor] if factor is not None and cells else None,
        mdp.shape,
        method.threads or processors(),
        method.limits,
        report,
    )


def bits_of(counts: Int64[np.ndarray, "*any"]) -> Float64[np.ndarray, "*any"]:
    """The capacity of noiseless channels to so many observations; of none it is 0."""
    return np.log2(np.maximum(counts, 1))
