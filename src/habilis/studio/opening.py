"""The source that a studio is started with: a run, a world, a puzzle or an environment."""

import base64
import io
import os
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np
from jaxtyping import UInt8

from habilis.bridges.puzzles.pushworld import PushWorld
from habilis.bridges.puzzles.shapes import (
    AGENT_WALL,
    agent_drawing,
    body_colours,
    goal_drawing,
    movable_drawing,
)
from habilis.bridges.puzzles.sokoban import names_puzzle, puzzle_named
from habilis.extras import import_from
from habilis.mdp import TabularMDP
from habilis.studio.boards import Board, PuzzleBoard, TableBoard
from habilis.studio.drawn_worlds import drawn_of
from habilis.studio.limits import BOARD_SIDE, BOARD_STATES, FACTORS, THINGS
from habilis.studio.protocol.hello import BoardAbout, Movable, RunAbout, Still
from habilis.studio.scenes import check_size
from habilis.worlds.map_text import FLOOR, WALL
from habilis.worlds.pictures.shapes import Drawing
from habilis.worlds.world import ENVIRONMENT, World, load_world

_PIXELS = 32  # of a cell of Minigrid
_KEPT = 512  # pictures


@dataclass(frozen=True)
class Opened:
    """The source of a studio.

    Attributes:
        run: the folder of a trained run, and `about_run`, its description.
        world: the map to begin with.
        board: a puzzle or environment, and `about`, its description.
        image: the picture of one of its states as a data URI, if it is drawn by images.
        source: the board's file or ID.
    """

    run: Path | None = None
    about_run: RunAbout | None = None
    world: World | None = None
    board: Board | None = None
    about: BoardAbout | None = None
    image: Callable[[int], str] | None = None
    source: str = ""


def open_source(source: str | None, folder: Path) -> Opened:
    """Opens what the command line names.

    Args:
        source: a trained run's folder, a world or its file, a puzzle's file, or "gym:ID".
        folder: for the table of an environment.

    Raises:
        ValueError: there is none such, it has no picture of a grid, or it is too large.
    """
    if source is None:
        return Opened()
    if names_puzzle(source):
        puzzle = puzzle_named(source)
        assert puzzle is not None
        return replace(_of_puzzle(puzzle), source=source)
    if source.startswith(ENVIRONMENT):
        return replace(_of_environment(source, folder), source=source)
    if not Path(source).is_dir():
        return Opened(world=_small(load_world(source)))
    about = import_from("habilis.studio.run_steps", "learn").summary_of(Path(source))
    return Opened(run=Path(source), about_run=about)


def _small(world: World) -> World:
    check_size(world)
    if max(len(world.tools), len(world.objects)) > THINGS:
        raise ValueError(f"{world.name}: the studio shows up to {THINGS} tools and objects")
    drawn_of(world)  # raises if a page cannot show it
    return world


def _check_size(name: str, height: int, width: int, factors: int) -> None:
    if max(height, width) > BOARD_SIDE:
        raise ValueError(
            f"{name}: has {height} x {width} cells; the studio shows up to {BOARD_SIDE} a side: "
            "use habilis landscape"
        )
    if factors > FACTORS:
        raise ValueError(f"{name}: has {factors} factors; the studio shows up to {FACTORS}")


def _of_puzzle(puzzle: PushWorld) -> Opened:
    board = PuzzleBoard(puzzle)
    _check_size(puzzle.name, puzzle.height, puzzle.width, len(board.factors))
    colours, corner = body_colours(puzzle), (0, 0)
    bodies = {body.name: body for body in puzzle.bodies}
    goals = [
        (goal, goal_drawing(first, colours[first.name], corner, len(goal.bodies) == 1))
        for goal in puzzle.goals
        for first in [bodies[goal.bodies[0]]]
    ]
    agent = puzzle.bodies[0]
    large_agent = _parts(agent_drawing(agent.covered(corner))) if len(agent.cells) > 1 else []
    about = BoardAbout(
        name=board.name,
        ground=_ground(puzzle),
        actions=list(board.actions),
        factors=list(board.factors),
        start=board.placement(board.start),
        random=False,
        agent=Movable("agent", large_agent, None, []),
        objects=[
            Movable(
                body.name,
                _parts(movable_drawing(body, colours[body.name], corner, False)),
                _parts(movable_drawing(body, colours[body.name], corner, True)),
                [goal.corner for goal in puzzle.goals if body.name in goal.bodies],
            )
            for body in puzzle.bodies[1:]
        ],
        still=[
            *(Still(cell, _parts(AGENT_WALL)) for cell in sorted(puzzle.agent_walls)),
            *(Still(goal.corner, _parts(drawing)) for goal, drawing in goals),
        ],
        states=None,
        image=None,
    )
    return Opened(board=board, about=about)


def _ground(puzzle: PushWorld) -> str:
    return "\n".join(
        "".join(WALL if (row, column) in puzzle.walls else FLOOR for column in range(puzzle.width))
        for row in range(puzzle.height)
    )


def _parts(drawing: Drawing) -> list[tuple[str, str]]:
    return [(shape.path, shape.fill) for shape in drawing]


def _of_environment(source: str, folder: Path) -> Opened:
    os.environ.setdefault("SDL_VIDEODRIVER", "dummy")  # pygame draws into memory alone
    named = import_from("habilis.bridges.gymnasium.named", "gymnasium")
    identity = _with_images(source.removeprefix(ENVIRONMENT))
    mdp = named.table_named(identity, BOARD_STATES, show_progress=sys.stderr.isatty())
    pictures = Pictures(source, mdp)
    first = pictures.array(mdp.start)
    height, width, agent = pictures.grid()
    _check_size(source, height, width, len(mdp.factors))
    if first.shape[0] * width != first.shape[1] * height:
        raise ValueError(f"{source}: its picture is not one of {height} x {width} square cells")
    path = folder / "board.npz"
    mdp.save(path)
    factors = (agent, *(name for name in mdp.factors if name != agent))
    board = TableBoard(
        name=source,
        height=height,
        width=width,
        actions=mdp.actions or tuple(map(str, range(mdp.action_count))),
        factors=factors,
        cells=frozenset(_cells(mdp, agent)),
        random=mdp.is_stochastic,
        first=mdp.start,
        agent=agent,
        path=str(path),
    )
    about = BoardAbout(
        name=board.name,
        ground="\n".join([FLOOR * width] * height),
        actions=list(board.actions),
        factors=list(factors),
        start=board.placement(board.start),
        random=board.random,
        agent=Movable("agent", [], None, []),
        objects=[],
        still=[],
        states=mdp.states,
        image=pictures.uri(mdp.start),
    )
    return Opened(board=board, about=about, image=pictures.uri)


def _with_images(name: str) -> str:
    """The name of an environment that can be drawn, with its own render mode if it has one."""
    if "render_mode=" in name or "minigrid" in name.lower():  # Minigrid needs none
        return name
    return f"{name}{'&' if '?' in name else '?'}render_mode=rgb_array"


def _cells(mdp: TabularMDP, agent: str) -> list[str]:
    """The factors whose labels are cells."""
    if mdp.shape is not None:
        return [name for name in mdp.factors if mdp.is_cell(name)]
    others = ("direction", "carried")  # of Minigrid
    return [agent, *(n for n in mdp.factors if n not in (agent, *others) and "door" not in n)]


class Pictures:
    """The pictures of an environment's states, drawn by itself.

    Attributes:
        name: of the environment.
        mdp: its table, which leads back to it.
    """

    def __init__(self, name: str, mdp: TabularMDP):
        self.name, self.mdp = name, mdp
        self._one_at_a_time = Lock()
        self.uri = lru_cache(_KEPT)(self._uri)

    def grid(self) -> tuple[int, int, str]:
        """Rows, columns, and the factor of the agent's cell.

        Raises:
            ValueError: it has no such grid.
        """
        inner = self._restored(self.mdp.start).unwrapped
        if "agent" in self.mdp.factors:
            if self.mdp.shape is not None:
                return *self.mdp.shape, "agent"
            if hasattr(inner, "grid"):
                return int(inner.height), int(inner.width), "agent"
        raise ValueError(
            f"{self.name}: the studio shows environments that have a factor agent on a grid, such "
            "as Minigrid and FrozenLake; use habilis empowerment"
        )

    def array(self, state: int) -> UInt8[np.ndarray, "height width 3"]:
        """The picture of a state.

        Raises:
            ValueError: the environment does not draw itself.
        """
        env = self._restored(state)
        inner: Any = env.unwrapped
        try:
            if hasattr(inner, "get_frame"):
                found = inner.get_frame(highlight=False, tile_size=_PIXELS)
            else:
                found = env.render()
            return np.asarray(found, np.uint8).reshape(*np.shape(found)[:2], 3)
        except Exception as error:  # by code of others
            reason = (str(error).splitlines() or [type(error).__name__])[0]
            raise ValueError(
                f"{self.name}: has no picture ({reason}); the studio shows environments that "
                "render as rgb_array"
            ) from None

    def _restored(self, state: int) -> Any:
        assert self.mdp.origin is not None
        return self.mdp.origin.restore(state)

    def _uri(self, state: int) -> str:
        from PIL import Image

        with self._one_at_a_time:
            pixels = self.array(state)
        file = io.BytesIO()
        Image.fromarray(pixels).save(file, "PNG")
        return f"data:image/png;base64,{base64.b64encode(file.getvalue()).decode()}"
