"""Measures built on empowerment: averages, landscapes, pairs, influence, futures, and pictures."""

from habilis.analysis.averages import average_empowerment, compare, ranking
from habilis.analysis.data_frames import save_table, to_dataframe
from habilis.analysis.futures import Futures, futures, futures_figure
from habilis.analysis.influence import influence_range, latency, reliability
from habilis.analysis.landscape import landscape, landscape_of
from habilis.analysis.landscape_values import Landscape, draw_landscapes
from habilis.analysis.motivations import music, occupancy_entropy, skill_discriminability
from habilis.analysis.novelty import count_novelty
from habilis.analysis.occupancy import occupancy
from habilis.analysis.pairs import Pairs, pairs
from habilis.analysis.tool_ranking import tool_ranking
from habilis.analysis.usefulness import Usefulness, usefulness
from habilis.analysis.variational import VariationalBound, variational_bound

__all__ = [
    "Futures",
    "Landscape",
    "Pairs",
    "Usefulness",
    "VariationalBound",
    "average_empowerment",
    "compare",
    "count_novelty",
    "draw_landscapes",
    "futures",
    "futures_figure",
    "influence_range",
    "landscape",
    "landscape_of",
    "latency",
    "music",
    "occupancy",
    "occupancy_entropy",
    "pairs",
    "ranking",
    "reliability",
    "save_table",
    "skill_discriminability",
    "to_dataframe",
    "tool_ranking",
    "usefulness",
    "variational_bound",
]
