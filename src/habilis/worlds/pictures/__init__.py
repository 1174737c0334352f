"""Pictures of worlds: figures, tiles of pixels, shapes of things, heatmaps, video."""

from habilis.lazy import public

__getattr__, __dir__, __all__ = public(__name__)
