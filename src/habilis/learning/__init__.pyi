# The public names: `__init__.py` imports each from here on first use.
from habilis.learning.algorithms import ALGORITHMS as ALGORITHMS
from habilis.learning.algorithms.a2c import A2C as A2C
from habilis.learning.algorithms.ppo import PPO as PPO
from habilis.learning.algorithms.protocol import Algorithm as Algorithm
from habilis.learning.algorithms.q_learning import QLearning as QLearning
from habilis.learning.algorithms.soft_value_iteration import (
    SoftValueIteration as SoftValueIteration,
)
from habilis.learning.config import Config as Config
from habilis.learning.curves import Curve as Curve
from habilis.learning.curves import learning_curve as learning_curve
from habilis.learning.curves_picture import curves_figure as curves_figure
from habilis.learning.folder import load_run as load_run
from habilis.learning.presets import preset as preset
from habilis.learning.replay import Episode as Episode
from habilis.learning.replay import Success as Success
from habilis.learning.replay import play as play
from habilis.learning.replay import success as success
from habilis.learning.runner import train as train
from habilis.learning.runs import Run as Run

__all__: list[str]
