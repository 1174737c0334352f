# The public names: `__init__.py` imports each from here on first use.
from habilis.estimators.simulators.classics import ball_in_box as ball_in_box
from habilis.estimators.simulators.classics import cart_pole as cart_pole
from habilis.estimators.simulators.classics import double_integrator as double_integrator
from habilis.estimators.simulators.classics import linear_system as linear_system
from habilis.estimators.simulators.classics import pendulum as pendulum
from habilis.estimators.simulators.finite import FiniteSimulator as FiniteSimulator
from habilis.estimators.simulators.gymnasium_mujoco import (
    gymnasium_simulator as gymnasium_simulator,
)
from habilis.estimators.simulators.jax_function import JaxSimulator as JaxSimulator
from habilis.estimators.simulators.metered import Metered as Metered
from habilis.estimators.simulators.mujoco import MujocoSimulator as MujocoSimulator
from habilis.estimators.simulators.scenes import Scene as Scene

__all__: list[str]
