"""The studio's server: one page, and one WebSocket per open page."""

import asyncio
import contextlib
import socket
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import msgspec
import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request as HttpRequest
from starlette.responses import FileResponse, PlainTextResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.websockets import WebSocket, WebSocketDisconnect

import habilis
from habilis.extras import check_installed
from habilis.files import check_folder
from habilis.studio import keep_requests, limits, pairs, scene_requests, training_requests
from habilis.studio.clients import Client
from habilis.studio.drawn_worlds import drawn_of
from habilis.studio.limits import CLIENTS, MESSAGE
from habilis.studio.messages import MessageError, kind_of, one_line, read
from habilis.studio.opening import Opened, open_source
from habilis.studio.protocol import requests
from habilis.studio.protocol.answers import Answer
from habilis.studio.protocol.hello import Greeting, Hello, Limits, TrainingLimits
from habilis.studio.scene_requests import Pools
from habilis.studio.scenes import AnyScene, Scene
from habilis.studio.security import Access, Guard
from habilis.studio.shared_world import SharedWorld
from habilis.studio.training_jobs import Trainings
from habilis.studio.training_settings import offered
from habilis.worlds.own_tools import tool_named
from habilis.worlds.pictures.shapes import SHAPES
from habilis.worlds.rules import ACTIONS, DROP_NAME
from habilis.worlds.things import OBJECTS
from habilis.worlds.tools import TOOLS, drawing_of
from habilis.worlds.world import NO_TOOL, load_world, world_names

PAGE = Path(__file__).parent / "page"
_FRAME = 16 * MESSAGE  # bytes; longer messages close the connection, shorter ones get an error
_GRACE = 2  # seconds for connections to close
_FULL = 1013  # a WebSocket's close code: try again later


@dataclass(frozen=True)
class Studio:
    """The state of a server.

    Attributes:
        access: the access rules.
        pools: the worker processes.
        trainings: the trainings requested by pages.
        tools: names of custom tools.
        opened: what pages show first.
        kept: the folder in which trainings outlive the server, if there is one.
        clients: the connected clients.
        shared: the world that pages share with the notebook that they are embedded in.
    """

    access: Access
    pools: Pools
    trainings: Trainings
    tools: tuple[str, ...] = ()
    opened: Opened = field(default_factory=Opened)
    kept: Path | None = None
    clients: set[Client] = field(default_factory=set)
    shared: SharedWorld | None = None

    @cached_property
    def all_tools(self) -> tuple[str, ...]:
        return *TOOLS, *self.tools

    def greeting(self) -> str:
        """The greeting of a page."""
        shown = None if self.shared is None else self.shared.shown
        hello = msgspec.structs.replace(self._hello, shown=shown)
        return msgspec.json.encode(Greeting(hello)).decode()

    @cached_property
    def _hello(self) -> Hello:
        shapes = SHAPES | {name: drawing_of(tool_named(name)) for name in self.tools}
        return Hello(
            version=habilis.__version__,
            worlds={name: drawn_of(load_world(name)) for name in world_names()},
            tools=[*self.all_tools, NO_TOOL],
            objects=list(OBJECTS),
            actions=[*ACTIONS, DROP_NAME],
            limits=Limits(
                side=limits.SIDES,
                things=limits.THINGS,
                horizon=limits.HORIZON,
                discount=limits.DISCOUNT,
                slack=limits.SLACK,
                slip=limits.SLIP,
                tool_slip=limits.TOOL_SLIP,
                message=limits.MESSAGE,
                training=TrainingLimits(**limits.TRAINING),
            ),
            training=offered(),
            shapes={
                name: [(shape.path, shape.fill) for shape in drawing]
                for name, drawing in shapes.items()
            },
            run=self.opened.about_run,
            board=self.opened.about,
            world=None if self.opened.world is None else drawn_of(self.opened.world),
            kept=None if self.kept is None else str(self.kept),
            shown=None,
        )

    async def answer(
        self, client: Client, request: requests.Request, scene: AnyScene | None
    ) -> None:
        """Starts to answer a request."""
        pools, trainings = self.pools, self.trainings
        match request:
            case requests.Stop():
                await client.stop(request.id)
                return
            case requests.Edit() if scene is not None:
                await client.answer(self._edited(request, scene))
                return
            case requests.Train() | requests.Follow() if client.trainings:
                words = "a training is in progress; stop it first"
                await client.answer(Answer(id=request.id, error=words))
                return
            case requests.Measure() if scene is not None:
                work = scene_requests.measure(pools, self.all_tools, client, request, scene)
            case requests.Pairs() if scene is not None:
                work = pairs.answer(pools.slow, self.all_tools, client, request, scene)
            case requests.Train() if scene is not None:
                work = training_requests.train(pools, trainings, client, request, scene)
            case requests.Follow():
                work = training_requests.follow(pools, trainings, client, request)
            case requests.Code() if scene is not None:
                opened = self.opened.run, self.opened.source
                tools = self.all_tools
                work = keep_requests.code(pools, trainings, *opened, tools, client, request, scene)
            case requests.Film() if scene is not None:
                work = keep_requests.film(pools, client, request, scene)
            case requests.Trainings():
                work = training_requests.listed(pools, trainings, client, request)
            case requests.Curve():
                work = training_requests.curve(pools, trainings, client, request)
            case requests.Run():
                work = training_requests.run(pools, trainings, self.opened.run, client, request)
            case requests.Step() if scene is not None:
                image = self.opened.image
                work = scene_requests.step(pools, image, client, request, scene)
            case _:
                work = scene_requests.ANSWERS[type(request)](pools, client, request, scene)
        # A page shows a board and a map side by side: neither overtakes the other's requests.
        kind = kind_of(request) if isinstance(scene, Scene | None) else f"{kind_of(request)} board"
        await client.ask(kind, request.id, work)

    def _edited(self, request: requests.Edit, scene: AnyScene) -> Answer:
        if not isinstance(scene, Scene):
            return Answer(id=request.id, error="a board has no map to edit; give one as drawn")
        if self.shared is None:
            words = "this studio is not embedded in a notebook; open one with habilis.open_studio"
            return Answer(id=request.id, error=words)
        try:
            self.shared.edit(scene.world, request.shown)
        except ValueError as error:
            return Answer(id=request.id, error=one_line(error))
        return Answer(id=request.id)


def application(studio: Studio) -> Guard:
    """The server as ASGI."""

    @asynccontextmanager
    async def lifespan(app: Starlette) -> AsyncIterator[None]:
        studio.pools.start()
        yield
        await studio.trainings.close()
        await studio.pools.close()

    async def connected(socket: WebSocket) -> None:
        await _connected(studio, socket)

    routes = [Route("/", _page), WebSocketRoute("/ws", connected)]
    if (PAGE / "assets").is_dir():
        routes.append(Mount("/assets", StaticFiles(directory=PAGE / "assets")))
    return Guard(Starlette(routes=routes, lifespan=lifespan), studio.access, ("/assets/",))


async def _page(request: HttpRequest) -> Response:
    index = PAGE / "index.html"
    if not index.exists():
        return PlainTextResponse("the studio's page is not built: see studio/README.md\n")
    return FileResponse(index, headers={"cache-control": "no-cache"})


async def _connected(studio: Studio, socket: WebSocket) -> None:
    """Serves one page until it is closed."""
    await socket.accept()
    if len(studio.clients) >= CLIENTS:
        await socket.close(_FULL, f"{CLIENTS} pages are open; close one")
        return

    async def send(text: str) -> None:
        with contextlib.suppress(
            WebSocketDisconnect, RuntimeError
        ):  # the loop below handles the disconnect
            await socket.send_text(text)

    client = Client(send)
    studio.clients.add(client)
    try:
        if studio.shared is not None:
            studio.shared.enter(send)
        await socket.send_text(studio.greeting())
        while True:
            message = await socket.receive()
            if message["type"] == "websocket.disconnect":
                return
            try:
                said = message.get("text") or message.get("bytes")
                request, scene = read(said, studio.all_tools, studio.opened.board)
            except MessageError as error:
                await client.answer(Answer(id=error.id, error=str(error)))
            else:
                await studio.answer(client, request, scene)
            await asyncio.sleep(0)  # a client that sends without pause does not block others
    except WebSocketDisconnect:
        pass
    finally:
        studio.clients.discard(client)
        if studio.shared is not None:
            studio.shared.leave(send)
        await client.leave()


def opened(
    host: str,
    port: int,
    folder: Path,
    tools: tuple[str, ...] = (),
    source: str | None = None,
    kept: Path | None = None,
    base: str = "/",
    trusted: Sequence[str] = (),
    shared: SharedWorld | None = None,
) -> tuple[Studio, socket.socket]:
    """A studio on an address, ready to be served.

    Args:
        host, port: the address to listen on; port 0 chooses a free one.
        folder: the folder for temporary trainings.
        tools: names of custom tools.
        source: what to show: a trained run's folder, a world or its file, a puzzle's file, or
            "gym:ID".
        kept: the folder in which to keep trainings instead.
        base, trusted: the path and the origins of a proxy, as in `Access.of`.
        shared: the world of the notebook that may embed the page.

    Raises:
        ValueError: the address does not belong to this machine, a tool or source does not exist, a
            tool is given twice, `kept` is not writable, or the path or an origin is none.
    """
    for place, name in enumerate(tools):
        tool_named(name)  # raises if it is not a valid tool
        if name in (*TOOLS, *tools[:place]):
            raise ValueError(f"tool {name!r} is given twice or built in; leave it out")
    opened = open_source(source, folder)
    if opened.world is not None:  # whose tools somebody named on the command line, too
        tools = *tools, *(name for name in opened.world.own_tools if name not in tools)
    if kept is not None:
        check_installed("learn")
        check_folder(kept)
        kept = kept.absolute()
    Access.of(host, port, base, trusted)  # raises if path or origins are none
    found = listening(host, port)
    access = Access.of(host, found.getsockname()[1], base, trusted, framed=shared is not None)
    studio = Studio(
        access=access,
        pools=Pools.made(),
        trainings=Trainings(kept or folder),
        tools=tools,
        opened=opened,
        kept=kept,
        shared=shared,
    )
    return studio, found


def listening(host: str, port: int) -> socket.socket:
    """A listening socket.

    Raises:
        ValueError: the address does not belong to this machine, or is in use.
    """
    if not 0 <= port <= 65_535:
        raise ValueError(f"port is {port}; give one from 0 (any) to 65535")
    found = None
    try:
        family, kind, number, _, address = socket.getaddrinfo(
            host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
        )[0]
        found = socket.socket(family, kind, number)
        found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        found.bind(address)
        found.listen()  # from now on browsers can connect
    except (OSError, UnicodeError) as error:
        if found is not None:
            found.close()
        reason = getattr(error, "strerror", None) or error
        raise ValueError(
            f"{host}, port {port}: cannot listen there ({reason}); give another --host or --port"
        ) from None
    return found


def serve(studio: Studio, found: socket.socket) -> None:
    """Serves until interrupted."""
    server_of(studio).run(sockets=[found])


def server_of(studio: Studio) -> uvicorn.Server:
    """The server of a studio."""
    config = uvicorn.Config(
        application(studio),
        log_level="error",
        ws="websockets-sansio",
        ws_max_size=_FRAME,
        ws_per_message_deflate=False,
        timeout_graceful_shutdown=_GRACE,
        server_header=False,
    )
    return uvicorn.Server(config)
