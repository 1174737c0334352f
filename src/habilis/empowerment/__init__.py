"""Exact empowerment of finite MDPs, its sensors, and the algorithms for tables."""

from habilis.empowerment.api import empowerment as empowerment  # now: `habilis` imports it
from habilis.lazy import public

__getattr__, __dir__, __all__ = public(__name__)
