# The public names: `__init__.py` imports each from here on first use.
from habilis.bridges.pushworld import PushWorld as PushWorld
from habilis.bridges.pushworld import load_pushworld as load_pushworld

__all__: list[str]
