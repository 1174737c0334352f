"""A window that shows pictures."""

import numpy as np
from jaxtyping import UInt8

from habilis.extras import import_from


class Screen:
    """A window, opened with the first picture that it shows."""

    def __init__(self, title: str, frames_a_second: int):
        """
        Raises:
            MissingExtraError: pygame is not installed.
        """
        self._pygame = import_from("pygame", extra="gymnasium")
        self._title, self._frames_a_second = title, frames_a_second
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
        self._clock.tick(self._frames_a_second)

    def close(self) -> None:
        self._pygame.display.quit()
