"""The world that a notebook shares with the pages embedded in it."""

import asyncio
from collections.abc import Awaitable, Callable
from dataclasses import replace
from threading import Lock

import msgspec

from habilis.studio.drawn_worlds import drawn_of
from habilis.studio.protocol.hello import Show, Shown
from habilis.studio.scenes import check_size
from habilis.worlds.world import World

Send = Callable[[str], Awaitable[None]]


class SharedWorld:
    """The latest world: set by the notebook's thread, edited by pages in the server's.

    An edit of a world that the notebook has replaced meanwhile is ignored: whoever sets a world and
    reads it gets the one that was set.
    """

    def __init__(self, world: World):
        self._lock = Lock()
        self._world, self._shown = world, _shown(world, 0)
        self._pages: dict[Send, asyncio.AbstractEventLoop] = {}

    @property
    def world(self) -> World:
        return self._world

    @property
    def shown(self) -> Shown:
        """The world as pages have it."""
        return self._shown

    def enter(self, send: Send) -> None:
        """From now on a page gets the worlds that the notebook sets."""
        self._pages[send] = asyncio.get_running_loop()

    def leave(self, send: Send) -> None:
        self._pages.pop(send, None)

    def show(self, world: World) -> None:
        """Sets the world, and shows it on all pages.

        Raises:
            ValueError: pages cannot show it; naming why.
        """
        with self._lock:
            self._shown = _shown(world, self._shown.number + 1)
            self._world = world
            text = msgspec.json.encode(Show(self._shown)).decode()
        for send, loop in list(self._pages.items()):
            loop.call_soon_threadsafe(lambda send=send: asyncio.ensure_future(send(text)))

    def edit(self, world: World, number: int) -> None:
        """Takes over the world of a page.

        Args:
            world: the edited one.
            number: that of the notebook's world that was edited.
        """
        with self._lock:
            drawn = drawn_of(world)
            if number == self._shown.number and drawn != self._shown.drawn:
                self._world = replace(world, name=self._world.name)
                self._shown = Shown(drawn, number)


def _shown(world: World, number: int) -> Shown:
    check_size(world)
    return Shown(drawn_of(world), number)
