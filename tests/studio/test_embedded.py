"""The studio in a cell: a world shared by a notebook and the pages embedded in it."""

import re
import subprocess
import sys
from html import unescape
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus

import habilis as hb
from habilis.extras import MissingExtraError
from habilis.studio.embedded import NotebookStudio
from studio import Page, get, page, scene

ROOM = hb.World.parse("A..C\n.P..\n....\n...G", "room")
WALLED = hb.World.parse("A..C\n.P..\n.##.\n...G", "map")
OTHER = hb.World.parse("A.C.\n.B..\n....\n...G", "other")


@pytest.fixture(scope="module")
def notebook():
    with hb.open_studio(ROOM) as notebook:
        yield notebook


@pytest.fixture
def there(notebook: NotebookStudio):
    notebook.world = ROOM
    with page(notebook.address) as there:
        yield there


def edited(there: Page, world: hb.World, number: int) -> None:
    answer = there.ask("edit", scene=scene(world), shown=number)
    assert "error" not in answer


def test_a_page_is_greeted_with_the_notebooks_world(notebook: NotebookStudio, there: Page):
    shown = there.hello["shown"]
    assert shown["drawn"]["ground"] == "....\n....\n....\n...."
    assert shown["drawn"]["objects"] == [{"kind": "can", "cell": [0, 3], "goal": [3, 3]}]
    assert notebook.world is ROOM


def test_an_edit_on_the_page_is_the_notebooks_world(notebook: NotebookStudio, there: Page):
    number = there.hello["shown"]["number"]
    edited(there, WALLED, number)
    assert notebook.world == hb.World.parse(WALLED.text(), "room")  # the name stays
    edited(there, WALLED.with_tool("none"), number)
    assert notebook.world.tool == "none"


def test_a_world_that_the_notebook_sets_is_shown_on_every_page(
    notebook: NotebookStudio, there: Page
):
    with page(notebook.address) as another:
        notebook.world = OTHER
        for one in (there, another):
            shown = one.shown()
            assert shown["number"] == there.hello["shown"]["number"] + 1
            assert shown["drawn"]["tools"] == [{"kind": "broom", "cell": [1, 1], "slip": 0.0}]
    assert notebook.world is OTHER


def test_what_a_page_made_of_an_earlier_world_does_not_replace_the_one_that_was_set(
    notebook: NotebookStudio, there: Page
):
    number = there.hello["shown"]["number"]
    notebook.world = OTHER
    assert there.shown()["number"] == number + 1
    edited(there, WALLED, number)
    assert notebook.world is OTHER
    edited(there, OTHER, number + 1)
    assert notebook.world is OTHER
    edited(there, WALLED, number + 1)
    assert notebook.world.walls == WALLED.walls


@pytest.mark.parametrize(
    ("world", "problem"),
    [
        (hb.World.parse("A.CG", "line"), "line: has 1 x 4 cells; draw 4 to 30 a side"),
        (
            hb.World.parse("P = picker pushes\n" + "\n".join(ROOM.rows), "room"),
            "room: the page cannot represent the reading 'pushes'",
        ),
    ],
)
def test_a_world_that_the_page_cannot_show_is_refused(
    notebook: NotebookStudio, world: hb.World, problem: str
):
    before = notebook.world
    with pytest.raises(ValueError, match=re.escape(problem)):
        notebook.world = world
    with pytest.raises(ValueError, match=re.escape(problem)):
        hb.open_studio(world)
    assert notebook.world is before


def test_an_edit_that_the_page_could_not_have_made_is_an_error(
    notebook: NotebookStudio, there: Page
):
    pushing = {"map": "P = picker pushes\n" + "\n".join(ROOM.rows)}
    number = there.hello["shown"]["number"]
    answer = there.ask("edit", scene=pushing, shown=number)
    assert answer["error"].startswith("map: the page cannot represent the reading 'pushes'")
    assert notebook.world is ROOM
    edited(there, WALLED, number)
    assert notebook.world.walls == WALLED.walls


@pytest.mark.ill_typed
def test_wrong_arguments_are_named(notebook):
    wrong: tuple[Any, ...] = (0, "640", 1.5, True)
    for height in wrong:
        with pytest.raises(ValueError, match=f"height is {height!r}; give a whole number"):
            hb.open_studio(height=height)
    settings: tuple[tuple[dict[str, Any], str], ...] = (
        ({"base_path": None}, "base path is None; give the path"),
        ({"trusted_origin": 5}, "trusted origin is 5; give scheme"),
    )
    for given, problem in settings:
        with pytest.raises(ValueError, match=problem):
            hb.open_studio(**given)
    with pytest.raises(ValueError, match="world is 5; give a built-in world's name"):
        hb.open_studio(5)  # pyright: ignore[reportArgumentType]
    with pytest.raises(ValueError, match="world is 'corridor'; give a World"):
        notebook.world = "corridor"
    with pytest.raises(ValueError, match="base path is 'x'"):
        hb.open_studio(base_path="x")
    with pytest.raises(ValueError, match="trusted origin is 'hub'"):
        hb.open_studio(trusted_origin="hub")
    with pytest.raises(ValueError, match="nowhere: no such world"):
        hb.open_studio("nowhere")


def test_a_tool_that_the_studio_does_not_offer_is_refused(notebook: NotebookStudio):
    rake = Path(__file__).parents[2] / "examples" / "rake.py"
    raked = ROOM.with_tool(f"{rake}:Rake")
    with pytest.raises(ValueError, match=r"this studio does not offer the tool .*open another"):
        notebook.world = raked
    with hb.open_studio(raked) as other, page(other.address) as there:
        assert raked.tool in there.hello["tools"]


def test_the_page_is_for_those_who_have_its_token_and_framed_by_notebooks_alone(
    notebook: NotebookStudio,
):
    parts = urlsplit(notebook.address)
    local = f"http://127.0.0.1:{parts.port}/"
    assert get(local, "/")[0] == 403
    with pytest.raises(InvalidStatus), page(local):
        pass
    with (
        pytest.raises(InvalidStatus),
        page(notebook.address, additional_headers={"Origin": "http://localhost:8888"}),
    ):
        pass
    status, _, headers = get(local, f"/?{parts.query}")
    assert status == 200
    frames = headers["content-security-policy"].rpartition("frame-ancestors ")[2]
    assert "http://localhost:*" in frames
    assert "'none'" not in frames
    assert not {"*", "http:", "https:"} & {*frames.split()}
    query = parts.query.replace("&embedded=1", "")
    assert "frame-ancestors 'none'" in get(local, f"/?{query}")[2]["content-security-policy"]


def test_an_edit_for_no_notebook_is_an_error(address: str):
    with page(address) as there:
        assert there.hello["shown"] is None
        answer = there.ask("edit", scene=scene(ROOM), shown=0)
        assert answer["error"].startswith("this studio is not embedded in a notebook; open one")


def test_its_frame_is_html_and_closing_it_ends_server_and_processes():
    with hb.open_studio(ROOM, height=500) as notebook:
        found = re.fullmatch(
            r'<iframe src="([^"]+)" .*height="500".*></iframe>', notebook._repr_html_()
        )
        assert found is not None
        assert unescape(found[1]) == notebook.address
        assert repr(notebook) == f"<NotebookStudio of room: open at {notebook.address}>"
        with page(notebook.address) as there:
            assert there.hello["version"] == hb.__version__
            notebook.close()
            with pytest.raises(ConnectionClosed):
                there.receive()
    assert notebook.closed
    notebook.close()  # again: nothing
    assert repr(notebook) == "<NotebookStudio of room: closed>"
    assert "iframe" not in notebook._repr_html_()
    assert notebook.world is ROOM


def test_behind_a_proxy_the_frame_has_the_proxys_address():
    with hb.open_studio(
        base_path="/user/x/proxy/{port}/", trusted_origin="https://hub.example"
    ) as notebook:
        assert notebook.address.startswith("https://hub.example/user/x/proxy/")
        parts = urlsplit(notebook.address)
        local = f"http://127.0.0.1:{parts.path.split('/')[-2]}/"
        headers = get(local, f"{parts.path}?{parts.query}", "hub.example")[2]
        assert headers["content-security-policy"].endswith(" https://hub.example")


@pytest.mark.parametrize("package", ["uvicorn", "starlette"])
def test_without_the_extra_one_line_says_what_to_install(monkeypatch, package):
    for name in list(sys.modules):
        if name.startswith(("habilis.studio", package)):
            monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(MissingExtraError) as problem:
        _ = hb.open_studio
    words = f"{package} is not installed; run: pip install 'habilis[studio]'"
    assert str(problem.value) == words


def test_a_process_that_forgets_to_close_it_ends_all_the_same():
    code = (
        "import habilis as hb, os\nstudio = hb.open_studio()\nprint(studio.address, flush=True)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    with pytest.raises(OSError, match="refused"):
        get(done.stdout.strip(), "/")
