# The public names: `__init__.py` imports each from here on first use.
from habilis.estimators.actions import ActionBox as ActionBox
from habilis.estimators.counting import Counting as Counting
from habilis.estimators.evaluation.case import Case as Case
from habilis.estimators.evaluation.case import case_names as case_names
from habilis.estimators.evaluation.case import suite as suite
from habilis.estimators.evaluation.contestants import contestants as contestants
from habilis.estimators.evaluation.evaluate import evaluate as evaluate
from habilis.estimators.following import Followed as Followed
from habilis.estimators.following import follow as follow
from habilis.estimators.gaussian import Gaussian as Gaussian
from habilis.estimators.gaussian import GaussianChannels as GaussianChannels
from habilis.estimators.gridded import Gridded as Gridded
from habilis.estimators.gridded import OnGrid as OnGrid
from habilis.estimators.gridded import on_grid as on_grid
from habilis.estimators.learned.contrastive import Contrastive as Contrastive
from habilis.estimators.learned.variational import Variational as Variational
from habilis.estimators.monte_carlo import MonteCarlo as MonteCarlo
from habilis.estimators.plug_in import PlugInInterval as PlugInInterval
from habilis.estimators.plug_in import plug_in_interval as plug_in_interval
from habilis.estimators.protocol import Estimator as Estimator
from habilis.estimators.protocol import Fitted as Fitted
from habilis.estimators.protocol import Simulator as Simulator
from habilis.estimators.samplers import FirstAction as FirstAction
from habilis.estimators.samplers import RandomSequences as RandomSequences
from habilis.estimators.samplers import VarianceProxy as VarianceProxy

from . import simulators as simulators

__all__: list[str]
