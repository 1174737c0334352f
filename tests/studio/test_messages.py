"""No message, whatever it is, does the server any harm."""

import contextlib
import json
import re
import tempfile
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from websockets.exceptions import ConnectionClosed

import habilis as hb
from habilis.studio.limits import CLIENTS, MESSAGE
from habilis.studio.messages import MessageError, kind_of, read
from habilis.studio.protocol.requests import Request, Settings, Train
from habilis.studio.scenes import Scene
from habilis.studio.training_jobs import Trainings
from studio import page, scene, studio

TOOLS = ("picker", "broom")
SCENE = scene(hb.load_world("yard"), sensor="object", horizon=2, slip=0.0, actions="all", cells=[])
DRAWN = {key: part for key, part in SCENE.items() if key not in ("map", "tool")} | {
    "drawn": {
        "ground": "...#\n....\n....\n....",
        "agent": [0, 0],
        "tools": [
            {"kind": "picker", "cell": [0, 1], "slip": 0.1},
            {"kind": "broom", "cell": [3, 3]},
        ],
        "objects": [
            {"kind": "can", "cell": [1, 1], "goal": [3, 0]},
            {"kind": "ball", "cell": [2, 2], "goal": None},
        ],
        "drop": True,
    },
    "kind": "effective",
    "discount": 0.5,
}
AT = {"agent": [2, 0], "tools": [[3, 0]], "objects": [[8, 3]]}
WHOLE = {
    "read": {"scene": DRAWN},
    "measure": {"scene": SCENE},
    "landscape": {"scene": SCENE, "placement": AT},
    "pairs": {"scene": DRAWN},
    "futures": {"scene": DRAWN, "agent": [0, 0]},
    "solve": {"scene": SCENE},
    "step": {
        "scene": SCENE,
        "placement": AT,
        "action": 3,
    },
    "train": {"scene": SCENE, "settings": {"runs": 1}},
    "stop": {},
    "trainings": {},
    "curve": {"name": "x"},
    "run": {"index": 0, "name": "x", "placement": AT},
}

EXTREMES = (
    *(-1, 5, 1e-7, 1e308, 2**53, 2**63, 10**400, "", "x" * 300, "é" * 200, "\x00", "a/b", ".."),
    *("\ud800", "\n", [0, 0], [9, 9], [-1, -1], "none", "state", "cells", "tool:picker"),
)
VALUES = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=8)
    | st.sampled_from(EXTREMES),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3)
    ),
    max_leaves=6,
)


def changed(value, path, new):
    """A copy with what is at a path replaced, or left out where the path ends in `...`."""
    if not path:
        return new
    first, *rest = path
    if isinstance(value, dict):
        keys = sorted(value)
        key = keys[first % len(keys)] if keys else "x"
        return {**value, key: changed(value.get(key), rest, new)}
    if isinstance(value, list) and value:
        place = first % len(value)
        return [*value[:place], changed(value[place], rest, new), *value[place + 1 :]]
    return new


BROKEN = st.builds(
    lambda do, path, new: changed({"id": 1, "do": do, **WHOLE[do]}, path, new),
    st.sampled_from(sorted(WHOLE)),
    st.lists(st.integers(0, 7), min_size=1, max_size=4),
    VALUES,
)
TEXTS = (
    st.text(max_size=60)
    | VALUES.map(json.dumps)
    | BROKEN.map(json.dumps)
    | st.tuples(BROKEN.map(json.dumps), st.integers(0, 400)).map(lambda cut: cut[0][: cut[1]])
)
NASTY = (
    *("", "null", "[]", "{}", '"', "{" * 2_000, "[" * 40_000, "1" * 5_000, "NaN"),
    *('{"id": 1e999}', '{"id": NaN}', '{"id": true, "do": "stop"}', '{"id": -1, "do": "stop"}'),
    *(
        '{"id": 1, "do": ["stop"]}',
        '{"id": 1, "do": "\\ud800"}',
        '{"id": 1, "do": "' + "x" * 70_000,
    ),
    json.dumps({"id": 1, "do": "measure", "scene": SCENE | {"map": "\ud800"}}),
    json.dumps({"id": 1, "do": "measure", "scene": SCENE | {"map": "A\u2028C\x00G"}}),
    json.dumps({"id": 1, "do": "measure", "scene": SCENE | {"horizon": 10**400}}),
    json.dumps({"id": 1, "do": "measure", "scene": SCENE | {"cells": [[10**30, 0]]}}),
    json.dumps({"id": 1, "do": "measure", "scene": SCENE | {"tool": "/etc/passwd:x"}}),
    json.dumps({"id": 1, "do": "run", "index": 0, "name": "../../etc"}),
    json.dumps({"id": 1, "do": "run", "index": 0, "name": "x" * 300}),
    json.dumps({"id": 1, "do": "curve", "name": "é" * 200}),
)


@pytest.mark.parametrize("do", sorted(WHOLE))
def test_a_whole_message_is_a_request(do):
    request, _ = read(json.dumps({"id": 7, "do": do, **WHOLE[do]}), TOOLS)
    assert (request.id, kind_of(request)) == (7, do)


@settings(max_examples=1_000, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(TEXTS)
def test_whatever_comes_is_a_request_or_one_line_of_error(text):
    try:
        request, _ = read(text, TOOLS)
    except MessageError as error:
        said = str(error)
    else:
        assert isinstance(request, Request)
        return
    assert len(said.splitlines()) == 1
    assert len(said) < 500


@pytest.mark.parametrize("text", NASTY)
def test_what_is_meant_badly_is_an_error(text):
    with pytest.raises(MessageError):
        raise_if_no_request(text)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('{"do": "read", "id": 1, "scene": {"slip": "x"}, "scene": 1}', "has 'scene' twice"),
        ('{"do": "read", "id": 1, "scene": {"slip": "x"}, "scene": {}}', "has 'scene' twice"),
        ('{"do": "train", "do": "read", "id": 1, "scene": {"x": 1}}', "has 'do' twice"),
        ('{"do": "read", "id": 1, "x` - at `$.scene.y": 1}', "is not as documented"),
        ('{"do": "read", "id": 1, "scene": {"x - at `$.y[3]": 1}}', "is not as documented"),
        ('{"do": "read", "id": 1, "scene": {"horizon": %s}}' % ("9" * 5_000), "not as documented"),
        ('{"do": "read", "id": 1, "scene": {"map": "A", "slip": NaN}}', "is not JSON (JSON is"),
        ('{"do": "read", "id": 1, "scene": {"map": "\\ud800"}}', "half of a surrogate pair"),
    ],
)
def test_an_error_that_leads_nowhere_is_one_line_too(text, said):
    with pytest.raises(MessageError, match=re.escape(said)) as raised:
        read(text, TOOLS)
    assert raised.value.id == 1


def raise_if_no_request(text):
    request, _ = read(text, TOOLS)
    if kind_of(request) in ("run", "curve"):  # its name is looked at where trainings are kept
        raise MessageError("no request of ours", request.id)


def test_a_message_that_is_too_long_is_answered_to_its_sender(address):
    with page(address) as there:
        number = there.send("read", scene={"map": "." * MESSAGE})
        error = next(there.answers(number))["error"]
    assert error.startswith("a message has 65,5")
    assert error.endswith(f"characters; send at most {MESSAGE:,}")


@pytest.mark.ill_typed
@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.dictionaries(st.sampled_from(Settings.__struct_fields__), VALUES, max_size=3))
def test_whatever_the_settings_of_a_training_are_they_are_taken_or_one_line_of_error(given):
    message = {"id": 1, "do": "train", "scene": SCENE, "settings": given}
    with tempfile.TemporaryDirectory() as folder:
        said = "taken"
        try:
            request, asked = read(json.dumps(message), TOOLS)
            assert isinstance(request, Train)
            assert isinstance(asked, Scene)
            with Trainings(Path(folder)).one(asked, request.settings):
                pass
        except ValueError as error:
            said = str(error)
        assert len(said.splitlines()) == 1
        assert not list(Path(folder).iterdir())


def test_after_a_thousand_malformed_messages_the_server_answers_as_before(tmp_path):
    sent = []

    @settings(max_examples=1_000, deadline=None, database=None)
    @given(TEXTS)
    def collect(text):
        sent.append(text)

    collect()
    log = tmp_path / "errors.txt"
    with (
        log.open("w") as errors_to,
        studio("--out", str(tmp_path / "kept"), stderr=errors_to) as address,
        page(address) as there,
        page(address) as other,
    ):
        before = other.ask("measure", scene=SCENE)["landscape"]
        answers = []
        meant = [
            text for text in [*sent, *NASTY] if '"train"' not in text
        ]  # a whole one would train
        for text in [*meant, b"\x00\xff", "x" * 200_000]:
            there.socket.send(text)
            last = there.send("stop")
            while not (answers and answers[-1]["id"] == last):  # who never reads is not read either
                answers.append(json.loads(there.socket.recv()))
        number = there.send("measure", scene=SCENE)
        while not (answers and answers[-1]["id"] == number and "landscape" in answers[-1]):
            answers.append(json.loads(there.socket.recv()))
        assert answers[-1]["landscape"] == before
        errors = [a["error"] for a in answers if "error" in a and "no training" not in a["error"]]
        assert len(errors) > 500
        assert not [a for a in answers if "error" in a and "\n" in a["error"]]
        assert other.ask("measure", scene=SCENE)["landscape"] == before
        assert not [a for a in answers if "internal error" in a.get("error", "")]
    assert log.read_text() == ""


def test_pages_beyond_the_limit_are_asked_to_try_later(address):
    with contextlib.ExitStack() as pages:
        for _ in range(CLIENTS):
            pages.enter_context(page(address))
        with pytest.raises(ConnectionClosed, match=r"1013.*pages are open; close one"):
            pages.enter_context(page(address))
    with page(address) as there:
        assert "landscape" in there.ask("measure", scene=SCENE)


def test_a_message_that_is_too_long_for_any_use_ends_its_own_connection_only(address):
    with page(address) as there, page(address) as other:
        with pytest.raises(Exception, match=r"1009|closed|reset|pipe"):  # noqa: PT012
            there.socket.send("x" * 2**21)
            there.receive()
        assert "landscape" in other.ask("measure", scene=SCENE)
