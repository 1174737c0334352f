"""A studio in a process of its own, and a page that talks to it."""

import http.client
import json
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import msgspec
from websockets.sync.client import ClientConnection, connect

import habilis as hb
from habilis.studio.protocol.answers import ANSWER_OF, Answer
from habilis.studio.protocol.hello import Greeting

ANSWERS = {kind.__struct_config__.tag: answer for kind, answer in ANSWER_OF.items()}
HABILIS = (sys.executable, "-m", "habilis")


@contextmanager
def studio(*arguments: str, habilis: Sequence[str] = HABILIS, **options: Any) -> Iterator[str]:
    """Runs `habilis studio`; yields the page's address."""
    command = [*habilis, "studio", "--no-browser", "--json", *arguments]
    with subprocess.Popen(command, stdout=subprocess.PIPE, **options) as process:
        assert process.stdout is not None
        try:
            yield json.loads(process.stdout.readline())["address"]
        finally:
            process.terminate()


@contextmanager
def page(address: str, **options: Any) -> Iterator["Page"]:
    """A connection, as a page has it."""
    base, _, query = address.partition("?")
    there = f"{base.replace('http:', 'ws:')}ws" + (f"?{query}" if query else "")
    never: Any = dict.fromkeys(("max_size", "compression", "open_timeout", "ping_interval"))
    with connect(there, **never, close_timeout=None, **options) as socket:
        yield Page(socket)


def get(
    address: str, path: str = "/", host: str | None = None, **headers: str
) -> tuple[int, str, dict[str, str]]:
    """Status, text and headers of a page, asked for at loopback's address."""
    port = urlsplit(address).port
    with closing(http.client.HTTPConnection("127.0.0.1", port)) as there:
        there.request("GET", path, headers={"Host": host or f"127.0.0.1:{port}"} | headers)
        answer = there.getresponse()
        return answer.status, answer.read().decode(), dict(answer.getheaders())


class Page:
    def __init__(self, socket: ClientConnection):
        self.socket = socket
        self.asked: dict[int, type[Answer]] = {}
        greeting = self.socket.recv()
        msgspec.json.decode(greeting, type=Greeting)
        self.hello = json.loads(greeting)["hello"]
        self.number = 0

    def shown(self) -> dict[str, Any]:
        """The next world that a notebook sets."""
        return json.loads(self.socket.recv())["show"]

    def receive(self) -> dict[str, Any]:
        """The next answer, which has no field that the protocol does not have."""
        answer = json.loads(self.socket.recv())
        kind = self.asked.get(answer["id"], Answer)
        typed = msgspec.convert(answer, kind)
        assert json.loads(msgspec.json.encode(typed)) == answer
        return answer

    def send(self, do: str, **fields: Any) -> int:
        self.number += 1
        self.asked[self.number] = ANSWERS.get(do, Answer)
        self.socket.send(json.dumps({"id": self.number, "do": do} | fields))
        return self.number

    def answers(self, number: int) -> Iterator[dict[str, Any]]:
        """The answers to one request."""
        while True:
            answer = self.receive()
            if answer["id"] == number:
                yield answer

    def ask(self, do: str, **fields: Any) -> dict[str, Any]:
        """The first answer that is no progress."""
        return next(a for a in self.answers(self.send(do, **fields)) if "progress" not in a)


def scene(world: hb.World, **measured: Any) -> dict[str, Any]:
    """As a script would say it: by its map's text."""
    return {"map": world.text(), "tool": world.tool, "horizon": 2} | measured


def printing_rake(folder: Path) -> str:
    """Writes a tool of one's own that prints when it is asked; its name."""
    (folder / "mine.py").write_text(RAKE, "utf-8")
    return f"{folder}/mine.py:Rake"


RAKE = """\
import numpy as np
class Rake:
    character = 'R'
    def attached(self, agent, tool, thing):
        print('a tool may print')
        return np.zeros(thing.shape, bool)
    def carry(self, agent, tool, thing, step):
        pulled = (thing - tool == tool - agent) & (step == agent - tool)
        return np.where(pulled, thing + step, thing)
    def swing(self, agent, tool, thing, step):
        return thing
"""
