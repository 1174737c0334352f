"""Models that others wrote, as models and tables."""

from habilis.lazy import public

__getattr__, __dir__, __all__ = public(__name__)
