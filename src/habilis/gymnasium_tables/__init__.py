"""Tables of Gymnasium environments that were written elsewhere.

From the environment's own table `P` where it has one (`transition_dict`), otherwise by stepping
through every state that can be reached (`enumeration`).
"""

import ast
import json
from collections.abc import Callable, Hashable, Mapping
from typing import Any
from urllib.parse import parse_qsl

from habilis.extras import import_from
from habilis.mdp import TabularMDP


def table_of(
    env: Any,
    max_states: int,
    seed: int | None,
    key: Callable[[Any], Hashable] | None,
    factors: Mapping[str, Callable[[Any], int]] | None,
    show_progress: bool,
) -> TabularMDP:
    """`TabularMDP.from_gymnasium`; see there."""
    from habilis.gymnasium_tables.enumeration import enumerate_states
    from habilis.gymnasium_tables.transition_dict import table_of_dict

    inner = getattr(env, "unwrapped", None)
    if not hasattr(inner, "action_space"):
        raise ValueError(f"{env!r} is no Gymnasium environment; give what gymnasium.make returns")
    check_actions(env)
    own = getattr(inner, "dynamics", None)
    if isinstance(own, TabularMDP):
        return own  # of our environments
    table = getattr(inner, "P", None)
    if table is not None:
        if len(table) > max_states:
            raise ValueError(
                f"the table P has {len(table):,} states, more than {max_states:,}; raise max_states"
            )
        return table_of_dict(inner)
    return enumerate_states(env, max_states, seed, key, factors, show_progress).mdp


def check_actions(env: Any) -> None:
    """Refuses wrappers that make other actions of the ones they get: the table is of those inside.

    Raises:
        ValueError: there is one, or the actions outside are others than those inside.
    """
    import gymnasium

    layer = env
    while isinstance(layer, gymnasium.Wrapper):
        if isinstance(layer, gymnasium.ActionWrapper):
            raise ValueError(
                f"{type(layer).__name__} changes the actions, which no table knows; give the "
                "environment inside of it, and put such wrappers around the rest"
            )
        layer = layer.env
    if env.action_space != layer.action_space:
        raise ValueError(
            f"the actions are {env.action_space} outside and {layer.action_space} inside; give the "
            "environment inside of the wrapper that changes them"
        )


def table_named(
    name: str, max_states: int | None = None, show_progress: bool = False
) -> TabularMDP:
    """The table of an environment by its name on the command line.

    Args:
        name: its ID, with its arguments as in `FrozenLake-v1?map_name=8x8&is_slippery=false`; a
            package that registers it is named before it: `minigrid:MiniGrid-DoorKey-5x5-v0`.
        max_states: as in `TabularMDP.from_gymnasium`, and by default as many.
        show_progress: whether to draw a progress bar.

    Raises:
        ValueError: there is no such environment, or it has no such table.
        MissingExtraError: Gymnasium is not installed.
    """
    identity, _, query = name.partition("?")
    registration = import_from("habilis.gymnasium_tables.registration", "gymnasium")
    env = registration.made(identity, {k: _value(v) for k, v in parse_qsl(query)})
    limit: Any = {} if max_states is None else {"max_states": max_states}
    try:
        return TabularMDP.from_gymnasium(env, show_progress=show_progress, **limit)
    except ValueError as error:
        raise ValueError(f"gym:{identity}: {error}") from None
    finally:
        env.close()


def _value(text: str) -> Any:
    """A value as JSON has it or as Python does, or else the text itself."""
    for read in (json.loads, ast.literal_eval):
        try:
            return read(text)
        except (ValueError, SyntaxError):
            continue
    return text
