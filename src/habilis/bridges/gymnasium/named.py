"""Tables of environments by their names on the command line."""

import ast
import json
import traceback
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from urllib.parse import unquote_plus

import gymnasium

from habilis.mdp import TabularMDP
from habilis.own_code import importing_from


def table_named(
    name: str,
    max_states: int | None = None,
    ignore: Sequence[str] = (),
    show_progress: bool = False,
) -> TabularMDP:
    """The table of an environment by its name on the command line.

    Args:
        name: its ID, with its arguments as in `FrozenLake-v1?map_name=8x8&is_slippery=false`; a
            module that registers it is named before it, one of a package or of the working
            directory: `minigrid:MiniGrid-DoorKey-5x5-v0`.
        max_states: as in `TabularMDP.from_gymnasium`, and by default as many.
        ignore: as there.
        show_progress: whether to draw a progress bar.

    Raises:
        ValueError: there is no such environment, or it has no such table.
    """
    identity, _, query = name.partition("?")
    env = _made(identity, _arguments(identity, query))
    limit: Any = {} if max_states is None else {"max_states": max_states}
    try:
        return TabularMDP.from_gymnasium(env, ignore=ignore, show_progress=show_progress, **limit)
    except ValueError as error:
        raise ValueError(f"gym:{identity}: {error}") from None
    finally:
        env.close()


def limit_named(name: str) -> int | None:
    """After how many steps an environment truncates an episode, by its name; `None`: never.

    Raises:
        ValueError: there is no such environment.
    """
    identity, _, query = name.partition("?")
    env = _made(identity, _arguments(identity, query))
    env.close()
    return None if env.spec is None else env.spec.max_episode_steps


def _made(identity: str, arguments: dict[str, Any]) -> gymnasium.Env:
    """`gymnasium.make`, with every failure a ValueError of one line, and without warnings.

    Its warnings inform authors of programs of a newer version: a user who names an
    environment on the command line means that one.
    """
    try:
        with warnings.catch_warnings(), importing_from(Path.cwd()):
            warnings.simplefilter("ignore")
            return gymnasium.make(identity, **arguments)
    except (Exception, SystemExit) as error:  # a module of the user's own may fail in any way
        said = error.msg if isinstance(error, SyntaxError) else str(error)
        reason = said.partition("\n")[0]
        if not isinstance(error, gymnasium.error.Error):  # a KeyError says no more than the key
            reason = f"{type(error).__name__}: {reason}" if reason else type(error).__name__
            reason += _place(error)
        raise ValueError(
            f"gym:{identity} cannot be made ({reason}); "
            "give a registered environment and its own arguments, as gym:FrozenLake-v1?map_name=8x8"
            ", or with the module that registers it, as gym:minigrid:MiniGrid-Empty-5x5-v0"
        ) from None


def _place(error: BaseException) -> str:
    """Where in the working directory an error comes from, if it comes from there."""
    file, line = None, None
    if isinstance(error, SyntaxError):
        file, line = error.filename, error.lineno
    elif frames := traceback.extract_tb(error.__traceback__):
        file, line = frames[-1].filename, frames[-1].lineno
    if file is None or Path(file).resolve().parent != Path.cwd().resolve():
        return ""
    return f", {Path(file).name}, line {line}"


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
