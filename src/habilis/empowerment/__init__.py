"""Exact empowerment of finite MDPs: sensors, channels, counting, and measures made of them."""

from habilis.empowerment.api import empowerment

__all__ = ["empowerment"]
