"""Environments by name."""

from typing import Any

import gymnasium


def made(identity: str, arguments: dict[str, Any]) -> gymnasium.Env:
    """`gymnasium.make`, with every failure a ValueError of one line."""
    try:
        return gymnasium.make(identity, **arguments)
    except (gymnasium.error.Error, ImportError, TypeError, ValueError, KeyError) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise ValueError(
            f"gym:{identity} cannot be made ({reason}); "
            "give a registered environment and its own arguments, as gym:FrozenLake-v1?map_name=8x8"
        ) from None
