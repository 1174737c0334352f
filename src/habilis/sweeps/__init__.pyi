# The public names: `__init__.py` imports each from here on first use.
from habilis.sweeps.grids import sweep as sweep
from habilis.sweeps.searches import search as search
from habilis.sweeps.spec import read_spec as read_spec
from habilis.sweeps.store import results as results

__all__: list[str]
