"""Films of placements, by the library's own pictures."""

import base64
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from habilis.studio.protocol.scenes import Placement
from habilis.studio.scenes import Scene
from habilis.worlds.pictures.video import save_gif
from habilis.worlds.placements import placed_at

_SIDE = 640  # pixels, of the larger side, about
_CELLS = 12, 48  # pixels of a cell


def film(scene: Scene, placements: Sequence[Placement]) -> dict[str, Any]:
    """A GIF of placements of the scene's world, one after the other, as base64."""
    world = scene.world
    states = [placed_at(world, scene.where(placement)) for placement in placements]
    least, most = _CELLS
    cell = min(max(_SIDE // max(world.height, world.width), least), most)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "film.gif"
        save_gif(states, path, cell)
        return {"gif": base64.b64encode(path.read_bytes()).decode()}
