"""Learning with empowerment in the reward: algorithms, many runs at once, checkpoints, replay."""

from habilis.lazy import public

__getattr__, __dir__, __all__ = public(__name__)
