"""Films of placements, by the library's own pictures."""

import base64
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from habilis.studio.board_scenes import BoardScene
from habilis.studio.boards import PuzzleBoard
from habilis.studio.protocol.scenes import Placement
from habilis.studio.scenes import AnyScene, Scene
from habilis.worlds.pictures.video import save_gif
from habilis.worlds.placements import placed_at

_SIDE = 640  # pixels, of the larger side, about
_CELLS = 12, 48  # pixels of a cell


def film(scene: AnyScene, placements: Sequence[Placement]) -> dict[str, Any]:
    """A GIF of placements of the scene's world or puzzle, one after the other, as base64.

    Raises:
        ValueError: it is an environment, of which the studio has single pictures only.
    """
    states: Any
    if isinstance(scene, Scene):
        states = [placed_at(scene.world, scene.where(one)) for one in placements]
    elif isinstance(scene, BoardScene) and isinstance(scene.board, PuzzleBoard):
        states = [scene.board.puzzle.at(scene.where(one)) for one in placements]
    else:
        raise ValueError("films are of maps and puzzles; record an environment with Gymnasium")
    least, most = _CELLS
    cell = min(max(_SIDE // max(scene.height, scene.width), least), most)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "film.gif"
        save_gif(states, path, cell)
        return {"gif": base64.b64encode(path.read_bytes()).decode()}
