"""Tables of Gymnasium environments that were written elsewhere.

From the environment's own table `P` where it has one (`transition_dict`), otherwise by stepping
through every state that can be reached (`enumeration`). Every table is then checked against
the environment as the user passed it, with its wrappers (`replays`).
"""

import ast
import json
from collections.abc import Callable, Mapping, Sequence
from typing import Any
from urllib.parse import unquote_plus

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


def table_named(
    name: str,
    max_states: int | None = None,
    ignore: Sequence[str] = (),
    show_progress: bool = False,
) -> TabularMDP:
    """The table of an environment by its name on the command line.

    Args:
        name: its ID, with its arguments as in `FrozenLake-v1?map_name=8x8&is_slippery=false`; a
            package that registers it is named before it: `minigrid:MiniGrid-DoorKey-5x5-v0`.
        max_states: as in `TabularMDP.from_gymnasium`, and by default as many.
        ignore: as there.
        show_progress: whether to draw a progress bar.

    Raises:
        ValueError: there is no such environment, or it has no such table.
        MissingExtraError: Gymnasium is not installed.
    """
    identity, _, query = name.partition("?")
    registration = import_from("habilis.bridges.gymnasium.registration", "gymnasium")
    env = registration.made(identity, _arguments(identity, query))
    limit: Any = {} if max_states is None else {"max_states": max_states}
    try:
        return TabularMDP.from_gymnasium(env, ignore=ignore, show_progress=show_progress, **limit)
    except ValueError as error:
        raise ValueError(f"gym:{identity}: {error}") from None
    finally:
        env.close()


def _arguments(identity: str, query: str) -> dict[str, Any]:
    """The arguments after the question mark.

    Raises:
        ValueError: one of them has no value, or is given twice.
    """
    found: dict[str, Any] = {}
    for part in query.split("&") if query else ():
        name, _, text = (unquote_plus(each) for each in part.partition("="))
        if not name or not text:
            problem = f"argument {name!r} has no value" if name else f"{part!r} has no name"
            raise ValueError(f"gym:{identity}: {problem}; give both, as ?map_name=8x8")
        if name in found:
            raise ValueError(f"gym:{identity}: argument {name!r} is given twice; give it once")
        found[name] = _value(text)
    return found


def _value(text: str) -> Any:
    """A value as JSON has it or as Python does, or else the text itself."""
    for read in (json.loads, ast.literal_eval):
        try:
            return read(text)
        except (ValueError, SyntaxError):
            continue
    return text
