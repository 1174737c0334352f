"""The numbers of a board as code: Python, and a command of a shell, that compute the same."""

import shlex
from collections.abc import Sequence

from habilis.studio.as_code import Written
from habilis.studio.board_scenes import BoardScene
from habilis.studio.boards import PuzzleBoard
from habilis.studio.protocol.scenes import Placement

_PUSHWORLD = ".pwp"


def code(scene: BoardScene, source: str, view: str, placements: Sequence[Placement]) -> Written:
    """The landscape of a puzzle, or the bits along a game of it.

    Args:
        scene: the puzzle and the question.
        source: its file, and after a # which of its levels.
        view: "landscape" or "game".
        placements: of the game, from its start.

    Raises:
        ValueError: it is an environment, whose table has no code yet.
    """
    if not isinstance(scene.board, PuzzleBoard):
        raise ValueError(
            "code is of maps and puzzles; for an environment see TabularMDP.from_gymnasium"
        )
    actions = scene.action_indices
    chosen = "" if actions is None else f", actions={list(actions)}"
    python = ["import habilis as hb", "", f"puzzle = {_loaded(source)}"]
    of = scene.measured
    if view == "landscape" and not of.needs_whole:
        slip = f", slip={scene.slip}" if scene.slip else ""
        asked = f"puzzle, {scene.horizon}, {scene.sensor!r}{chosen}{of.keywords()}{slip}"
        python += [f"landscape = hb.landscape({asked})", "print(landscape.values)"]
        command = ["habilis", "landscape", source, "--horizon", str(scene.horizon)]
        command += ["--sensor", scene.sensor]
        command += [] if actions is None else ["--actions", ",".join(map(str, actions))]
        command += of.options()
        command += ["--slip", str(scene.slip)] if scene.slip else []
        return Written("\n".join(python) + "\n", shlex.join(command) + "\n")
    cells = list(scene.agents)
    states = [scene.where(placement) for placement in placements] or [scene.board.start]
    if view == "landscape":
        states = list(scene.agents.values())
    slip = f".slippery({scene.slip})" if scene.slip else ""
    reach = "" if of.needs_whole else f", {scene.horizon}"
    python += [f"states = {states}", f"mdp = hb.explore(puzzle, states{reach}){slip}"]
    python += ["indices = [mdp.index(state) for state in states]"]
    asked = of.expression("mdp", scene.horizon, repr(scene.sensor), chosen, "indices")
    python += [f"bits = {asked}"]
    if view == "landscape":
        python += [f"cells = {cells}", "print(dict(zip(cells, bits.tolist())))"]
    else:
        python += ["print(bits)"]
    return Written("\n".join(python) + "\n", None)


def _loaded(source: str) -> str:
    """The expression that reads a puzzle."""
    if source.endswith(_PUSHWORLD):
        return f"hb.load_pushworld({source!r})"
    path, _, level = source.partition("#")
    return f"hb.load_sokoban({path!r}, {int(level or 0)})"
