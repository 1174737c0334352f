"""Many configurations at once: grids and searches, on one machine or many."""

from habilis.lazy import public

__getattr__, __dir__, __all__ = public(__name__, ("habilis.sweeps.searches",))
