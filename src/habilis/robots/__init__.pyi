# The public names: `__init__.py` imports each from here on first use.
from habilis.robots.comparison import ToolComparison as ToolComparison
from habilis.robots.comparison import compare_tools as compare_tools
from habilis.robots.environment import PushingEnv as PushingEnv
from habilis.robots.films import push_scenes as push_scenes
from habilis.robots.landscapes import draw_comparison as draw_comparison
from habilis.robots.placements import Placements as Placements
from habilis.robots.placements import puck_placements as puck_placements
from habilis.robots.plans import push_plan as push_plan
from habilis.robots.pushing import PushingSimulator as PushingSimulator
from habilis.robots.reach import Reach as Reach
from habilis.robots.scene import push_scene as push_scene
from habilis.robots.tools import tools_of as tools_of

__all__: list[str]
