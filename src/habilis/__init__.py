"""Habilis: exact empowerment of finite MDPs, tool-use worlds, and agents that learn with it.

    import habilis as hb

    mdp = hb.tabulate(hb.load_world("corridor"))
    bits = hb.empowerment(mdp, horizon=6, sensor="object")

The learning half (`train`, `Config`, `reproduce`) is imported on first use and needs the extra
`habilis[learn]`.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from habilis.empowerment import empowerment
from habilis.empowerment.capacity import Capacity, ConvergenceWarning, capacity
from habilis.mdp import TabularMDP
from habilis.worlds.plans import Plan, solve
from habilis.worlds.table import placement, tabulate
from habilis.worlds.world import World, load_world, world_names

if TYPE_CHECKING:
    from habilis.empowerment.landscape import Landscape as Landscape
    from habilis.empowerment.landscape import landscape as landscape
    from habilis.empowerment.landscape_picture import draw_landscapes as draw_landscapes
    from habilis.empowerment.tables import save_table as save_table
    from habilis.empowerment.tables import to_dataframe as to_dataframe
    from habilis.learning.algorithms import A2C as A2C
    from habilis.learning.algorithms import PPO as PPO
    from habilis.learning.algorithms import QLearning as QLearning
    from habilis.learning.algorithms import SoftValueIteration as SoftValueIteration
    from habilis.learning.config import Config as Config
    from habilis.learning.train import train as train
    from habilis.studies.reproduce import reproduce as reproduce
    from habilis.worlds.films import save_film as save_film

__version__ = "0.1.0"

__all__ = [  # what needs no extra: so `from habilis import *` works without one
    "Capacity",
    "ConvergenceWarning",
    "Landscape",
    "Plan",
    "TabularMDP",
    "World",
    "capacity",
    "draw_landscapes",
    "empowerment",
    "landscape",
    "load_world",
    "placement",
    "save_film",
    "save_table",
    "solve",
    "tabulate",
    "to_dataframe",
    "world_names",
]

_HEAVY = {  # imported on first use: Matplotlib and Polars take longer than everything else
    "Landscape": "habilis.empowerment.landscape",
    "draw_landscapes": "habilis.empowerment.landscape_picture",
    "landscape": "habilis.empowerment.landscape",
    "save_film": "habilis.worlds.films",
    "save_table": "habilis.empowerment.tables",
    "to_dataframe": "habilis.empowerment.tables",
}

_LEARNING = {
    **dict.fromkeys(
        ("A2C", "PPO", "QLearning", "SoftValueIteration"), "habilis.learning.algorithms"
    ),
    "Config": "habilis.learning.config",
    "train": "habilis.learning.train",
    "reproduce": "habilis.studies.reproduce",
}


def __getattr__(name: str) -> Any:
    if name in _HEAVY:
        return getattr(import_module(_HEAVY[name]), name)
    if name not in _LEARNING:
        raise AttributeError(f"module 'habilis' has no attribute {name!r}")
    from habilis.extras import import_from

    return getattr(import_from(_LEARNING[name], extra="learn"), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *_HEAVY, *_LEARNING])
