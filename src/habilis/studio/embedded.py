"""`open_studio`: the studio in a cell of a notebook."""

import atexit
import tempfile
from contextlib import ExitStack
from html import escape
from pathlib import Path
from threading import Thread
from time import sleep
from types import TracebackType

from habilis.studio.security import EMBEDDED
from habilis.studio.server import opened, server_of
from habilis.studio.shared_world import SharedWorld
from habilis.worlds.world import World, load_world

_LOOPBACK = "127.0.0.1"
_FIRST = "yard"
_STARTS, _ENDS = 0.01, 10.0  # seconds between looks at the server, and that it has to end


class NotebookStudio:
    """A studio embedded in a notebook, which shows it as the result of a cell.

    Made by `open_studio`. The page and the notebook share a world. The server is a thread of this
    process; `close`, the end of a `with` block or of the process ends it.

    Attributes:
        address: of the page, with the token that it needs.
        height: of the frame in the notebook, in pixels.
    """

    def __init__(
        self, shared: SharedWorld, height: int, base_path: str, trusted_origin: str | None
    ):
        self.height = height
        self._shared = shared
        trusted = () if trusted_origin is None else (trusted_origin,)
        self._held = ExitStack()
        folder = self._held.enter_context(
            tempfile.TemporaryDirectory(prefix="habilis-studio-", ignore_cleanup_errors=True)
        )
        try:
            studio, found = opened(
                *(_LOOPBACK, 0, Path(folder), shared.world.own_tools, None, None),
                *(base_path, trusted, shared),
            )
        except ValueError:
            self._held.close()
            raise
        self.address = f"{studio.access.address(_LOOPBACK)}&{EMBEDDED}=1"
        self._tools = studio.all_tools
        self._server = server_of(studio)
        # A daemon, because the interpreter waits for other threads before it calls `close`.
        self._thread = Thread(target=self._server.run, args=([found],), daemon=True)
        self._thread.start()
        atexit.register(self.close)
        while not self._server.started and self._thread.is_alive():
            sleep(_STARTS)

    @property
    def world(self) -> World:
        """The world on the page. Set another, and the page shows it.

        Raises:
            ValueError: on setting one that the page cannot show.
        """
        return self._shared.world

    @world.setter
    def world(self, world: World) -> None:
        if not isinstance(world, World):
            raise ValueError(f"world is {world!r:.80}; give a World, as load_world makes one")
        for tool in world.own_tools:
            if tool not in self._tools:
                raise ValueError(
                    f"{world.name}: this studio does not offer the tool {tool!r}; "
                    "open another with open_studio(world)"
                )
        self._shared.show(world)

    @property
    def closed(self) -> bool:
        """Whether its server has ended."""
        return not self._thread.is_alive()

    def close(self) -> None:
        """Ends the server and its processes; `world` stays as it is."""
        self._server.should_exit = True
        self._thread.join(_ENDS)
        self._held.close()
        atexit.unregister(self.close)

    def __enter__(self) -> "NotebookStudio":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        where = "closed" if self.closed else f"open at {self.address}"
        return f"<NotebookStudio of {self.world.name}: {where}>"

    def _repr_html_(self) -> str:
        """The page in a frame, for notebooks."""
        if self.closed:
            return "<p>This studio is closed.</p>"
        return (
            f'<iframe src="{escape(self.address)}" title="Habilis studio" width="100%" '
            f'height="{self.height}" style="border:0" allow="clipboard-write"></iframe>'
        )


def open_studio(
    world: World | str | Path | None = None,
    *,
    height: int = 640,
    base_path: str = "/",
    trusted_origin: str | None = None,
) -> NotebookStudio:
    """Opens the studio in a cell of a notebook.

    As the last line of a cell it shows the page. What is drawn there is `world` of the result, and
    setting `world` shows another. It needs the extra `habilis[studio]`.

    Args:
        world: a world, the name of a built-in one, or the path of a map; by default the yard. Its
            own tools are offered beside the built-in ones.
        height: of the frame, in pixels.
        base_path: where the browser cannot reach the kernel's machine by itself: the path at which
            a proxy serves the studio, such as "/user/x/proxy/{port}/" on JupyterHub with
            jupyter-server-proxy; "{port}" stands for the studio's port.
        trusted_origin: the origin of that proxy, such as "https://hub.example.org".

    Returns:
        The open studio; `close` ends it.

    Raises:
        ValueError: there is no such world, the page cannot show it, or path or origin are none.
        MissingExtraError: the extra is not installed.

    Example:
        >>> with open_studio("yard") as studio:
        ...     studio.world = studio.world.with_tool("broom")
        ...     studio.world.tool
        'broom'
    """
    if world is None:
        world = _FIRST
    if not isinstance(world, World):
        world = load_world(world)
    if isinstance(height, bool) or not isinstance(height, int) or height < 1:
        raise ValueError(f"height is {height!r}; give a whole number of pixels")
    return NotebookStudio(SharedWorld(world), height, base_path, trusted_origin)
