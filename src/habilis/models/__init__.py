"""Models: everything that says where actions lead, and the table of what can be reached."""

from habilis.models.explore import explore
from habilis.models.limits import TooManyStatesError
from habilis.models.protocol import Model, VectorModel

__all__ = ["Model", "TooManyStatesError", "VectorModel", "explore"]
