# The public names: `__init__.py` imports each from here on first use.
from habilis.envs.estimated_reward import EstimatedReward as EstimatedReward
from habilis.envs.functional import FunctionalEnv as FunctionalEnv
from habilis.envs.observations import Observation as Observation
from habilis.envs.params import Empowerment as Empowerment
from habilis.envs.params import Params as Params
from habilis.envs.params import State as State
from habilis.envs.pushworld import PushWorldEnv as PushWorldEnv
from habilis.envs.pushworld import PushWorldVectorEnv as PushWorldVectorEnv
from habilis.envs.reward import EmpowermentReward as EmpowermentReward
from habilis.envs.reward import VectorEmpowermentReward as VectorEmpowermentReward
from habilis.envs.table import TableEnv as TableEnv
from habilis.envs.vector import TableVectorEnv as TableVectorEnv
from habilis.envs.world import WorldEnv as WorldEnv
from habilis.envs.world import WorldVectorEnv as WorldVectorEnv

__all__: list[str]
