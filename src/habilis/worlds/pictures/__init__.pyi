# The public names: `__init__.py` imports each from here on first use.
from habilis.worlds.pictures.figures import save_figure as save_figure
from habilis.worlds.pictures.figures import save_picture as save_picture
from habilis.worlds.pictures.figures import world_figure as world_figure
from habilis.worlds.pictures.shapes import Shape as Shape
from habilis.worlds.pictures.tiles import Tiles as Tiles
from habilis.worlds.pictures.video import save_video as save_video

__all__: list[str]
