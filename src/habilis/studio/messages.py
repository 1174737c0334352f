"""The protocol: the messages between page and server, and the validation of requests.

Messages are JSON texts over one WebSocket, at the path /ws. The server greets
with `{"hello": ...}`; then a page sends requests, `{"id": number, "do": name, ...}`,
and every answer has the request's id. An answer has the fields listed below, in
one or more parts, or is one of

    {"id", "error": one line}    the error, in the library's words
    {"id", "progress": 0 to 1}   the progress of a long computation
    {"id", "overtaken": true}    a newer request of its kind has replaced it

measure  scene
         landscape (rows of bits, null where the agent cannot be), least, most,
         seconds; then, tool by tool, averages {tool: bits or null}, within
         {tool: half the width of its 95 % interval, 0 if it is exact} and
         verdicts {tool: {useful, better_than_none (null if undecided), equal (the
         same as none)}}, and `why` if an average is null
landscape  scene, optional placement of the things, by default the map's
         landscape, least, most, seconds, as above
futures  scene, agent [row, column]
         bits, gap, things [[row, column, probability]] of the observed thing
         (through the sensor "state": of the can), elsewhere (the probability
         of other cells), count of observations
solve    scene, optional placement to start from
         steps, return, actions, placements; or nulls if the goal is
         unreachable
step     scene, placement, action (an index; null stays, for the bits only)
         placement, bits, equipped, attached, reward, ended
train    scene, settings (some of `habilis.learning.config.Config`)
         name; then repeatedly share, steps_per_second, curve, episodes, steps,
         converged_at, best_return; finally the same with done {name, runs,
         converged_at, best_return}
read     scene (only its map)
         drawn, and text: the map as text
stop     (the id is the training's) no answer of its own: the training ends, and
         its progress is kept
trainings  no fields: lists the server's folders with a training
         names, newest first, and left_out, the number of older ones; then,
         one by one, kept {name, under_way, runs, config, drawn, ended, converged_at
         or null, best_return or null}, with error if there is nothing to watch,
         and with only name, under_way and error if its folder is damaged
curve    name (of a training)
         curve, episodes, steps, converged_at, best_return, as in train
run      index, optional name (of a training) and placement in which the episode
         begins
         drawn, policy {episode, cells}, values, episode {placements, actions, values,
         return, finished, best_return or null}, and the fields of curve

A scene is an object:

map      text of 4 to 30 rows and columns, optionally below lines that bind
         characters, as in a file; or instead
drawn    {ground: rows of # and ., agent, tools [{kind, cell, slip}], objects
         [{kind, cell, goal or null}], drop}, things in any order; they are numbered
         in the reading order of the map, objects that have goals first
tool     the name of a tool in `hello`, which replaces the map's; none removes it;
         by default those of the map
sensor   state (the default), object, tool, agent, or cells: observes the object in
         `cells` only
thing    which of several objects (or tools, through the sensor tool), from 0
cells    [[row, column], ...]
horizon  0 (the default) to 10 actions
actions  all (the default), moves, tool
slip     0 (the default) to 0.5, the probability that a random action replaces the chosen one

Cells are [row, column], counted from 0. A placement has the cells of agent, object
and, with a tool, tool; on a map of several things those of agent, tool:picker, ...,
object:can, ..., and optionally held and laid: the tool in hand, and the one dropped
and not left since, as indices of the tools, -1 for none.

A curve has x, mean, low, high, runs, carried_on. `hello` has version, worlds
{name: drawn}, tools, objects (the known kinds), actions (their names, by index),
limits, training (intrinsic {name: label}, algorithms {name: label},
without_horizon, first {setting: value}), shapes (drawings of things: [outline,
colour] from back to front), run (of the folder that the studio was started with:
name, runs, map, tool, config; or null) and kept (the folder of trainings that are
kept, or null).
"""

import json
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any, NoReturn

from habilis.mdp import HELD, LAID
from habilis.studio import training_settings
from habilis.studio.fields import cell, checked, number, shown, text
from habilis.studio.limits import MESSAGE, THINGS
from habilis.studio.scenes import Scene
from habilis.worlds.rules import ACTIONS
from habilis.worlds.world import Cell

ID = "id"
_LARGEST = 2**53  # up to here JavaScript represents integers exactly
_LONGEST_ERROR = 400
_BEGINS_WITH_ID = re.compile(r'\s*\{\s*"id"\s*:\s*(\d{1,16})\s*,')
_MOST_NAMED = 2 * THINGS + 3

_FIELDS = {  # of each request: required and optional fields
    "measure": (("scene",), ()),
    "landscape": (("scene",), ("placement",)),
    "read": (("scene",), ()),
    "futures": (("scene", "agent"), ()),
    "solve": (("scene",), ("placement",)),
    "step": (("scene", "placement", "action"), ()),
    "train": (("scene", "settings"), ()),
    "stop": ((), ()),
    "trainings": ((), ()),
    "curve": (("name",), ()),
    "run": (("index",), ("name", "placement")),
}


@dataclass(frozen=True)
class Request:
    """A validated request.

    Attributes:
        id: the page's number for it.
        do: its name.
        scene: its scene, if it has one.
        values: its other fields.
    """

    id: int
    do: str
    scene: Scene | None = None
    values: Mapping[str, Any] = field(default_factory=dict)


class MessageError(ValueError):
    """The error of an invalid message; `id` is its number, if it has one."""

    def __init__(self, message: str, number: int | None):
        super().__init__(message)
        self.id = number


def read(message: Any, tools: Collection[str]) -> Request:
    """A request from a message.

    Args:
        message: as received.
        tools: the names of all tools.

    Raises:
        MessageError: the message is invalid; one line says why.
    """
    given, number_of = None, _id_of_long(message)
    try:
        given = _object(message)
        number_of = number(ID, given.get(ID), 0, _LARGEST, whole=True)
        return _request(number_of, given, tools)
    except (ValueError, RecursionError) as error:
        raise MessageError(one_line(error), number_of) from None


def _id_of_long(message: Any) -> int | None:
    """The id at the start of a message that is too long to parse, so that it can be answered."""
    if not isinstance(message, str) or len(message) <= MESSAGE:
        return None
    found = _BEGINS_WITH_ID.match(message)
    return None if found is None or int(found[1]) > _LARGEST else int(found[1])


def one_line(error: object) -> str:
    """The text of an error, in one line of limited length."""
    line = " ".join(str(error).split()) or type(error).__name__
    return line if len(line) <= _LONGEST_ERROR else f"{line[:_LONGEST_ERROR]}..."


def _object(message: Any) -> dict[str, Any]:
    if not isinstance(message, str):
        raise ValueError("a message is binary; send a JSON object as text")
    if len(message) > MESSAGE:
        raise ValueError(f"a message has {len(message):,} characters; send at most {MESSAGE:,}")
    try:
        value = json.loads(message, parse_constant=_no_number)
    except RecursionError:
        raise ValueError("a message is nested too deeply; send an object as documented") from None
    except ValueError as error:
        raise ValueError(f"a message is not JSON ({error}); send an object") from None
    if not isinstance(value, dict):
        raise ValueError(f"a message is {shown(value)}; send an object")
    return value


def _no_number(name: str) -> NoReturn:
    raise ValueError(f"{name} is not a number")


def _request(number_of: int, given: dict[str, Any], tools: Collection[str]) -> Request:
    do = given.get("do")
    if not isinstance(do, str) or do not in _FIELDS:
        raise ValueError(f"do is {shown(do)}; use one of {', '.join(_FIELDS)}")
    required, optional = _FIELDS[do]
    checked(f"the message {do!r}", given, (ID, "do", *required), optional)
    scene = Scene.of(given["scene"], tools) if "scene" in required else None
    read_one = {name: _READERS[name] for name in (*required, *optional) if name != "scene"}
    values = {name: read_one[name](given[name]) for name in read_one if name in given}
    if scene is not None and "agent" in values:
        row, column = values["agent"]
        if not (0 <= row < scene.world.height and 0 <= column < scene.world.width):
            raise ValueError(
                f"the agent's cell {values['agent']} is outside the map; give a free cell"
            )
    return Request(number_of, do, scene, values)


def _action(value: Any) -> int | None:
    return None if value is None else number("action", value, 0, len(ACTIONS), whole=True)


def _placement(value: Any) -> dict[str, Cell | int]:
    """A placement; the library checks whether it is possible."""
    if not isinstance(value, dict) or "agent" not in value or len(value) > _MOST_NAMED:
        raise ValueError(f"placement is {shown(value)}; give the cells of agent, object and tool")
    return {
        name: number(name, at, -1, THINGS, whole=True) if name in (HELD, LAID) else cell(name, at)
        for name, at in value.items()
        if at is not None
    }


_READERS = {
    "agent": lambda value: cell("agent", value),
    "placement": _placement,
    "action": _action,
    "settings": training_settings.checked_settings,
    "index": lambda value: number("index", value, 0, _LARGEST, whole=True),
    "name": lambda value: text("name", value),
}
