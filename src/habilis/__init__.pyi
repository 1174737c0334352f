# The public names: `__init__.py` imports each from here on first use.
from habilis.analysis import Landscape as Landscape
from habilis.analysis import Pairs as Pairs
from habilis.analysis import compare as compare
from habilis.analysis import draw_landscapes as draw_landscapes
from habilis.analysis import landscape as landscape
from habilis.analysis import pairs as pairs
from habilis.analysis import save_table as save_table
from habilis.analysis import to_dataframe as to_dataframe
from habilis.analysis import tool_ranking as tool_ranking
from habilis.bridges import load_pushworld as load_pushworld
from habilis.bridges import load_sokoban as load_sokoban
from habilis.bridges.cassandra import POMDP as POMDP
from habilis.bridges.cassandra import load_pomdp as load_pomdp
from habilis.channels import Capacity as Capacity
from habilis.channels import ConvergenceWarning as ConvergenceWarning
from habilis.channels import capacity as capacity
from habilis.empowerment import Exact as Exact
from habilis.empowerment import Sampled as Sampled
from habilis.empowerment import empowerment as empowerment
from habilis.empowerment import persistence as persistence
from habilis.envs import EmpowermentReward as EmpowermentReward
from habilis.learning import A2C as A2C
from habilis.learning import PPO as PPO
from habilis.learning import Config as Config
from habilis.learning import QLearning as QLearning
from habilis.learning import SoftValueIteration as SoftValueIteration
from habilis.learning import preset as preset
from habilis.learning import train as train
from habilis.mdp import TabularMDP as TabularMDP
from habilis.models import Model as Model
from habilis.models import VectorModel as VectorModel
from habilis.models import explore as explore
from habilis.studies.reproduction.reproduce import reproduce as reproduce
from habilis.worlds import Plan as Plan
from habilis.worlds import Tool as Tool
from habilis.worlds import World as World
from habilis.worlds import check_tool as check_tool
from habilis.worlds import load_world as load_world
from habilis.worlds import placement as placement
from habilis.worlds import solve as solve
from habilis.worlds import tabulate as tabulate
from habilis.worlds import world_names as world_names
from habilis.worlds.pictures import save_video as save_video

from . import analysis as analysis
from . import bridges as bridges
from . import channels as channels
from . import envs as envs
from . import learning as learning
from . import models as models
from . import rewards as rewards
from . import studies as studies
from . import sweeps as sweeps
from . import worlds as worlds

__version__: str
__all__: list[str]
