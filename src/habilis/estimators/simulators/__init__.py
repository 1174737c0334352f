"""Worlds of vectors: tables, functions of JAX, MuJoCo models, and a few classics."""

from habilis.lazy import public

__getattr__, __dir__, __all__ = public(__name__)
