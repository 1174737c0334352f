"""Robots with tools: a hand, a puck and what the hand holds, in MuJoCo, seen from above."""

from habilis.lazy import public

__getattr__, __dir__, __all__ = public(__name__)
