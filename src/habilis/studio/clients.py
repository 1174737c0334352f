"""Clients: each has one computation in each pool at a time, and only its newest wish counts."""

import asyncio
import json
import traceback
from collections.abc import Awaitable, Callable, Coroutine
from typing import Any

from habilis.extras import MissingExtraError
from habilis.studio.messages import one_line
from habilis.studio.pool import Pool
from habilis.studio.training import Training

Send = Callable[[str], Awaitable[None]]


class Client:
    """One connection.

    A request replaces the one of its kind that is still being worked on, so that no more wait than
    there are kinds. Steps take turns: a client asks for its next one when it has the last one's
    answer, and a pool serves those who ask in the order in which they came. So everybody who asks
    for anything has one step done before anybody has two.
    """

    def __init__(self, send: Send):
        self._send = send
        self._turns: dict[Pool, asyncio.Lock] = {}
        self.trainings: dict[int, Training] = {}
        self._working: dict[str, tuple[int, asyncio.Task[None]]] = {}

    async def tell(self, number: int | None, **answer: Any) -> None:
        """Sends what there is to say to a request."""
        await self._send(json.dumps({"id": number} | answer, allow_nan=False))

    async def step(self, pool: Pool, name: str, **arguments: Any) -> Any:
        """Has a step done when it is this client's turn."""
        return await pool.do(self._turns.setdefault(pool, asyncio.Lock()), name, **arguments)

    async def ask(self, kind: str, number: int, work: Coroutine[Any, Any, None]) -> None:
        """Begins to answer a request, in the place of an earlier one of its kind."""
        earlier = self.working(kind)
        if earlier is not None:
            self._working[kind][1].cancel()
            await self.tell(earlier, overtaken=True)
        self._working[kind] = number, asyncio.create_task(self._answered(number, work))

    def working(self, kind: str) -> int | None:
        """The number of the request of some kind that is being worked on, if there is one."""
        number, task = self._working.get(kind, (None, None))
        return None if task is None or task.done() else number

    async def stop(self, number: int) -> None:
        """Stops a training; what there is of it is kept."""
        if number not in self.trainings:
            await self.tell(number, error=f"no training has the id {number}; it may have ended")
        else:
            self.trainings[number].stop()

    async def leave(self) -> None:
        """Drops all that is being worked on."""
        tasks = [task for _, task in self._working.values()]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    async def _answered(self, number: int, work: Coroutine[Any, Any, None]) -> None:
        try:
            await work
        except (ValueError, MissingExtraError) as error:
            await self.tell(number, error=one_line(error))
        except Exception as error:
            traceback.print_exc()
            await self.tell(number, error=one_line(f"the studio failed: {error!r}; please tell us"))
