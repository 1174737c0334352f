"""Gymnasium environments made of tables, and empowerment in the reward of any environment.

`import habilis` registers "habilis/Corridor-v0", "habilis/Yard-v0" and "habilis/World-v0".
"""

from habilis.lazy import public

__getattr__, __dir__, __all__ = public(__name__, ("habilis.envs.functional",))
