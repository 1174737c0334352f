"""Tables of Gymnasium environments that were written elsewhere.

From the environment's own table `P` where it has one (`transition_dict`), otherwise by stepping
through every state that can be reached (`enumeration`). Every table is then checked against
the environment as the user passed it, with its wrappers (`replays`).
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from habilis.extras import import_from
from habilis.mdp import TabularMDP


def table_of(
    env: Any,
    max_states: int,
    seed: int | None,
    key: Callable[[Any], Any] | None,
    ignore: Sequence[str],
    state: Any,
    factors: Mapping[str, Callable[[Any], int]] | None,
    show_progress: bool,
) -> TabularMDP:
    """`TabularMDP.from_gymnasium`; see there."""
    tables = import_from("habilis.bridges.gymnasium.tables", "gymnasium")
    identity = tables.Identity(key, ignore, state)
    return tables.table_of(env, max_states, seed, identity, factors, show_progress)
