"""Gymnasium environments made of tables, and empowerment in the reward of any environment.

`import habilis` registers "habilis/Corridor-v0", "habilis/Yard-v0" and "habilis/World-v0".
"""

from habilis.envs.observations import Observation
from habilis.envs.reward import EmpowermentReward, VectorEmpowermentReward
from habilis.envs.table import TableEnv
from habilis.envs.vector import TableVectorEnv
from habilis.envs.world import WorldEnv, WorldVectorEnv

__all__ = [
    "EmpowermentReward",
    "Observation",
    "TableEnv",
    "TableVectorEnv",
    "VectorEmpowermentReward",
    "WorldEnv",
    "WorldVectorEnv",
]
