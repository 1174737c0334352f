"""Empowerment of simulators, estimated: simulators, estimators, and what both are."""

from habilis.lazy import public

__getattr__, __dir__, __all__ = public(__name__)
