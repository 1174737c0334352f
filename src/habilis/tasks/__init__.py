"""Many independent computations: kept, resumed, on local processes or a Ray cluster."""

from habilis.lazy import public

__getattr__, __dir__, __all__ = public(__name__, ("habilis.tasks.cluster", "habilis.tasks.session"))
