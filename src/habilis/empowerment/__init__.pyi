# The public names: `__init__.py` imports each from here on first use.
from habilis.empowerment.api import empowerment as empowerment
from habilis.empowerment.assisting import assistance as assistance
from habilis.empowerment.closed_loop import closed_loop_empowerment as closed_loop_empowerment
from habilis.empowerment.effective import effective_empowerment as effective_empowerment
from habilis.empowerment.goal_directed import (
    goal_directed_empowerment as goal_directed_empowerment,
)
from habilis.empowerment.horizons import empowerment_by_horizon as empowerment_by_horizon
from habilis.empowerment.methods import Exact as Exact
from habilis.empowerment.methods import Sampled as Sampled
from habilis.empowerment.tabular.persistence import persistence as persistence

__all__: list[str]
