"""The names by which `gymnasium.make` knows the worlds."""

import gymnasium
from gymnasium.envs.registration import registry

MAX_STEPS = 500
"""Steps after which an episode is cut off, unless set otherwise."""

_WORLDS = {"Corridor": {"world": "corridor"}, "Yard": {"world": "yard"}, "World": {}}


def register() -> None:
    """Registers the worlds and "habilis/PushWorld-v0"; what is registered already stays."""
    for name, arguments in _WORLDS.items():
        if f"habilis/{name}-v0" not in registry:
            gymnasium.register(
                f"habilis/{name}-v0",
                entry_point="habilis.envs.world:WorldEnv",
                vector_entry_point="habilis.envs.world:WorldVectorEnv",
                kwargs=arguments,
            )
    if "habilis/PushWorld-v0" not in registry:
        gymnasium.register(
            "habilis/PushWorld-v0",
            entry_point="habilis.envs.pushworld:PushWorldEnv",
            vector_entry_point="habilis.envs.pushworld:PushWorldVectorEnv",
            max_episode_steps=MAX_STEPS,
        )
