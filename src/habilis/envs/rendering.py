"""Pictures and text of a world's states, and a window for the pictures."""

import io
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import UInt8

from habilis.envs.observations import Show, frames
from habilis.extras import import_from
from habilis.mdp import TabularMDP
from habilis.worlds.table import placement
from habilis.worlds.world import World

if TYPE_CHECKING:
    from rich.text import Text

MODES = ("ansi", "rgb_array", "human")
FRAMES_PER_SECOND = 4
_CELL = 32  # pixels a cell of a picture


@dataclass(frozen=True)
class Renderer:
    """The states of a world as text or pictures.

    Attributes:
        world: the map.
        mdp: its table.
        draw: pictures of states; `None` unless the mode shows them.
    """

    world: World
    mdp: TabularMDP
    draw: Show | None

    @classmethod
    def of(cls, world: World, mdp: TabularMDP, mode: str | None) -> "Renderer":
        draw = None if mode in (None, "ansi") else frames(mdp, world, _CELL)
        return cls(world, mdp, draw)

    def text(self, state: int) -> str:
        """The map in the colours of a terminal, two characters a cell."""
        from habilis.worlds.pictures.figures import colored_text

        return in_terminal(colored_text(placement(self.world, self.mdp, state)))

    def picture(self, states: Any) -> UInt8[np.ndarray, "*n height width 3"]:
        assert self.draw is not None, "pictures are made in the modes that show them"
        return self.draw(states)


def in_terminal(text: "Text") -> str:
    """A text with the codes of its colours."""
    from rich.console import Console

    terminal = Console(
        file=io.StringIO(), force_terminal=True, color_system="truecolor", highlight=False
    )
    with terminal.capture() as captured:
        terminal.print(text, soft_wrap=True)
    return captured.get()


def check_mode(mode: Any) -> None:
    """Raises ValueError: no such render mode."""
    if mode is not None and mode not in MODES:
        raise ValueError(f"render_mode {mode!r} is unknown; use one of {', '.join(MODES)}")


class Window:
    """A window, opened with the first picture that it shows."""

    def __init__(self, title: str):
        """
        Raises:
            MissingExtraError: pygame is not installed.
        """
        self._pygame = import_from("pygame", extra="gymnasium")
        self._title = title
        self._surface = None

    def show(self, picture: UInt8[np.ndarray, "height width 3"]) -> None:
        """Shows a picture, and waits until the one before has been there for its time."""
        pygame = self._pygame
        if self._surface is None:
            pygame.display.init()
            self._surface = pygame.display.set_mode(picture.shape[1::-1])
            pygame.display.set_caption(self._title)
            self._clock = pygame.time.Clock()
        pygame.event.pump()  # or the system takes the window for one that hangs
        pygame.surfarray.blit_array(self._surface, picture.swapaxes(0, 1))
        pygame.display.flip()
        self._clock.tick(FRAMES_PER_SECOND)

    def close(self) -> None:
        self._pygame.display.quit()
