"""Habilis: exact empowerment of finite MDPs, tool-use worlds, and agents that learn with it.

    import habilis as hb

    mdp = hb.tabulate(hb.load_world("corridor"))
    bits = hb.empowerment(mdp, horizon=6, sensor="object")

Public names are listed in `__init__.pyi` and imported on first use. `train`, `Config` and the other
names of `habilis.learning` need the extra `habilis[learn]`, `EmpowermentReward` needs
`habilis[gymnasium]`. Where Gymnasium is installed, the worlds are registered with it:
`gymnasium.make("habilis/Corridor-v0")`.
"""

from importlib.util import find_spec

from habilis.empowerment import empowerment as empowerment  # now: its package has the same name
from habilis.lazy import public

__version__ = "0.3.0"

_OPTIONAL = (
    "habilis.envs",
    "habilis.learning",
    "habilis.studies.reproduction.reproduce",
    "habilis.studio.embedded",
)
__getattr__, _names, __all__ = public(__name__, _OPTIONAL)


def __dir__() -> list[str]:
    return [*_names(), "__version__"]


if find_spec("gymnasium") is not None:
    from habilis.envs.registration import register

    register()
