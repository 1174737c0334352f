"""Environments by name."""

import warnings
from typing import Any

import gymnasium


def made(identity: str, arguments: dict[str, Any]) -> gymnasium.Env:
    """`gymnasium.make`, with every failure a ValueError of one line, and no warnings.

    Its warnings tell authors of programs that a newer version exists: a user who names an
    environment on the command line means that one.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return gymnasium.make(identity, **arguments)
    except (gymnasium.error.Error, ImportError, TypeError, ValueError, KeyError) as error:
        reason = str(error).splitlines()[0] if str(error) else ""
        if not isinstance(error, gymnasium.error.Error):  # a KeyError says no more than the key
            reason = f"{type(error).__name__}: {reason}" if reason else type(error).__name__
        raise ValueError(
            f"gym:{identity} cannot be made ({reason}); "
            "give a registered environment and its own arguments, as gym:FrozenLake-v1?map_name=8x8"
        ) from None
