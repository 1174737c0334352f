"""Exact empowerment of finite MDPs: sensors, channels, counting, and measures made of them."""

from habilis.empowerment.core import empowerment

__all__ = ["empowerment"]
