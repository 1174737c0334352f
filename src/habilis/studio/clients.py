"""A client: one step per pool at a time, and only the newest request of each kind."""

import asyncio
import traceback
from collections.abc import Awaitable, Callable, Coroutine
from typing import Any

import msgspec

from habilis.extras import MissingExtraError
from habilis.studio.messages import one_line
from habilis.studio.pool import Pool
from habilis.studio.protocol.answers import Answer
from habilis.studio.training_jobs import Training

Send = Callable[[str], Awaitable[None]]
_ENCODER = msgspec.json.Encoder()


class Client:
    """One connection.

    A request replaces an unfinished one of its kind, so at most one per kind is waiting. Steps take
    turns: a client requests its next step after the answer to the previous one, and a pool serves
    requests in order of arrival. So every client gets one step done before any client gets two.
    """

    def __init__(self, send: Send):
        self._send = send
        self._turns: dict[Pool, asyncio.Lock] = {}
        self.trainings: dict[int, Training] = {}
        self._working: dict[str, tuple[int, asyncio.Task[None]]] = {}

    async def answer(self, answer: Answer) -> None:
        """Sends a part of an answer."""
        await self._send(_ENCODER.encode(answer).decode())

    async def pass_on(self, kind: type[Answer], number: int, found: dict[str, Any]) -> None:
        """Sends what a step found as an answer, or a part of one."""
        await self.answer(msgspec.convert({"id": number, **found}, kind))

    async def step(self, pool: Pool, name: str, **arguments: Any) -> Any:
        """Runs a step when it is this client's turn."""
        return await pool.do(self._turns.setdefault(pool, asyncio.Lock()), name, **arguments)

    async def ask(self, kind: str, number: int, work: Coroutine[Any, Any, None]) -> None:
        """Starts to answer a request, replacing an earlier one of its kind."""
        earlier = self.working(kind)
        if earlier is not None:
            self._working[kind][1].cancel()
            await self.answer(Answer(id=earlier, overtaken=True))
        self._working[kind] = number, asyncio.create_task(self._answered(number, work))

    def working(self, kind: str) -> int | None:
        """The number of the unfinished request of a kind, if there is one."""
        number, task = self._working.get(kind, (None, None))
        return None if task is None or task.done() else number

    async def stop(self, number: int) -> None:
        """Stops a training, and keeps its progress."""
        if number not in self.trainings:
            words = f"no training has the id {number}; it may have ended"
            await self.answer(Answer(id=number, error=words))
        else:
            self.trainings[number].stop()

    async def leave(self) -> None:
        """Cancels all unfinished requests."""
        tasks = [task for _, task in self._working.values()]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    async def _answered(self, number: int, work: Coroutine[Any, Any, None]) -> None:
        try:
            await work
        except (ValueError, MissingExtraError) as error:
            await self.answer(Answer(id=number, error=one_line(error)))
        except Exception as error:
            traceback.print_exc()
            words = one_line(f"internal error: {error!r}; please report it")
            await self.answer(Answer(id=number, error=words))
