# The public names: `__init__.py` imports each from here on first use.
from habilis.tasks.cluster import on_ray as on_ray
from habilis.tasks.local import processes as processes
from habilis.tasks.session import kept_in as kept_in
from habilis.tasks.shared import Shared as Shared
from habilis.tasks.task import Executor as Executor
from habilis.tasks.task import Task as Task
from habilis.tasks.task import in_turn as in_turn

__all__: list[str]
