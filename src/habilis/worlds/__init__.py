"""Worlds: map text -> `World` -> `TabularMDP`; the tools and their rule; pictures."""

from habilis.worlds.check_tool import check_tool
from habilis.worlds.plans import Plan, solve
from habilis.worlds.table import placement, tabulate
from habilis.worlds.things import Door, PlacedObject, PlacedTool, Vacancy
from habilis.worlds.tools import Tool
from habilis.worlds.world import World, load_world, world_names

__all__ = [
    "Door",
    "PlacedObject",
    "PlacedTool",
    "Plan",
    "Tool",
    "Vacancy",
    "World",
    "check_tool",
    "load_world",
    "placement",
    "solve",
    "tabulate",
    "world_names",
]
