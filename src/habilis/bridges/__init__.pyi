# The public names: `__init__.py` imports each from here on first use.
from habilis.bridges.puzzles.pushworld import PushWorld as PushWorld
from habilis.bridges.puzzles.pushworld import load_pushworld as load_pushworld
from habilis.bridges.puzzles.sokoban import load_sokoban as load_sokoban

__all__: list[str]
