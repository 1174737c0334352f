"""Habilis: exact empowerment of finite MDPs, tool-use worlds, and agents that learn with it.

    import habilis as hb

    mdp = hb.tabulate(hb.load_world("corridor"))
    bits = hb.empowerment(mdp, horizon=6, sensor="object")

The learning half (`train`, `Config`, `reproduce`) is imported on first use and needs the extra
`habilis[learn]`, as `EmpowermentReward` needs `habilis[gymnasium]`. Where Gymnasium is installed,
the worlds are registered with it: `gymnasium.make("habilis/Corridor-v0")`.
"""

from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from habilis.channels.capacity import Capacity, ConvergenceWarning, capacity
from habilis.empowerment import empowerment
from habilis.mdp import TabularMDP
from habilis.worlds.check_tool import check_tool
from habilis.worlds.plans import Plan, solve
from habilis.worlds.table import placement, tabulate
from habilis.worlds.tools import Tool
from habilis.worlds.world import World, load_world, world_names

if TYPE_CHECKING:
    from habilis.analysis.data_frames import save_table as save_table
    from habilis.analysis.data_frames import to_dataframe as to_dataframe
    from habilis.analysis.landscape import Landscape as Landscape
    from habilis.analysis.landscape import draw_landscapes as draw_landscapes
    from habilis.analysis.landscape import landscape as landscape
    from habilis.analysis.pairs import Pairs as Pairs
    from habilis.analysis.pairs import pairs as pairs
    from habilis.empowerment.tabular.persistence import persistence as persistence
    from habilis.envs.reward import EmpowermentReward as EmpowermentReward
    from habilis.learning.algorithms import A2C as A2C
    from habilis.learning.algorithms import PPO as PPO
    from habilis.learning.algorithms import QLearning as QLearning
    from habilis.learning.algorithms import SoftValueIteration as SoftValueIteration
    from habilis.learning.config import Config as Config
    from habilis.learning.presets import preset as preset
    from habilis.learning.train import train as train
    from habilis.studies.reproduction.reproduce import reproduce as reproduce
    from habilis.worlds.pictures.video import save_film as save_film

__version__ = "0.1.0"

__all__ = [  # what needs no extra: so `from habilis import *` works without one
    "Capacity",
    "ConvergenceWarning",
    "Landscape",
    "Pairs",
    "Plan",
    "TabularMDP",
    "Tool",
    "World",
    "capacity",
    "check_tool",
    "draw_landscapes",
    "empowerment",
    "landscape",
    "load_world",
    "pairs",
    "persistence",
    "placement",
    "save_film",
    "save_table",
    "solve",
    "tabulate",
    "to_dataframe",
    "world_names",
]

_LAZY = {  # imported on first use: by name, the module, and the extra that it needs if any
    "Landscape": ("habilis.analysis.landscape", None),
    "Pairs": ("habilis.analysis.pairs", None),
    "draw_landscapes": ("habilis.analysis.landscape", None),
    "landscape": ("habilis.analysis.landscape", None),
    "pairs": ("habilis.analysis.pairs", None),
    "persistence": ("habilis.empowerment.tabular.persistence", None),
    "save_film": ("habilis.worlds.pictures.video", None),
    "save_table": ("habilis.analysis.data_frames", None),
    "to_dataframe": ("habilis.analysis.data_frames", None),
    "EmpowermentReward": ("habilis.envs.reward", "gymnasium"),
    **dict.fromkeys(
        ("A2C", "PPO", "QLearning", "SoftValueIteration"), ("habilis.learning.algorithms", "learn")
    ),
    "Config": ("habilis.learning.config", "learn"),
    "preset": ("habilis.learning.presets", "learn"),
    "train": ("habilis.learning.train", "learn"),
    "reproduce": ("habilis.studies.reproduction.reproduce", "learn"),
}

if find_spec("gymnasium") is not None:
    from habilis.registration import register

    register()


def __getattr__(name: str) -> Any:
    if name not in _LAZY:
        raise AttributeError(f"module 'habilis' has no attribute {name!r}")
    from habilis.extras import import_from

    module, extra = _LAZY[name]
    return getattr(import_module(module) if extra is None else import_from(module, extra), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *_LAZY])
