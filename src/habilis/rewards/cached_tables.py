"""Empowerment that is computed once for a table, and then read from the disk."""

from dataclasses import fields, replace
from pathlib import Path
from typing import Unpack

import numpy as np
from jaxtyping import Float64
from numpy.typing import ArrayLike

from habilis.cache import fingerprint, kept
from habilis.empowerment.api import Options, empowerment
from habilis.empowerment.arguments import chosen_actions
from habilis.empowerment.combined import combined
from habilis.empowerment.methods import Exact, checked_method
from habilis.empowerment.sensors import Sensor, is_noisy, observation_probabilities, observations
from habilis.mdp import TabularMDP

_EDITION = 1  # of the values: to be raised when they become others


def kept_empowerment(
    mdp: TabularMDP,
    horizon: int,
    sensor: Sensor = "state",
    actions: ArrayLike | None = None,
    *,
    folder: Path | None = None,
    **options: Unpack[Options],
) -> Float64[np.ndarray, "S"]:
    """The empowerment of every state; the second time from the disk.

    The key of the cache is the content of the table: another map, tool, sensor or horizon is
    another file, and an equal one the same, whatever it is called.

    Args:
        mdp: the table.
        horizon, sensor, actions: as in `empowerment`; of a sum or product of several sensors the
            values through each are kept.
        folder: where values are kept; by default `$XDG_CACHE_HOME/habilis`, or `~/.cache/habilis`.
        **options: `method`, `unit`, `executor` and `show_progress`, as in `empowerment`.

    Returns:
        float64[S], in bits.

    Raises:
        ValueError: as in `empowerment`.
    """
    return combined(mdp, sensor, lambda one: _kept(mdp, horizon, one, actions, folder, options))


def _kept(
    mdp: TabularMDP,
    horizon: int,
    sensor: Sensor,
    actions: ArrayLike | None,
    folder: Path | None,
    options: Options,
) -> Float64[np.ndarray, "S"]:
    seen = (
        observation_probabilities(mdp, sensor) if is_noisy(sensor) else observations(mdp, sensor)[0]
    )
    name = fingerprint(
        *("empowerment", _EDITION, horizon, mdp.transitions, seen),
        None if actions is None else chosen_actions(mdp, actions).tolist(),
        _of_values(options),
    )

    def compute() -> dict[str, np.ndarray]:
        return {"values": empowerment(mdp, horizon, sensor, actions, **options)}

    return kept(name, compute, folder)["values"]


def _of_values(options: Options) -> list[tuple[str, str]]:
    """The options on which values depend, where they are not the default.

    What a computation may cost changes none.
    """
    default = Exact()
    method = checked_method(options.get("method", default))
    limits = {f.name: getattr(default, f.name) for f in fields(Exact) if f.name != "tolerance"}
    method, unit = replace(method, **limits), options.get("unit", "bits")
    described = [] if method == default else [("method", repr(method))]
    return described + ([] if unit == "bits" else [("unit", unit)])
